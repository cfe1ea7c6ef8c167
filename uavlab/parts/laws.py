"""The five laws of `uavlab.interfaces`, tried on a part of one's own: what is broken, in sentences."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from uavlab.frames import Shift, compose, inverse, moved, wrap
from uavlab.orders import ORDERS
from uavlab.so3 import about_z, exp
from uavlab.types import (
    Array,
    Attitude,
    Command,
    Estimate,
    Field,
    Fix,
    Flow,
    Height,
    Imu,
    Pose,
    Range,
    Reference,
    Trajectory,
)

SHIFT = Shift(np.array((3.0, -2.0, 0.5)), 0.4)  # of the worlds that are tried
DT = 0.01  # [s]
SEEDS = 20
CLOSE = 1e-8  # what two ways of computing may differ by
RATES = (0.02, 0.01, 0.005)  # [s], ticks for law 5
FAR = 0.05  # how much the last two of them may differ by
GIVES: Mapping[str, type] = {"estimator": Estimate, "tracker": Reference, "controller": Command}
METHODS = {
    "estimator": ("init", "step", "reframe", "hypotheses"),
    **dict.fromkeys(("tracker", "controller", "mission"), ("init", "step", "reframe")),
}


class Broken(Exception):
    """A law is broken, and how."""


def broken_laws(part: Any) -> list[str]:
    """Which of the laws a part breaks, tried on random inputs: a sentence for each, empty if all of them hold.

    Parameters
    ----------
    part : part
        An estimator, a tracker, a controller or a mission: an object, not its class.

    Returns
    -------
    list of str
        ``law 2 (frame-blind): …``. What is tried is a small part of what can be, so an empty list is no proof.
    """
    slot = getattr(part, "slot", None)
    if slot not in METHODS:
        return [f"it has slot {slot!r}; a part says in its class where it belongs: {_or(METHODS)}."]
    if isinstance(part, type):
        return [f"{part.__name__} is a class; make a part of it: {part.__name__}(…)."]
    missing = [name for name in METHODS[slot] if not callable(getattr(part, name, None))]
    if missing:
        return [f"it has no {' and no '.join(missing)}; a {slot} needs {', '.join(METHODS[slot])}."]
    said = []
    for law, tried in LAWS.items():
        try:
            with np.errstate(all="ignore"):
                tried(part)
        except Broken as how:
            said.append(f"law {law}: {how}")
        except Exception as error:  # a part of one's own may raise anything
            said.append(f"law {law}: it raised {type(error).__name__}: {error}")
    return said


# What is tried ----------------------------------------------------------------------------------------


class Case(NamedTuple):
    """A memory, what a step is told, and the same in another world."""

    memory: Any
    inputs: tuple[Any, ...]
    there: tuple[Any, ...]


def _estimate(rng: np.random.Generator) -> Estimate:
    tilted = exp(np.array((0.0, 0.0, rng.uniform(-3.0, 3.0)))) @ exp(0.25 * rng.normal(size=3))
    r, v, a, omega = 5.0 * rng.normal(size=3), 2.0 * rng.normal(size=3), *rng.normal(size=(2, 3))
    return Estimate(r, v, a, tilted, omega)


def _reference(rng: np.random.Generator, near: Estimate) -> Reference:
    v, a, j = rng.normal(size=(3, 3))
    return Reference(near.r + rng.normal(size=3), v, a, j, rng.uniform(-3.0, 3.0), rng.normal())


def _command(rng: np.random.Generator) -> Command:
    return Command(rng.uniform(10.0, 30.0), 0.3 * rng.normal(size=3), 0.5 * rng.normal(size=3))


def _readings(rng: np.random.Generator, x: Estimate, t: float) -> dict[str, Any]:
    """One reading of each instrument of an aircraft that is at `x`."""
    few = 0.01 * rng.normal(size=(4, 3))
    turned = about_z(rng.uniform(-3.0, 3.0))
    return {
        "imu": Imu(t, x.R.T @ (x.a + np.array((0.0, 0.0, 9.81))), x.omega + few[0]),
        "ahrs": Attitude(t, turned @ x.R),
        "magnetometer": Field(t, x.R.T @ np.array((0.0, 0.42, -0.91))),
        "barometer": Height(t, float(x.r[2])),
        "rangefinder": Range(t, abs(float(x.r[2])) / float(x.R[2, 2])),
        "gnss": Fix(t, x.r + few[1], x.v),
        "rtk": Fix(t, x.r + few[2], x.v, 0.02),
        "flow": Flow(t, (x.R.T @ x.v)[:2]),
        "slam": Pose(t, x.r + few[3], x.R),
        "mocap": Pose(t, x.r + few[3], x.R),
    }


def _cases(part: Any, seeds: int = SEEDS) -> Iterator[Case]:
    """Memories and inputs: right after `init`, and some steps later."""
    for seed in range(seeds):
        rng = np.random.default_rng(seed)
        x = _estimate(rng)
        memory = _begun(part, rng, x)
        for k in range(seed % 3):
            memory = _two(part.step(memory, *_inputs(part, rng, x, k), DT))[0]
        inputs = _inputs(part, rng, x, seed % 3)
        if part.slot == "tracker" and seed % 3 == 2:
            inputs = (x, None)  # the goal of before still stands
        yield Case(memory, inputs, tuple(_there(each) for each in inputs))


def _begun(part: Any, rng: np.random.Generator, x: Estimate) -> Any:
    if part.slot == "tracker":
        return part.init(x, _reference(rng, x))
    return part.init(x, _command(rng)) if part.slot == "controller" else part.init(x)


def _inputs(part: Any, rng: np.random.Generator, x: Estimate, tick: int) -> tuple[Any, ...]:
    if part.slot == "estimator":
        return _readings(rng, x, tick * DT), _command(rng)
    return (x,) if part.slot == "mission" else (x, _reference(rng, x))


def _there(x: Any) -> Any:
    """What a step is told, in the other world."""
    if isinstance(x, dict):
        return {k: moved(v, SHIFT) for k, v in x.items()}
    return None if x is None else moved(x, SHIFT)


# The laws ---------------------------------------------------------------------------------------------


def _gives_what_it_must(part: Any) -> None:
    for case in _cases(part, 3):
        _, out = _two(part.step(case.memory, *case.inputs, DT))
        kind = GIVES.get(part.slot, Reference | Trajectory | None)
        if not (isinstance(out, kind) or (part.slot == "mission" and isinstance(out, ORDERS))):
            raise Broken(f"step gave {type(out).__name__} and not {kind}, as a {part.slot} must.")


def _pure(part: Any) -> None:
    for case in _cases(part, 5):
        before = copy.deepcopy(case)
        first = part.step(case.memory, *case.inputs, DT)
        if not _same(case.memory, before.memory):
            raise Broken("step changes the memory that it was given; let it give back a new one.")
        if not _same(case.inputs, before.inputs):
            raise Broken("step changes what it was told; copy an array before it is written into.")
        second = part.step(case.memory, *case.inputs, DT)
        if not _same(first, second):
            raise Broken(
                "a second step with the same inputs gives something else; what is remembered "
                "belongs into the memory, and not into the part."
            )


def _frame_blind(part: Any) -> None:
    for case in _cases(part):
        kept = copy.deepcopy(case.memory)  # that a step changes it is another law's matter
        memory, out = part.step(kept, *case.inputs, DT)
        there = part.reframe(case.memory, SHIFT)
        memory_there, out_there = part.step(there, *case.there, DT)
        if name := _differs(_told(out), out_there):
            raise Broken(
                f"in a world that is moved by {_short(SHIFT.r)} m and turned by {SHIFT.heading:g} rad, its {name} is "
                "not the same thing told there. What remembers a place or a direction is moved by reframe."
            )
        if not _same(part.reframe(memory, SHIFT), memory_there, CLOSE):
            raise Broken("a reframe behind a step leaves another memory than a reframe before it.")


def _told(out: Any) -> Any:
    """What must come out when all worlds are moved alike; of an estimate, those of the others, too."""
    if out is None or isinstance(out, ORDERS):
        return out
    there = moved(out, SHIFT)
    if isinstance(out, Estimate):
        back = inverse(SHIFT)
        there = there._replace(worlds={k: compose(s, back) for k, s in there.worlds.items()})
    return there


def _bumpless(part: Any) -> None:
    rng = np.random.default_rng(1)
    x, zero = _estimate(rng), np.zeros(3)
    goal, last, command = _reference(rng, x), _reference(rng, x), _command(rng)
    if part.slot == "controller":
        _, out = part.step(part.init(x, command), x, goal, DT)
        _repeats(command, out, command._fields, "command")
    elif part.slot == "tracker":
        _, out = part.step(part.init(x, last), x, goal, DT)
        _repeats(last, out, ("r", "v", "a", "heading"), "reference")
    elif part.slot == "estimator":
        x = x._replace(v=zero, a=zero, omega=zero)
        _, out = part.step(part.init(x), {}, command, DT)
        _repeats(x, out, ("r", "v", "R", "omega"), "estimate")


def _repeats(last: Any, out: Any, names: tuple[str, ...], what: str) -> None:
    for name in names:
        was, now = getattr(last, name), getattr(out, name)
        if not _same(was, now, CLOSE):
            raise Broken(
                f"the first step after init gives {name} = {_short(now)}, and the last {what} had {_short(was)}; "
                "whoever takes over repeats it, and then goes on."
            )


def _finite(part: Any) -> None:
    for case in _cases(part, 2 * SEEDS):
        _, out = part.step(case.memory, *case.inputs, DT)
        for name in getattr(out, "_fields", ()):
            value = getattr(out, name)
            if isinstance(value, float | np.ndarray) and not np.isfinite(value).all():
                raise Broken(f"its {name} is {_short(value)}.")


def _rate_consistent(part: Any) -> None:
    coarse, middle, fine = (_within_a_second(part, dt) for dt in RATES)
    was, now = float(np.abs(middle - coarse).max()), float(np.abs(fine - middle).max())
    if not (now < 0.75 * was + 1e-6 and now < FAR):
        raise Broken(
            f"within a second, steps of {RATES[1]:g} s and of {RATES[2]:g} s differ by {now:.3g}, and those of "
            f"{RATES[0]:g} s and {RATES[1]:g} s by {was:.3g}; does everything that changes in a step change by dt?"
        )


def _within_a_second(part: Any, dt: float) -> Array:
    """Numbers that a part gives soon and late in a second, at rest or on a smooth way, with ticks of `dt` [s]."""
    zero, a = np.zeros(3), np.array((0.5, 0.0, -0.3))
    start = Estimate(np.array((0.0, 0.0, 2.0)), zero, zero, np.eye(3), zero)
    goal = Reference(np.array((0.5, -0.3, 2.5)), zero, zero, zero, 0.5, 0.0)
    memory = part.init(start, *((None,) if part.slot in {"tracker", "controller"} else ()))
    given: Any = (start,) if part.slot == "mission" else (start, goal)
    every, found, out = round(RATES[0] / dt), [], None
    for k in range(1, round(1.0 / dt) + 1):
        t = k * dt
        if part.slot == "estimator":  # seen at the same times at any rate, and speeding up evenly
            now = start._replace(r=start.r + a * t * t / 2, v=a * t, a=a)
            seen = _readings(_Quiet(), now, t) if k % every == 0 else {}  # type: ignore[arg-type]
            given = (seen, Command(20.0, zero, a))
        memory, new = part.step(memory, *given, dt)
        out = out if new is None else new
        if k in {round(0.2 / dt), round(1.0 / dt)}:
            found.append(_numbers(out))
    return np.hstack(found)


def _numbers(out: Any) -> Array:
    """What is compared of an output."""
    if isinstance(out, Command):
        return np.hstack((out.f_d, out.omega_d))
    return out.r if isinstance(out, Reference | Estimate) else np.zeros(3)


class _Quiet:
    """Chance without any."""

    def normal(self, size: tuple[int, ...]) -> Array:
        return np.zeros(size)

    def uniform(self, low: float, high: float) -> float:
        return 0.0


LAWS: Mapping[str, Callable[[Any], None]] = {
    "0 (it fits into its slot)": _gives_what_it_must,
    "1 (pure)": _pure,
    "2 (frame-blind)": _frame_blind,
    "3 (bumpless)": _bumpless,
    "4 (finite)": _finite,
    "5 (rate-consistent)": _rate_consistent,
}


# Comparing --------------------------------------------------------------------------------------------


def _two(given: Any) -> tuple[Any, Any]:
    if not (isinstance(given, tuple) and len(given) == 2):
        raise Broken("step must give two things: the new memory, and what comes out.")
    return given


def _differs(a: Any, b: Any) -> str:
    """The first field of an output that differs; empty if none does."""
    if type(a) is not type(b):
        return f"output ({type(b).__name__}, not {type(a).__name__})"
    if a is None:
        return ""
    for name, x, y in zip(a._fields, a, b, strict=True):
        close = abs(wrap(x - y)) < CLOSE if name == "heading" and np.ndim(x) == 0 else False
        if not (close or _same(x, y, CLOSE)):
            return name
    return ""


def _same(a: Any, b: Any, atol: float = 0.0) -> bool:
    """Whether two memories or outputs are the same, number by number."""
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        return a.keys() == b.keys() and all(_same(a[k], b[k], atol) for k in a)
    if isinstance(a, tuple | list) and isinstance(b, tuple | list):
        return len(a) == len(b) and all(_same(x, y, atol) for x, y in zip(a, b, strict=True))
    if isinstance(a, float | int | np.ndarray | np.number):
        if not isinstance(b, float | int | np.ndarray | np.number) or np.shape(a) != np.shape(b):
            return False
        return np.allclose(a, b, rtol=atol, atol=atol, equal_nan=True)
    inside, other = getattr(a, "__dict__", None), getattr(b, "__dict__", None)
    if inside and type(a) is type(b) and not callable(a):
        return _same(inside, other, atol)
    return a is b or bool(a == b)


def _short(x: Any) -> str:
    return np.array2string(np.asarray(x), precision=3, separator=", ").replace("\n", "")


def _or(names: Mapping[str, Any]) -> str:
    *most, last = names
    return f"{', '.join(most)} or {last}"
