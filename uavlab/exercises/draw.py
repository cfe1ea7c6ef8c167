"""Random inputs for the checks: every draw takes the generator that the check was given."""

from __future__ import annotations

import numpy as np

from uavlab import so3
from uavlab.types import Array, Hypothesis, Mat3, Reference, State, Vec3


def vector(rng: np.random.Generator, size: float = 1.0) -> Vec3:
    """A vector, shape (3,), in any direction, of length around `size`."""
    return size * rng.normal(size=3)


def direction(rng: np.random.Generator) -> Vec3:
    """A unit vector, shape (3,), uniform on the sphere."""
    x = rng.normal(size=3)
    return x / np.linalg.norm(x)


def angle(rng: np.random.Generator) -> float:
    """An angle [rad] in (−π, π), away from the ends."""
    return float(rng.uniform(-3.1, 3.1))


def tilted(rng: np.random.Generator, low: float, high: float) -> Mat3:
    """A rotation body → world, shape (3, 3), whose thrust axis leans `low` to `high` [rad] from the vertical.

    The direction of the lean and the turn about the vertical are uniform.
    """
    lean, azimuth, turn = (
        rng.uniform(low, high),
        rng.uniform(-np.pi, np.pi),
        rng.uniform(-np.pi, np.pi),
    )
    axis = np.array((np.cos(azimuth), np.sin(azimuth), 0.0))
    return so3.exp(lean * axis) @ so3.about_z(turn)


def aimed(rng: np.random.Generator, low: float, high: float) -> Mat3:
    """A rotation body → world, shape (3, 3), as of `tilted`, whose x axis is 20 degrees or more from the vertical."""
    while True:
        R = tilted(rng, low, high)
        if abs(R[2, 0]) < np.cos(np.radians(20.0)):
            return R


def knife_edge(rng: np.random.Generator) -> Mat3:
    """A rotation body → world, shape (3, 3), with a horizontal thrust axis, and its nose neither up nor down."""
    edge = so3.exp(np.array((np.pi / 2, 0.0, 0.0))) @ so3.about_z(rng.uniform(0.3, 1.2))
    return so3.about_z(angle(rng)) @ edge


def pace(rng: np.random.Generator) -> float:
    """A heading rate [rad/s] to either side, not near zero."""
    return float(rng.uniform(0.3, 3.0) * rng.choice((-1.0, 1.0)))


def force(rng: np.random.Generator, low: float, high: float) -> Vec3:
    """A force [N], world, shape (3,), that leans `low` to `high` [rad] from the vertical and weighs 5 to 50 N."""
    return float(rng.uniform(5.0, 50.0)) * tilted(rng, low, high)[:, 2]


def rotation(rng: np.random.Generator) -> Mat3:
    """A rotation, shape (3, 3), by any angle about any axis."""
    return so3.exp(rng.uniform(0.0, np.pi) * direction(rng))


def inertia(rng: np.random.Generator) -> Mat3:
    """An inertia tensor [kg m²], shape (3, 3), of a body whose principal axes are not the body axes."""
    masses = rng.uniform(
        0.01, 0.1, size=3
    )  # of points on the axes: any such sum is a possible body
    principal = np.diag(masses.sum() - masses)
    R = rotation(rng)
    return R @ principal @ R.T


def layout(rng: np.random.Generator, n: int) -> tuple[Array, float, float, Array]:
    """Angles [rad] (n,), arm [m], torque ratio [m] and spins (n,) of an uneven ring of `n` rotors."""
    step = 2.0 * np.pi / n
    angles = step * np.arange(n) + rng.uniform(-0.25, 0.25, size=n) * step + rng.uniform(-1.0, 1.0)
    spins = np.where(np.arange(n) % 2 == 0, 1.0, -1.0)
    return angles, float(rng.uniform(0.1, 0.6)), float(rng.uniform(0.01, 0.04)), spins


def thrust_curve(rng: np.random.Generator) -> tuple[float, float]:
    """Parameters (a_t [1/√N], b_t [1]) of a thrust curve like those of real aircraft."""
    return float(rng.uniform(0.08, 0.25)), float(rng.uniform(-0.3, -0.05))


def allocation(rng: np.random.Generator, n: int, *, balanced: bool = False) -> Array:
    """Matrix (4, n) from thrusts to (f, τ) of rotors that lean anywhere; `balanced`: equal thrusts make no torque.

    It is never so near singular that a right answer, written in another way, could lose a digit that counts.
    """
    while True:
        moments = rng.normal(scale=0.3, size=(3, n))
        if balanced:
            moments -= moments.mean(axis=1, keepdims=True)
        M = np.vstack((np.ones(n), moments))
        if np.linalg.cond(M) < 100.0:
            return M


def pushed(rng: np.random.Generator) -> tuple[State, Vec3, Vec3, float, Mat3]:
    """A tumbling body, what acts on it, its mass and its inertia."""
    state = State(vector(rng, 5.0), vector(rng, 5.0), rotation(rng), vector(rng, 3.0))
    force, torque = vector(rng, 20.0), vector(rng, 0.5)
    return state, force, torque, float(rng.uniform(0.5, 8.0)), inertia(rng)


def covariance(rng: np.random.Generator, n: int) -> Array:
    """A covariance, shape (n, n), whose axes are not the states."""
    root = rng.normal(size=(n, n)) / np.sqrt(n)
    return root @ root.T + 0.2 * np.eye(n)


def belief(rng: np.random.Generator, n: int, m: int) -> tuple[Array, Array, Array, Array, Array]:
    """State (n,), covariance (n, n), measurement (m,), what it sees (m, n), and its covariance (m, m)."""
    x, z, H = rng.normal(size=n), rng.normal(size=m), rng.normal(size=(m, n))
    return x, covariance(rng, n), z, H, covariance(rng, m)


def prediction(
    rng: np.random.Generator, n: int, k: int
) -> tuple[Array, Array, Array, Array, Array, Array]:
    """State (n,), covariance (n, n), input (k,), model (n, n) and (n, k), and what it misses (n, n)."""
    A, B = rng.normal(size=(n, n)), rng.normal(size=(n, k))
    return rng.normal(size=n), covariance(rng, n), rng.normal(size=k), A, B, covariance(rng, n)


def hypothesis(
    rng: np.random.Generator, *, spread: float = 1.0, reliable: bool = True
) -> Hypothesis:
    """What a filter may believe; `spread` is the trace [m²] of the covariance of its position."""
    P = np.array([covariance(rng, 3) for _ in range(3)])
    scale = np.sqrt(spread / P[:, 0, 0].sum())
    P[:, 0, :] *= scale
    P[:, :, 0] *= scale
    x, h = rng.normal(size=(3, 3)) * (5.0, 2.0, 1.0), np.array((angle(rng), rng.normal()))
    return Hypothesis(x, P, h, covariance(rng, 2), 1.0, reliable)


def reference(rng: np.random.Generator) -> Reference:
    """Something to follow."""
    r, v, a, j = rng.normal(size=(4, 3)) * ((5.0,), (2.0,), (1.0,), (1.0,))
    return Reference(r, v, a, j, angle(rng), pace(rng))
