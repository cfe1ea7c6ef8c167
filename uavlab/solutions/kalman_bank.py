"""Lab 03, the reference answers: one linear Kalman filter, a bank of them, who flies, and what a switch does.

Papers: MRS is Baca et al. 2021. Numbers in comments are its equations; where the errata correct one, the line says so.
Here Q is the covariance of what the model misses in one step (the MRS software multiplies its own by dt).
"""

# canary-9bd9b7aacbc10f2af4d14a95

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import inf
from typing import Any, NamedTuple

import numpy as np

from uavlab import frames
from uavlab.covariance import check_arrays, check_covariance
from uavlab.errors import BadInput, UnknownName
from uavlab.interfaces import Memory, Readings
from uavlab.so3 import about_z, exp, hat
from uavlab.sources import STATES, check_members, late, measured, parted
from uavlab.types import (
    NO_SHIFT,
    Array,
    Command,
    Estimate,
    Fix,
    Flow,
    Hypothesis,
    Mat3,
    Range,
    Reference,
    Shift,
    Vec3,
)

STAY = 0.5  # share of the current trace below which another one is worth a switch

# One filter -------------------------------------------------------------------------------------------


def translation_model(dt: float, p: float) -> tuple[Array, Array]:
    """Model of one axis (MRS eq. 10, with a = p and b = 1 - p as in 8, 9)."""
    A = np.array(((1.0, dt, 0.5 * dt**2), (0.0, 1.0, dt), (0.0, 0.0, p)))  # (10)
    B = np.array((
        (0.0,),
        (0.0,),
        (1.0 - p,),
    ))  # (10); errata: (9) is block-diagonal, a column an axis
    return A, B


def heading_model(dt: float, p: float) -> tuple[Array, Array]:
    """Model of the heading (MRS eq. 11, with a = p and b = 1 - p as in 8, 9)."""
    return np.array(((1.0, dt), (0.0, p))), np.array(((0.0,), (1.0 - p,)))  # (11)


def predict(x: Array, P: Array, u: Array, A: Array, B: Array, Q: Array) -> tuple[Array, Array]:
    """One step of the model (MRS eq. 7), and of its covariance."""
    n, k = x.size, u.size
    check_arrays(
        x=(x, (n,)), u=(u, (k,)), A=(A, (n, n)), B=(B, (n, k)), P=(P, (n, n)), Q=(Q, (n, n))
    )
    check_covariance("P", P)
    check_covariance("Q", Q, singular=True)
    return _predicted(x, P, u, A, B, Q)


def correct(x: Array, P: Array, z: Array, H: Array, R_z: Array) -> tuple[Array, Array, float]:
    """One measurement: Joseph's form, which keeps P symmetric and positive definite."""
    n, m = x.size, z.size
    check_arrays(x=(x, (n,)), z=(z, (m,)), H=(H, (m, n)), P=(P, (n, n)), R_z=(R_z, (m, m)))
    check_covariance("P", P)
    check_covariance("R_z", R_z)
    x, P, nis = _corrected(x, P, z - H @ x, H, R_z)
    return x, P, float(nis)


def _predicted(x: Array, P: Array, u: Array, A: Array, B: Array, Q: Array) -> tuple[Array, Array]:
    """`predict` of one filter, or of a stack: leading axes count filters."""
    x = (A @ x[..., None] + B @ u[..., None])[..., 0]  # (7)
    return x, A @ P @ A.mT + Q


def _corrected(x: Array, P: Array, nu: Array, H: Array, R_z: Array) -> tuple[Array, ...]:
    """`correct` of one filter, or of a stack, with the innovations (..., m)."""
    inverse = np.linalg.inv(H @ P @ H.T + R_z)
    K = P @ H.T @ inverse
    nis = (nu[..., None, :] @ inverse @ nu[..., None])[..., 0, 0]
    x = x + (K @ nu[..., None])[..., 0]
    rest = np.eye(x.shape[-1]) - K @ H
    P = rest @ P @ rest.mT + K @ R_z @ K.mT
    return x, 0.5 * (P + P.mT), nis


# A bank of them ---------------------------------------------------------------------------------------

PERIOD = 0.01  # [s], the step that p belongs to
DOUBT = 3.0  # a fix whose own error is more times what the bank was told is not taken


class Bank(NamedTuple):
    """Memory: what all M members share, and a row for each; S sources in the order of their use."""

    t: float  # [s] the newest time heard of, carried on; −inf before
    last: dict[str, float]  # instrument → time [s] of its last reading
    R: Mat3  # (3, 3) attitude of the autopilot, of which only the tilt counts
    omega: Vec3  # (3,) [rad/s], body
    world: Shift  # from the world of the start to the one of now
    x: Array  # (M, 3, 3)
    P: Array  # (M, 3, 3, 3)
    h: Array  # (M, 2)
    P_h: Array  # (M, 2, 2)
    age: Array  # (M, S) [s] since a reading was taken; inf before the first
    nis: Array  # (M, S) running mean, per degree of freedom
    reliable: Array  # (M,) bool
    rejected: Array  # (M,) int


@dataclass(frozen=True)
class KalmanBank:
    """Filters in parallel, each of four small ones that do not know of each other (MRS Sec. 3.5)."""

    members: dict[str, tuple[str, ...]]
    variances: dict[str, float]
    p: tuple[float, float, float] = (0.9, 0.9, 1.0)
    q_xy: tuple[float, float, float] = (0.1, 1.0, 1.0)
    q_z: tuple[float, float, float] = (0.1, 1.0, 1.0)
    q_heading: tuple[float, float] = (0.01, 1.0)
    start: tuple[float, float, float, float, float] = (1.0, 1.0, 1.0, 0.1, 0.1)
    gate: float = 25.0
    forget: float = 0.05
    limits: tuple[float, float] = (2.0, 4.0)
    patience: float = 1.0
    tilt: float = 0.52

    def __post_init__(self) -> None:
        check_members(self.members, self.variances)
        for name in ("q_xy", "q_z", "q_heading", "start", "gate", "patience"):
            if not np.greater(getattr(self, name), 0.0).all():
                raise BadInput(f"{name} = {getattr(self, name)}: all of it must be above 0.")

    @cached_property
    def _sources(self) -> list[str]:
        """All that anybody hears, in the order of use."""
        used = {source for own in self.members.values() for source in own}
        return sorted(used, key=lambda s: (list(STATES).index(parted(s)[1]), s))

    @cached_property
    def _hears(self) -> Array:
        """Whether a member (row) hears a source (column), shape (M, S)."""
        return np.array([[s in own for s in self._sources] for own in self.members.values()])

    def init(self, estimate: Estimate) -> Memory:
        """All of them believe the estimate; who lives in its world has started, the others wait."""
        M, S = self._hears.shape
        own = np.array([name == estimate.world for name in self.members])
        x = np.column_stack((estimate.r, estimate.v, estimate.a))
        h = (frames.heading(estimate.R), _heading_rate(estimate.R, estimate.omega))
        variance = np.diag(np.square(self.start))
        return Bank(
            -inf, {}, estimate.R, estimate.omega, NO_SHIFT,
            x=np.tile(x, (M, 1, 1)), P=np.tile(variance[:3, :3], (M, 3, 1, 1)),
            h=np.tile(h, (M, 1)), P_h=np.tile(variance[3:, 3:], (M, 1, 1)),
            age=np.where(own[:, None], np.zeros((M, S)), inf), nis=np.ones((M, S)),
            reliable=own, rejected=np.zeros(M, dtype=int),
        )  # fmt: skip

    def step(
        self, memory: Memory, readings: Readings, command: Command, dt: float, flies: str = ""
    ) -> tuple[Memory, dict[str, Hypothesis]]:
        """Predict all, correct each with what it hears, then ask which are healthy."""
        if flies and flies not in self.members:
            raise UnknownName("member", flies, self.members)
        m, sane = self._sort_out(memory, readings, dt)
        m = self._ahead(m, command.a_d, dt, flies)
        for s, source in enumerate(self._sources):
            instrument, quantity = parted(source)
            if instrument in sane:
                m = self._hear(m, s, quantity, sane[instrument])
        m = m._replace(reliable=self._healthy(m))
        nis = np.average(m.nis, axis=1, weights=self._hears)
        rows = zip(m.x, m.P, m.h, m.P_h, nis.tolist(), m.reliable.tolist(), strict=True)
        return m, {name: Hypothesis(*row) for name, row in zip(self.members, rows, strict=True)}

    def reframe(self, memory: Memory, shift: Shift) -> Memory:
        """All worlds moved alike. Both horizontal axes have one covariance: a turn leaves it as it is."""
        Rz, h = about_z(shift.heading), memory.h + np.array((shift.heading, 0.0))
        x = Rz @ memory.x
        x[:, :, 0] += shift.r
        h[:, 0] = frames.wrap(h[:, 0])
        world = frames.compose(shift, memory.world)
        return memory._replace(R=Rz @ memory.R, world=world, x=x, h=h)

    def rejected(self, memory: Memory) -> dict[str, int]:
        """Readings that each member did not take."""
        return dict(zip(self.members, memory.rejected.tolist(), strict=True))

    def _sort_out(self, m: Bank, readings: Readings, dt: float) -> tuple[Bank, dict[str, Any]]:
        """The readings that can be true, and what all share: clock and attitude."""
        t, last, bad, sane = m.t + dt, dict(m.last), m.rejected, dict[str, Any]()
        for name, reading in readings.items():
            finite = all(np.isfinite(x).all() for x in reading)
            off = t > -inf and abs(t - reading.t) > self.patience
            if finite and not off and reading.t > last.get(name, -inf):
                sane[name], last[name] = reading, reading.t
            else:  # the attitude concerns everybody
                heard = [name in {"attitude", parted(s)[0]} for s in self._sources]
                bad = bad + self._hears[:, heard].any(axis=1)
        t = max([t, *(x.t for x in sane.values())])
        omega = sane["imu"].gyro if "imu" in sane else m.omega
        R = sane["attitude"].R if "attitude" in sane else m.R @ exp(omega * dt)
        return m._replace(t=t, last=last, R=R, omega=omega, age=m.age + dt, rejected=bad), sane

    def _ahead(self, m: Bank, a_d: Vec3, dt: float, flies: str) -> Bank:
        """One step of the model (MRS eq. 7-11), the heading without an input (Sec. 3.1.1)."""
        left = [p ** (dt / PERIOD) for p in self.p]
        A, B, Q = _axes(dt, left[0], left[1], tuple(self.q_xy), tuple(self.q_z))
        eta = m.h[list(self.members).index(flies), 0] if flies else m.h[:, 0]
        u = _turned(np.tile(a_d, (len(m.x), 1)), m.h[:, 0] - eta)  # in each member's world
        x, P = _predicted(m.x, m.P, u[..., None], A, B, Q)
        A, B = heading_model(dt, left[2])
        h, P_h = _predicted(m.h, m.P_h, np.zeros(1), A, B, dt * np.diag(self.q_heading))
        h[:, 0] = frames.wrap(h[:, 0])
        return m._replace(x=x, P=P, h=h, P_h=P_h)

    def _hear(self, m: Bank, s: int, quantity: str, reading: Any) -> Bank:
        """One reading: taken as it is the first time and after a long silence, else weighed."""
        source, hears, (axes, i) = self._sources[s], self._hears[:, s], STATES[quantity]
        if not self._usable(source, reading, m.R):
            return m._replace(rejected=m.rejected + hears)
        turns = axes is None
        old_x, old_P = (m.h[:, None], m.P_h[:, None]) if turns else (m.x[:, axes], m.P[:, axes])
        H = late(i, max(m.t - reading.t, 0.0), old_x.shape[-1])
        R_z = np.array([[self.variances[source]]])
        nu = _measured(m, source, reading)[..., None] - old_x @ H.T
        nu = frames.wrap(nu) if quantity == "heading" else nu
        x, P, each = _corrected(old_x, old_P, nu, H, R_z)
        nis = each.mean(axis=1)
        fresh = hears & (m.age[:, s] > self.patience)
        if fresh.any():
            x[fresh], P[fresh] = _started(old_x[fresh], old_P[fresh], nu[fresh], i, R_z)
            if quantity == "heading":
                m = self._turned_along(m, np.where(fresh, nu[:, 0, 0], 0.0))
        taken, weighed = fresh | (hears & (nis <= self.gate)), hears & ~fresh
        x[~taken], P[~taken] = old_x[~taken], old_P[~taken]
        age, mean = m.age.copy(), m.nis.copy()
        age[taken, s] = 0.0
        mean[weighed, s] += self.forget * (nis.clip(max=self.gate) - mean[:, s])[weighed]
        m = m._replace(age=age, nis=mean, rejected=m.rejected + (hears & ~taken))
        if turns:
            x[:, 0, 0] = frames.wrap(x[:, 0, 0])
            return m._replace(h=x[:, 0], P_h=P[:, 0])
        new_x, new_P = m.x.copy(), m.P.copy()
        new_x[:, axes], new_P[:, axes] = x, P
        return m._replace(x=new_x, P=new_P)

    def _usable(self, source: str, reading: Any, R: Mat3) -> bool:
        """Whether an instrument sees what it is meant to see, and believes itself."""
        if isinstance(reading, Flow | Range):
            return bool(R[2, 2] >= np.cos(self.tilt))
        says = isinstance(reading, Fix) and not source.endswith(".velocity")
        return not says or reading.std**2 <= DOUBT**2 * self.variances[source]

    def _turned_along(self, m: Bank, turn: Array) -> Bank:
        """Motion of members whose heading is new, where no instrument tells it."""
        tells = np.array([s.endswith((".velocity", ".position")) for s in self._sources])
        told = (self._hears & tells & (m.age <= self.patience)).any(axis=1)
        x, turn = m.x.copy(), np.where(told, 0.0, turn)
        x[:, :, 1], x[:, :, 2] = _turned(x[:, :, 1], turn), _turned(x[:, :, 2], turn)
        return m._replace(x=x)

    def _healthy(self, m: Bank) -> Array:
        """All of its instruments were heard lately, and none surprises it (with hysteresis)."""
        heard = (m.age <= self.patience) | ~self._hears
        limit = np.where(m.reliable, max(self.limits), min(self.limits))
        return heard.all(axis=1) & (np.where(self._hears, m.nis, 0.0).max(axis=1) < limit)


@lru_cache(maxsize=8)
def _axes(dt: float, p_xy: float, p_z: float, q_xy: tuple, q_z: tuple) -> tuple[Array, ...]:
    """A, B and Q of the three axes, stacked."""
    flat, up = translation_model(dt, p_xy), translation_model(dt, p_z)
    A, B = (np.stack((a, a, c)) for a, c in zip(flat, up, strict=True))
    return A, B, dt * np.stack([np.diag(q) for q in (q_xy, q_xy, q_z)])


def _measured(m: Bank, source: str, reading: Any) -> Array:
    """What a reading says, told in the world of each member: (M, axes)."""
    if source == "imu.heading_rate":
        return np.full((len(m.h), 1), _heading_rate(m.R, reading.gyro))
    if not isinstance(reading, Flow):
        return np.tile(measured(source, reading, m.R, 0.0, m.world), (len(m.h), 1))
    v = [measured(source, reading, m.R, climb) for climb in m.x[:, 2, 1]]
    return _turned(np.array(v), m.h[:, 0] - frames.heading(m.R))


def _heading_rate(R: Mat3, omega: Vec3) -> float:
    """Heading rate of a body that turns (MRS eq. 15)."""
    R_dot = R @ hat(omega)
    return (R[0, 0] * R_dot[1, 0] - R[1, 0] * R_dot[0, 0]) / (R[0, 0] ** 2 + R[1, 0] ** 2)


def _started(x: Array, P: Array, nu: Array, i: int, R_z: Array) -> tuple[Array, Array]:
    """State i taken as it was measured, and known as well as that: written into `x` and `P`."""
    x[:, :, i] += nu[:, :, 0]
    P[:, :, i, :] = P[:, :, :, i] = 0.0
    P[:, :, i, i] = R_z[0, 0]
    return x, P


def _turned(v: Array, angle: Array) -> Array:
    """Vectors (M, 2) or (M, 3), each turned about z by its angle (M,) [rad]."""
    c, s, new = np.cos(angle), np.sin(angle), v.copy()
    new[:, 0], new[:, 1] = c * v[:, 0] - s * v[:, 1], s * v[:, 0] + c * v[:, 1]
    return new


# Who flies, and what a switch does --------------------------------------------------------------------


def arbitrate(hypotheses: Mapping[str, Hypothesis], current: str, request: str) -> str:
    """The three rules of MRS Sec. 3.5, with a hysteresis in the third, of which the paper says nothing."""
    for name in {current, request or current} - hypotheses.keys():
        raise UnknownName("hypothesis", name, hypotheses)
    reliable = [name for name, x in hypotheses.items() if x.reliable]
    if request in reliable:
        return request
    if not reliable:
        return current
    spread = {name: x.P[:, 0, 0].sum() for name, x in hypotheses.items()}  # errata: positions only
    best = min(reliable, key=spread.__getitem__)  # errata: over k, not over x
    stays = current in reliable and spread[best] >= STAY * spread[current]
    return current if stays else best


def shift_between(a: Hypothesis, b: Hypothesis) -> Shift:
    """The 4-DOF map that takes the aircraft of `a` to that of `b` (MRS Sec. 3.5)."""
    turn = frames.wrap(b.h[0] - a.h[0])
    return Shift(b.x[:, 0] - about_z(turn) @ a.x[:, 0], turn)


def moved_reference(reference: Reference, shift: Shift) -> Reference:
    """Points are turned and shifted, vectors turned; what is a rate about the vertical stays (MRS Sec. 3.5)."""
    Rz = about_z(shift.heading)
    r, v, a, j, heading, rate = reference
    return Reference(Rz @ r + shift.r, Rz @ v, Rz @ a, Rz @ j, heading + shift.heading, rate)
