"""A fault, as a line of a scenario: what there is, and what a scenario may say."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import inf, isfinite, isnan
from typing import Any, NamedTuple

import numpy as np

from uavlab.errors import BadInput, UnknownName

KINDS: Mapping[str, str] = {
    "lost": "Nothing arrives of instrument `what`.",
    "frozen": "Instrument `what` goes on telling what it told last, with new time stamps.",
    "jump": "`value` is added to what instrument `what` reads, at once.",
    "bias": "An error grows on what instrument `what` reads, by `value` each second.",
    "late": "Readings of instrument `what` arrive `value` seconds later, with the time stamps they have.",
    "nan": "Position, velocity and acceleration of the estimate are no numbers; what = 'all': attitude and rates, too.",
    "solver": "No quadratic programme finds a plan; who plans flies on what was planned before.",
    "part": "Part `what` (estimator, tracker or controller) 'raises', or gives what is 'nan', as `value` says.",
    "motor": (
        "Rotor `what` makes the share `value` of the thrust that is asked of it. Below a tenth the autopilot knows "
        "after 0.2 s and does without it: a hexacopter flies on, a quadrotor falls."
    ),
    "battery": "The thrust of all rotors sags from `t` on, to the share `value` at `until`, and stays there.",
    "payload": "A load of `value` kg, of which the mind is not told, hangs on until `t`, and drops then.",
    "gust": "A gust of (1 − cos) shape passes from `t` to `until`; `value` (3,) m/s is its peak, world.",
    "link": "What a mission or an operator asks is not heard.",
}
HOW = ("raises", "nan")  # how a part may fail
BROKEN = ("estimator", "tracker", "controller")  # slots whose parts may fail
OF_PLANT = ("motor", "battery", "payload")  # what only a plant that we know can suffer
_SLACK = 1e-9  # [s], for times that are sums of ticks
# What can be wrong with a reading, by instrument: field → how many numbers. The first is meant if none is named.
FIELDS: Mapping[str, Mapping[str, int]] = {
    "imu": {"accel": 3, "gyro": 3},
    "ahrs": {"R": 3},
    "magnetometer": {"m": 3},
    "barometer": {"z": 1},
    "rangefinder": {"d": 1},
    "gnss": {"r": 3, "v": 3},
    "rtk": {"r": 3, "v": 3},
    "flow": {"v_B": 2},
    "slam": {"r": 3, "R": 3},
    "mocap": {"r": 3, "R": 3},
    "bearings": {"b": 3},
}


class Fault(NamedTuple):
    """Something breaks at `t`, and is whole again at `until`. `KINDS` says what there is."""

    kind: str  # one of `KINDS`
    t: float  # [s]
    until: float = inf  # [s]
    what: str = ""  # instrument or instrument.field; slot or slot.part; rotor, counted from 0
    value: Any = 0.0  # how much, in the unit of its kind

    def lasts(self, t: float) -> bool:
        """Whether it is there at time `t` [s]."""
        return self.t <= t + _SLACK and t + _SLACK < self.until

    @property
    def name(self) -> str:
        """The instrument, slot or rotor alone."""
        return str(self.what).partition(".")[0]

    @property
    def of(self) -> str:
        """The field of the instrument, or the part of the slot; empty: the first one."""
        return str(self.what).partition(".")[2]


def told(faults: tuple[Fault, ...], duration: float) -> list[list[Any]]:
    """Faults for a log: kind, t, until, what, value; times end with the flight of `duration` [s]."""
    return [
        [x.kind, min(x.t, duration), min(x.until, duration), str(x.what), _plain(x.value)]
        for x in faults
    ]


def checked_faults(scenario: Any) -> None:
    """Refuse what cannot break, or not so.

    Raises
    ------
    BadInput
        Names every fault that is wrong, what it says, and what it may say.
    """
    wrong = [
        f"faults[{k}] ({fault.kind!r}): {why}"
        for k, fault in enumerate(scenario.faults)
        for why in _wrong(fault, scenario)
    ]
    if wrong:
        raise BadInput(f"scenario {scenario.name!r}: " + "; ".join(wrong))


def _wrong(fault: Fault, scenario: Any) -> list[str]:
    if fault.kind not in KINDS:
        return [str(UnknownName("kind of fault", fault.kind, KINDS))]
    times = _times(fault)
    if times:
        return [times]
    return [why for check in _CHECKS[fault.kind] if (why := check(fault, scenario))]


# Each of these says what is wrong; nothing if nothing is ----------------------------------------------


def _times(fault: Fault) -> str:
    for name in ("t", "until"):
        value = getattr(fault, name)
        if not _number(value, inf):
            return f"{name} is {value!r}; it must be a time ≥ 0 in s."
    return "" if fault.t < fault.until or fault.t == inf else (
        f"until is {fault.until:g} s; it must be later than t = {fault.t:g} s."
    )  # fmt: skip


def _ends(fault: Fault, _: Any) -> str:
    return "" if isfinite(fault.until) else "until is missing; say when it has its full size."


def _instrument(fault: Fault, scenario: Any) -> str:
    if fault.name not in scenario.sensors:
        return str(UnknownName("instrument aboard", fault.name, scenario.sensors))
    known = FIELDS.get(fault.name)
    if fault.of and known is not None and fault.of not in known:
        return str(UnknownName(f"field of {fault.name}", fault.of, known))
    return ""


def _size(fault: Fault, _: Any) -> str:
    known = FIELDS.get(fault.name, {})
    n = known.get(fault.of, 0) if fault.of else next(iter(known.values()), 0)
    wanted = f"a number, or {n}" if n > 1 else "a number"
    x = _array(fault.value)
    if x is None or x.ndim > 1 or (x.ndim and n and x.size != n):
        return f"value is {fault.value!r}; it must be {wanted}, finite."
    return ""


def _share(fault: Fault, _: Any) -> str:
    good = _number(fault.value, 1.0)
    return "" if good else f"value is {fault.value!r}; it must be a share from 0 to 1."


def _positive(unit: str) -> Callable[[Fault, Any], str]:
    def check(fault: Fault, _: Any) -> str:
        good = _number(fault.value, inf) and 0.0 < fault.value < inf
        return "" if good else f"value is {fault.value!r}; it must be > 0 {unit}."

    return check


def _vector(fault: Fault, _: Any) -> str:
    x = _array(fault.value)
    good = x is not None and x.shape == (3,)
    return "" if good else f"value is {fault.value!r}; it must be three numbers in m/s."


def _rotor(fault: Fault, scenario: Any) -> str:
    from uavlab.plant import load_airframe

    n = load_airframe(scenario.airframe).n
    good = str(fault.what).isdecimal() and int(fault.what) < n
    return "" if good else f"what is {fault.what!r}; {scenario.airframe} has rotors 0 to {n - 1}."


def _part(fault: Fault, _: Any) -> str:
    if fault.name not in BROKEN:
        return str(UnknownName("slot", fault.name, BROKEN))
    if fault.value not in HOW:
        return f"value is {fault.value!r}; it must be {' or '.join(map(repr, HOW))}."
    return ""


def _one_of(*known: str) -> Callable[[Fault, Any], str]:
    def check(fault: Fault, _: Any) -> str:
        said = " or ".join(repr(x) for x in known)
        return "" if fault.what in known else f"what is {fault.what!r}; it must be {said}."

    return check


def _number(value: Any, most: float) -> bool:
    """Whether it is a number from 0 to `most`."""
    plain = isinstance(value, int | float | np.number) and not isinstance(value, bool)
    return bool(plain and not isnan(value) and 0.0 <= value <= most)


def _array(value: Any) -> np.ndarray | None:
    """The value as finite numbers; None if it is something else."""
    try:
        x = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        return None
    return x if np.isfinite(x).all() and not isinstance(value, str | bool) else None


def _plain(value: Any) -> Any:
    """A value that JSON knows."""
    return np.asarray(value).tolist() if not isinstance(value, str) else value


_NOTHING = _one_of("")
_CHECKS: Mapping[str, tuple[Callable[[Fault, Any], str], ...]] = {
    "lost": (_instrument,),
    "frozen": (_instrument,),
    "jump": (_instrument, _size),
    "bias": (_instrument, _size),
    "late": (_instrument, _positive("s")),
    "nan": (_one_of("", "all"),),
    "solver": (_NOTHING,),
    "part": (_part,),
    "motor": (_rotor, _share),
    "battery": (_NOTHING, _ends, _share),
    "payload": (_NOTHING, _positive("kg")),
    "gust": (_NOTHING, _ends, _vector),
    "link": (_NOTHING,),
}
