"""Lab 06, look ahead: predictions as one matrix, control as a quadratic programme, and parts that fly on it."""

from __future__ import annotations

from uavlab.exercises import mpc_checks as laws
from uavlab.exercises.spec import exercise
from uavlab.limits import AxisLimits, ForceLimits
from uavlab.qp import QP, Plan
from uavlab.types import Array, Estimate, Reference
from uavlab.weights import (
    HORIZONTAL,
    ForceWeights,
    InputBounds,
    LandingModel,
    LandingWeights,
    SoftRows,
)

# Predictions ------------------------------------------------------------------------------------------


@exercise(points=2, reads="Landing eq. (18)")
def discretize(A: Array, B: Array, dt: float) -> tuple[Array, Array]:
    """The linear model ẋ = A x + B u in steps of dt, exact for an input that is held over the step.

    Printed is the integral of the exponential alone; it is to be multiplied by B. A may be singular.

    Parameters
    ----------
    A, B : Array
        Continuous model, shapes (n, n) and (n, k).
    dt : float
        Step [s].

    Returns
    -------
    tuple[Array, Array]
        A_d, shape (n, n), and B_d, shape (n, k): x[i + 1] = A_d x[i] + B_d u[i].
    """
    ...


@exercise(points=2, reads="Landing eq. (23)")
def prediction_matrices(A: Array, B: Array, N: int) -> tuple[Array, Array]:
    """N steps of a discrete model at once: all states from the first one and all inputs.

    Parameters
    ----------
    A, B : Array
        Model of one step, x[i + 1] = A x[i] + B u[i], shapes (n, n) and (n, k).
    N : int
        Steps, at least 1.

    Returns
    -------
    tuple[Array, Array]
        Phi, shape (N n, n), and Gamma, shape (N n, N k): [x_1; …; x_N] = Phi x_0 + Gamma [u_0; …; u_{N−1}].
    """
    ...


@exercise(points=2, reads="MRS eq. (45), Sec. 5.7.2")
def initial_state(estimate: Estimate, reference: Reference, limits: ForceLimits) -> Array:
    """Where the prediction starts: what is measured, but no velocity or acceleration that breaks its limit.

    A number is replaced by that of the reference where its size is 1.5 times its limit or more (so
    does the MRS software), each axis and each of the two by itself. The position is always measured.

    Parameters
    ----------
    estimate, reference : Estimate, Reference
        What is measured; what is wanted.
    limits : ForceLimits
        ``horizontal`` of x and y, ``vertical`` of z: v [m/s] and a [m/s²] of each.

    Returns
    -------
    Array
        Shape (3, 3), a row for each axis: position [m], velocity [m/s], acceleration [m/s²].
    """
    ...


# Programmes -------------------------------------------------------------------------------------------


@exercise(points=5, reads="MRS eq. (10), (43), (46)-(52), Sec. 5.7")
def build_force_qp(
    x0: Array, reference: Array, last_input: float, *, limits: AxisLimits, N: int, dt: float,
    p: float = 0.0, weights: ForceWeights = HORIZONTAL, period: float = 0.01, price: float = 1e4,
) -> QP:  # fmt: skip
    """The QP of the force controller, of one axis. Its variables are the inputs u_1 … u_N [m/s²].

    *Model* (10): x_i = A x_{i−1} + B u_i. Position and velocity go on with the old acceleration; the new
    one is p times the old one plus 1 − p times the input.

    *Cost* (46), plain sums: e_iᵀ Q e_i of i = 1 … N − 1, and e_Nᵀ S e_N, with e_i = x_i − reference_i and
    diagonal weights. A `QP` minimises ½ zᵀ P z + qᵀ z; what does not depend on z does not matter.

    *Rows*, in any order and scale. Inputs, hard: |u_i| ≤ a. Velocities, soft: |v_i| ≤ v, `price` for each
    m/s beyond (v_1, too, which nothing can change any more: were it hard, there might be no solution).
    Slew, hard: |u_i − u_{i−1}| ≤ j dt from i = 2 on; and, missing in (50) and (51), |u_1 − last_input| ≤
    j period, since the next plan comes after a period of the controller. Take a last input beyond ±a as
    ±a. A limit of inf makes no rows.

    Parameters
    ----------
    x0, reference : Array
        Position [m], velocity [m/s] and acceleration [m/s²]: now, shape (3,); and wanted at the steps
        1 … N, shape (N, 3).
    last_input, limits : float, AxisLimits
        The input that was applied last [m/s²]; v, a, j are used.
    N, dt, p : int, float, float
        Steps; length of each [s]; share of the acceleration that is left after one, 0 ≤ p < 1.
    weights, period, price : ForceWeights, float, float
        Diagonals of Q and S; time between two plans [s]; of a velocity beyond its limit.

    Returns
    -------
    QP
        With ``soft`` the price of each soft row, and inf for each hard one.
    """
    ...


@exercise(points=5, reads="Landing eq. (19)-(27), Sec. 6.2")
def build_soft_qp(
    x0: Array, reference: Array, *, weights: LandingWeights, bounds: InputBounds, soft: SoftRows,
    N: int, dt: float, model: LandingModel = LandingModel(),
) -> QP:  # fmt: skip
    """The QP of the landing, with a slack variable for each soft row at each step: (27), corrected.

    *Variables* [u_0; …; u_{N−1}; s_1; …; s_N]: inputs (θ_r, φ_r, T_r), the thrust by mass and without
    gravity; and slacks, those of one step together, in the order of the soft rows.

    *Model*: `uavlab.weights.landing_model` gives A and B of (13), with the states in the order of its
    blocks (x, ẋ, θ, θ̇, y, ẏ, φ, φ̇, z, ż). Inputs are held over each step.

    *Cost* (20), and the price λ of each unit of slack: ‖Q (x_k − reference_k)‖² of the steps 1 … N and
    ‖R u_k‖² of 0 … N − 1, so weights are squared. ``weights.end``, if given, is Q of step N, a matrix. An ε
    of 1e-8 for each slack on the diagonal of P makes it definite. A `QP` minimises ½ zᵀ P z + qᵀ z.

    *Rows*, all hard, in any order and scale: inputs within bounds, G x_k − s_k ≤ h at the steps 1 … N, s ≥ 0.

    Parameters
    ----------
    x0, reference : Array
        State now, shape (10,); states wanted, shape (10,) for all steps, or (N, 10).
    weights, bounds, soft : LandingWeights, InputBounds, SoftRows
        Diagonals of Q and R; least and largest input; G, h and price λ of missing them.
    N, dt, model : int, float, LandingModel
        Steps; length of each [s]; the numbers in (13)-(16).

    Returns
    -------
    QP
        Of 3 N + l N variables, for l soft rows. Every row is hard: ``soft`` is inf.
    """
    ...


@exercise(points=2, reads="Landing eq. (25), (26), Sec. 6.2")
def solve(qp: QP, warm: Plan | None = None) -> Plan:
    """The solution of a QP, by OSQP; that there is none is an answer, not an error.

    Soft rows may be missed, at their price. OSQP knows hard rows only: `uavlab.qp.slacked` makes
    slacks, `unslacked` tells the solution without them. Import osqp in here. Its defaults are coarse: ask for
    1e-6 or less, for polishing, and for enough iterations.

    Parameters
    ----------
    qp : QP
        n variables, m rows.
    warm : Plan or None
        The plan before, of the same sizes: where to begin. The solution must not depend on it.

    Returns
    -------
    Plan
        ``z``, shape (n,), to about 1e-4; ``y``, shape (m,), multipliers of the rows of `qp`; ``status``: a name
        of `uavlab.qp`; ``cost``, with the price of what is missed. Without a solution z is that of `warm`, or zeros.

    Raises
    ------
    ValueError
        Not finite, wrong shapes, l above u: `uavlab.qp.checked` raises it. Bounds may be ±inf.
    """
    ...


from uavlab.exercises.mpc_parts import MpcController, MpcTracker  # noqa: E402, F401  the last two

# What is checked in public
discretize.check(laws.a_push_held)
discretize.check(laws.two_steps_are_one_long_one)
prediction_matrices.check(laws.step_by_step)
initial_state.check(laws.measured_within_its_limits)
build_force_qp.check(laws.a_plan_costs_what_its_flight_costs)
build_force_qp.check(laws.a_plan_begins_where_the_last_one_was)
build_soft_qp.check(laws.a_landing_costs_what_it_weighs)
build_soft_qp.check(laws.a_slack_lets_a_row_be_missed)
solve.check(laws.the_best_that_is_allowed)
solve.check(laws.rows_that_exclude_each_other)
