"""001-8: the closed attitude loop and the motion that follows, as linear models, held to flights they have not seen."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from uavlab.experiments.answers import answer
from uavlab.experiments.spec import Band, Experiment, Line, Outcome, Panel, Row
from uavlab.flight.scenario import standing
from uavlab.parts.controllers import Gains, Handover, TiltAxis
from uavlab.parts.missions import still
from uavlab.plant import CompiledPlant, load_airframe
from uavlab.types import GRAVITY, Array, Estimate

NAME = "F550"
RATE, SPAN = 100.0, 20.0  # [Hz] and [s] of one record
TILT_NOISE, VELOCITY_NOISE = 0.005, 0.05  # [rad], [m/s], one sample
GAINS = Gains(k_p=0.0, k_v=0.0)  # the sticks ask for a tilt, not for a place
K_Z, K_VZ = 4.0, 3.0  # [1/s²], [1/s] of the loop that holds the height
FREQUENCIES = np.geomspace(0.1, 2.5, 9)  # [Hz] at which a stick moves
CLIMB = 1.0  # [m], rms, of the height that is asked for
STICK = 0.12  # [rad], rms, in the flights of the fit and of the validation
SWEEP = (0.04, 0.12, 0.35)  # [rad], rms, of the flights at growing speeds
SLOW = 2.0  # [m/s], below which Landing's linear model is best
AHEAD = 1.0  # [s] that it is asked to foretell


class Flown(NamedTuple):
    """One record. Tilts θ, φ are those of the thrust axis over x and over −y, in a frame that keeps the heading."""

    t: Array  # (n,) [s]
    reference: Array  # (n, 2) [rad] θ and φ as asked
    tilt: Array  # (n, 2) [rad] as measured
    v: Array  # (n, 3) [m/s], as measured, in that frame
    lift: Array  # (n,) [m/s²] vertical part of the thrust over the mass, less g


def sticks(rng: np.random.Generator, rms: float, frequencies: Array = FREQUENCIES) -> Array:
    """A tilt (n,) [rad] as a pilot moves it: slow and quick at once, quiet at both ends."""
    t = np.arange(round(SPAN * RATE)) / RATE
    phase = rng.uniform(0.0, 2.0 * np.pi, len(frequencies))
    waves = np.sin(2.0 * np.pi * np.outer(t, frequencies) + phase) @ frequencies**-0.3
    quiet = np.clip(np.minimum(t, SPAN - 1.0 - t), 0.0, 1.0)
    return rms * waves * quiet / np.std(waves)


def flown(rng: np.random.Generator, rms: tuple[float, float]) -> Flown:
    """The F550 under sticks of these sizes [rad] on pitch and roll, with the stand-in's tilt law and the rate loop."""
    airframe = load_airframe(NAME)
    plant, law = CompiledPlant(airframe), TiltAxis(float(airframe.m), GAINS)
    asked = np.column_stack([sticks(rng, x) if x else np.zeros(round(SPAN * RATE)) for x in rms])
    height = 20.0 + sticks(rng, CLIMB, FREQUENCIES[:4])
    world = plant.init(standing((0.0, 0.0, 20.0)))
    tilt, v, lift = np.empty_like(asked), np.empty((len(asked), 3)), np.empty(len(asked))
    for k, (x, y) in enumerate(np.tan(asked).tolist()):
        up = K_Z * (height[k] - world.r[2]) - K_VZ * world.v[2]
        a = np.array((x * (GRAVITY + up), -y * (GRAVITY + up), up))
        here = Estimate(world.r, world.v, world.a, world.R, world.omega)
        reference = still(world.r)._replace(a=a)
        _, command = law.step(Handover(None, None), here, reference, 1.0 / RATE)
        b = world.R[:, 2]
        tilt[k] = np.arctan2((b[0], -b[1]), b[2])
        v[k], lift[k] = world.v, command.f_d * b[2] / airframe.m - GRAVITY
        world = plant.advance(world, command, dt=1.0 / RATE)
    tilt += TILT_NOISE * rng.normal(size=tilt.shape)
    v += VELOCITY_NOISE * rng.normal(size=v.shape)
    return Flown(np.arange(len(asked)) / RATE, asked, tilt, v, lift)


# Models -----------------------------------------------------------------------------------------------


class Models(NamedTuple):
    """What was identified."""

    b: Array  # (2, 3), b_0, b_1, b_r of Landing (12) for θ and for φ
    c: Array  # (3,) [1/s], damping of Landing (11)


def identified(rng: np.random.Generator) -> Models:
    """Both models from flights in which one axis moves at a time."""
    response = answer("identification", "attitude_response")
    b, c = np.empty((2, 3)), np.empty(3)
    for axis in range(2):
        flight = flown(rng, (STICK, 0.0) if axis == 0 else (0.0, STICK))
        b[axis] = response(flight.t, flight.reference[:, axis], flight.tilt[:, axis])
        c[axis], c[2] = damping(flight, axis), damping(flight, 2)
    return Models(b, c)


def pushes(flight: Flown) -> Array:
    """What drives the linear model (n, 3) [m/s²]: g θ, −g φ and the thrust (Landing eq. 11, errata: over the mass)."""
    return np.column_stack((
        GRAVITY * flight.tilt[:, 0], -GRAVITY * flight.tilt[:, 1], flight.lift,
    ))  # fmt: skip


def damping(flight: Flown, axis: int) -> float:
    """Damping c [1/s] of v̇ = push − c v along one axis, from its integral over each second."""
    n = round(RATE)
    gain, way = (_integral(x[:, axis]) for x in (pushes(flight), flight.v))
    left = (gain[n:] - gain[:-n]) - (flight.v[n:, axis] - flight.v[:-n, axis])
    passed = way[n:] - way[:-n]
    return float(passed @ left / (passed @ passed))


def _integral(x: Array) -> Array:
    """Trapezoid sum [x s] from the start."""
    return np.concatenate(((0.0,), np.cumsum((x[1:] + x[:-1]) / (2.0 * RATE))))


def attitude_model(b: Array, reference: Array) -> Array:
    """Tilt (n,) [rad] of Landing (12) from rest, the reference held from sample to sample."""
    from scipy.signal import lsim

    t = np.arange(len(reference)) / RATE
    return lsim(((b[2],), (1.0, b[1], b[0])), reference, t, interp=False)[1]


def motion_model(c: Array, push: Array, v: Array) -> Array:
    """Velocity (n, 3) [m/s] of Landing (11), told the true one again every `AHEAD` seconds."""
    out, n, keep = np.empty_like(v), round(AHEAD * RATE), np.exp(-c / RATE)
    for k in range(len(v)):
        if k % n == 0:
            out[k] = v[k]
        else:
            out[k] = keep * out[k - 1] + (1.0 - keep) / c * push[k - 1]
    return out


def fit(y: Array, model: Array) -> float:
    """One less the relative error [%]: 100 is exact, 0 as good as the mean."""
    return float(100.0 * (1.0 - np.linalg.norm(y - model) / np.linalg.norm(y - y.mean(axis=0))))


# The experiment ---------------------------------------------------------------------------------------


class Judged(NamedTuple):
    """One seed: models, and how well they foretold flights that they had not seen."""

    models: Models
    flight: Flown  # the validation
    attitude: Array  # (2,) [%]
    speed: Array  # (k,) [m/s] mean speed of each second of the sweep
    off: Array  # (k,) [m/s²] error of the velocity after it, over its length


def judged(seed: int) -> Judged:
    """Fit on two flights, validate on a third, then fly faster and faster."""
    rng = np.random.default_rng([seed, 18])
    models = identified(rng)
    flight = flown(rng, (STICK, STICK))
    attitude = [
        fit(flight.tilt[:, i], attitude_model(models.b[i], flight.reference[:, i]))
        for i in range(2)
    ]
    speed, off = zip(*(_errors(models, flown(rng, (x, x))) for x in SWEEP), strict=True)
    return Judged(models, flight, np.array(attitude), np.concatenate(speed), np.concatenate(off))


def _errors(models: Models, flight: Flown) -> tuple[Array, Array]:
    """Mean horizontal speed in each second, and what the model misses of the velocity at its end."""
    n = round(AHEAD * RATE)
    model = motion_model(models.c, pushes(flight), flight.v)
    speed = np.linalg.norm(flight.v[:, :2], axis=1).reshape(-1, n).mean(axis=1)
    off = np.linalg.norm((model - flight.v)[n - 1 :: n, :2], axis=1) / AHEAD
    return speed, off


def attitude_fit(seeds: int) -> Outcome:
    """Landing Sec. 6.1: grey-box identification with separate flights for fit and validation."""
    found = [judged(seed) for seed in range(seeds)]
    attitude = np.array([x.attitude for x in found])
    b, c = np.array([x.models.b for x in found]), np.array([x.models.c for x in found])
    speed, off = np.concatenate([x.speed for x in found]), np.concatenate([x.off for x in found])
    edges = np.array((0.0, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0))
    bins = [(lo <= speed) & (speed < hi) for lo, hi in pairwise(edges)]
    slow, fast = off[speed < SLOW].mean(), off[speed >= SLOW].mean()
    least = min(off[x].mean() for x in bins[2:] if x.any())
    coincide, good = "“almost always coincide”", Band(85.0, np.inf)
    rows = (
        Row("fit of θ on the validation flight [%]", coincide, attitude[:, 0].mean(), good, attitude[:, 0].std()),
        Row("fit of φ on the validation flight [%]", coincide, attitude[:, 1].mean(), good, attitude[:, 1].std()),
        Row("worst of them [%]", "—", attitude.min(), good),
        Row(f"acceleration off by, below {SLOW:g} m/s [m/s²]", "best at low velocity", slow),
        Row(f"acceleration off by, above {SLOW:g} m/s [m/s²]", "—", fast),
        Row(f"the least above {SLOW:g} m/s, over that below", "above 1", least / slow, Band(1.0, np.inf)),
        *(Row(f"b_{x} of θ", "—", b[:, 0, i].mean(), None, b[:, 0, i].std()) for i, x in enumerate("01r")),
        *(Row(f"c_{x} [1/s]", "—", c[:, i].mean(), None, c[:, i].std()) for i, x in enumerate("xyz")),
    )  # fmt: skip
    remarks = (
        f"The F550 with the stand-in's tilt law (8 1/s) and its embedded rate loop, at {RATE:g} Hz; tilt and "
        f"velocity with {TILT_NOISE} rad and {VELOCITY_NOISE} m/s of noise.",
        "Fit: pitch alone, then roll alone; validation: both at once.",
        "True damping: of the rotors 0.0794·√9.81 = 0.249 1/s along x and y, none along z; of the body, more "
        "the faster it is.",
        f"Error of the motion: what (11) misses of the velocity after {AHEAD:g} s, told the tilt as measured. Above "
        f"{SLOW:g} m/s it grows because g θ is not g tan θ, and because the body's drag is quadratic.",
    )  # fmt: skip
    centres = np.array([speed[x].mean() for x in bins if x.any()])
    means = np.array([off[x].mean() for x in bins if x.any()])
    return Outcome(rows, _panels(found[0], speed, off, centres, means), remarks)


def _panels(
    one: Judged, speed: Array, off: Array, centres: Array, means: Array
) -> tuple[Panel, ...]:
    flight, part = one.flight, slice(round(4 * RATE), round(12 * RATE))
    t, v = flight.t[part], motion_model(one.models.c, pushes(flight), flight.v)
    panels = [
        Panel(f"Landing Fig. 6: {name}", "time [s]", f"{name} [rad]", (
            Line("asked", t, flight.reference[part, i], "dashed"),
            Line("flown", t, flight.tilt[part, i], "truth"),
            Line("model (12)", t, attitude_model(one.models.b[i], flight.reference[:, i])[part]),
        )) for i, name in enumerate("θφ")
    ]  # fmt: skip
    panels += [
        Panel("Landing Fig. 6: velocity along x", "time [s]", "velocity [m/s]", (
            Line("flown", t, flight.v[part, 0], "truth"),
            Line(f"model (11), told anew each {AHEAD:g} s", t, v[part, 0]),
        )),
        Panel("Where the linear model holds", "speed [m/s]", "acceleration off by [m/s²]", (
            Line("each second", speed[::5], off[::5], "points"),
            Line("mean", centres, means),
        ), ((SLOW, "2 m/s"),)),
    ]  # fmt: skip
    return tuple(panels)


EXPERIMENTS = (
    Experiment("001-8", "Attitude loop and linear model", "Landing Sec. 6.1, Fig. 6", attitude_fit),
)
