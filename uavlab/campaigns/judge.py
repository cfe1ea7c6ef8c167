"""What a flight must keep to, whatever breaks in it: told from its log, which holds the truth."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from uavlab.flight.log import UNITS, Log
from uavlab.flight.worlds import told
from uavlab.types import Array, Exit, Vec3

SOFT = 3.0  # [m/s], the touch-down that the feet bear; a harder one is a crash
ESTIMATE = {"r_e", "v_e", "R_e"}  # what may be no number while an estimator is told to fail
LOW = {"taking off", "going home", "landing", "emergency", "failsafe"}  # modes that go below `low`
ON_ITS_WAY = LOW | {"evading"}  # modes in which nothing may end but by touching down
ABOVE = 1e-6  # [m], rounding


def touch_down(log: Log) -> float | None:
    """Speed of the hardest touch-down [m/s]; None if it never came down."""
    down = (log.r[1:, 2] <= 0.0) & (log.r[:-1, 2] > 0.0)
    speeds = [_speed(log, int(k)) for k in np.flatnonzero(down)]
    return max(speeds, default=None)


def _speed(log: Log, k: int) -> float:
    """At the ground, which it meets within the tick after `k`."""
    v: Vec3 = log.v[k]
    within = float(log.r[k, 2] / max(-v[2], 1e-9))
    return float(np.linalg.norm(v + log.a[k] * min(within, log.meta["dt"])))


def modes(log: Log) -> list[tuple[float, str]]:
    """The modes that the pilot went through, and since when [s]."""
    return [(t, name) for t, kind, name, _ in log.meta.get("events", []) if kind == "mode"]


def mode_of(log: Log) -> Array:
    """The mode in each tick, shape (N,); empty before the first."""
    out = np.full(len(log.t), "", dtype="<U20")
    for t, name in modes(log):
        out[log.t >= t - 1e-9] = name
    return out


def violations(log: Log) -> Iterator[str]:
    """What a flight did that it must not do, in sentences; nothing if it ended as it should."""
    yield from _ending(log)
    if log.meta.get("traceback"):
        yield f"a part raised: {log.meta['traceback'].strip().splitlines()[-1]}"
    yield from _numbers(log)
    yield from _places(log)


def _ending(log: Log) -> Iterator[str]:
    last = modes(log)[-1][1] if modes(log) else ""
    if log.exit not in {Exit.DONE, Exit.LANDED, Exit.FAILSAFE}:
        yield f"it ended with {log.exit.name}: {log.reason}"
    elif log.exit is Exit.DONE and last in ON_ITS_WAY:
        yield f"its time was over while it was {last!r}"
    hardest = touch_down(log)
    if hardest is not None and hardest >= SOFT:
        yield f"it touched down at {hardest:.2f} m/s"


def _numbers(log: Log) -> Iterator[str]:
    untold = [x for x in log.meta.get("faults", []) if _tells_nothing(*x)]
    for name in UNITS:
        bad = ~np.isfinite(getattr(log, name)).reshape(len(log.t), -1).all(axis=1)
        if name in ESTIMATE:
            for _, since, until, *_ in untold:
                bad &= (log.t < since - 1e-9) | (log.t > until + log.meta["dt"])
        if bad.any():
            yield f"{name} is not a number at t = {log.t[bad][0]:.2f} s"


def _tells_nothing(kind: str, _since: float, _until: float, what: str, value: Any) -> bool:
    """Whether a fault makes an estimate that is no number."""
    return kind == "nan" or (kind == "part" and what.startswith("estimator") and value == "nan")


def _places(log: Log) -> Iterator[str]:
    """Where the reference left the safety area: sideways, above it, or below it when nobody took off or came down."""
    area: dict[str, Any] | None = log.meta.get("area")
    if area is None or not len(log.t):
        return
    r, mode = told(log).r_d, mode_of(log)
    known = np.isfinite(r).all(axis=1)
    border, high = np.array(area["border"]), float(area["high"])
    outside = {
        "outside the border": ~inside(r, border),
        f"above {high:g} m": r[:, 2] > high + ABOVE,
    }
    low = ~np.isin(mode, sorted(LOW | {"ground", "landed"}))
    outside[f"below {area['low']:g} m"] = low & (r[:, 2] < area["low"] - ABOVE)
    for zone in area["no_fly"]:
        within = (r[:, 2] > float(zone["low"]) + ABOVE) & (r[:, 2] < float(zone["high"]) - ABOVE)
        outside[f"in no-fly zone {zone['name']!r}"] = within & inside(r, np.array(zone["border"]))
    for what, bad in outside.items():
        if (bad & known).any():
            k = int(np.flatnonzero(bad & known)[0])
            yield (
                f"its reference was {what} for {(bad & known).sum() * log.meta['dt']:.2f} s, first at "
                f"t = {log.t[k]:.2f} s, at ({', '.join(f'{x:.2f}' for x in r[k])}) m, {str(mode[k])!r}"
            )


def inside(r: Array, border: Array) -> Array:
    """Whether places (N, 3) [m] lie within a border (K, 2) [m] as seen from above, shape (N,): a ray to the right."""
    x, y = r[:, :1], r[:, 1:2]
    (x0, y0), (x1, y1) = border.T, np.roll(border, -1, axis=0).T
    with np.errstate(divide="ignore", invalid="ignore"):
        crossed = ((y0 > y) != (y1 > y)) & (x < (x1 - x0) * (y - y0) / (y1 - y0) + x0)
    return crossed.sum(axis=1) % 2 == 1
