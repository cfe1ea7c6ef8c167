"""What the predictive controllers of the papers weigh, and the model by which a landing predicts.

Papers: MRS is Baca et al. 2021, Landing is Tzoumanikas et al. 2019.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from uavlab.types import GRAVITY, Array

Triple = tuple[float, float, float]


class ForceWeights(NamedTuple):
    """Weights of one axis of the MPC force feedback, on squares of errors (MRS eq. 46)."""

    Q: Triple  # on position [1/m²], velocity [s²/m²], acceleration [s⁴/m²] before the end of the horizon
    S: Triple  # on the same at its end


HORIZONTAL = ForceWeights((500.0, 100.0, 100.0), (1000.0, 300.0, 300.0))  # MRS eq. (52)
VERTICAL = ForceWeights((100.0, 10.0, 10.0), (100.0, 10.0, 10.0))  # MRS eq. (52)


class LandingModel(NamedTuple):
    """Drag and attitude loop of Landing eq. (11), (12). The paper prints no value; these stand in (ours)."""

    c: Triple = (0.2, 0.2, 0.1)  # [1/s] drag along x, y, z
    b: Triple = (
        49.0,
        9.8,
        49.0,
    )  # [1/s²], [1/s], [1/s²] on angle, its rate, its reference: 7 rad/s
    g: float = GRAVITY  # [m/s²]


class LandingWeights(NamedTuple):
    """Diagonals of Q and R of Landing eq. (20): they weigh as Q'Q and R'R, so these are roots (errata)."""

    Q: tuple[float, ...] = (1.0, 0.4, 0.2, 0.05, 1.0, 0.4, 0.2, 0.05, 1.2, 0.5)  # 10, as the state
    R: Triple = (1.5, 1.5, 0.15)  # [1/rad], [1/rad], [s²/m]
    end: tuple[tuple[float, ...], ...] | None = None  # Q_N, 10 × 10, where it differs


class InputBounds(NamedTuple):
    """Hard limits of the inputs (pitch [rad], roll [rad], thrust per mass without gravity [m/s²]); ours."""

    lower: Triple = (-0.5, -0.5, -0.5 * GRAVITY)
    upper: Triple = (0.5, 0.5, 0.5 * GRAVITY)


class SoftRows(NamedTuple):
    """Rows ``G x <= h`` of every predicted state that may be missed at a price (Landing eq. 25)."""

    G: Array  # (l, 10)
    h: Array  # (l,)
    price: float = 1e4  # per unit: λ


def landing_model(model: LandingModel = LandingModel()) -> tuple[Array, Array]:
    """The model of Landing eq. (13)-(16) in continuous time.

    Parameters
    ----------
    model : LandingModel
        Drag and attitude loop; one attitude loop serves pitch and roll.

    Returns
    -------
    A, B : Array
        Shapes (10, 10) and (10, 3). State (x, v_x, θ, θ̇, y, v_y, φ, φ̇, z, v_z) in the order of the blocks of
        (13), not of the text above it (errata); navigation frame, [m], [m/s], [rad], [rad/s]. Inputs
        (θ_r, φ_r, T_r): pitch and roll [rad], and thrust per mass without gravity [m/s²] (errata of 11).
    """
    (c_x, c_y, c_z), (b, b_dot, b_r) = model.c, model.b
    A, B = np.zeros((10, 10)), np.zeros((10, 3))
    A[0, 1] = A[2, 3] = A[4, 5] = A[6, 7] = A[8, 9] = 1.0
    A[1, 1], A[5, 5], A[9, 9] = -c_x, -c_y, -c_z
    A[1, 2], A[5, 6] = model.g, -model.g  # (11): pitch up flies forward, roll flies to the right
    A[3, 2:4] = A[7, 6:8] = -b, -b_dot  # (12)
    B[3, 0] = B[7, 1] = b_r  # (14), (15)
    B[9, 2] = 1.0  # (16)
    return A, B


def soft_limits(
    speed: float = 8.0, climb: float = 2.0, tilt: float = 0.42, price: float = 1e4
) -> SoftRows:
    """Soft rows that keep the state of `landing_model` within speeds [m/s] and a tilt [rad], both ways (ours).

    Parameters
    ----------
    speed, climb, tilt : float
        Largest size of v_x and v_y [m/s], of v_z [m/s], of θ and φ [rad].
    price : float
        Per unit by which one is missed.

    Returns
    -------
    SoftRows
        Ten rows: x, y, z velocity, pitch and roll, from above; then all five from below.
    """
    most = np.array((speed, speed, climb, tilt, tilt))
    G = np.eye(10)[[1, 5, 9, 2, 6]]
    return SoftRows(np.vstack((G, -G)), np.concatenate((most, most)), price)


def with_endless_horizon(
    weights: LandingWeights, dt: float, model: LandingModel = LandingModel()
) -> LandingWeights:
    """The same weights with the last one such that a short horizon plans like an endless one, while no limit binds.

    Parameters
    ----------
    weights : LandingWeights
        Before the end of the horizon.
    dt : float
        Step of the prediction [s].
    model : LandingModel
        By which it predicts.

    Returns
    -------
    LandingWeights
        With ``end`` a root of the solution of the discrete algebraic Riccati equation.
    """
    from scipy.linalg import solve_discrete_are
    from scipy.signal import cont2discrete

    A, B = landing_model(model)
    A, B = cont2discrete((A, B, np.eye(10), np.zeros((10, 3))), dt)[:2]  # type: ignore[index]
    Q, R = np.diag(np.square(weights.Q)), np.diag(np.square(weights.R))
    root = np.linalg.cholesky(solve_discrete_are(A, B, Q, R)).T
    return weights._replace(end=tuple(map(tuple, root.tolist())))
