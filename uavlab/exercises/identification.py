"""Lab 05, know your aircraft: its sensors, motors, mass and drag, and how its attitude loop answers."""

from __future__ import annotations

from uavlab.exercises import identification_checks as checks
from uavlab.exercises.spec import exercise
from uavlab.types import Array, InertiaMemory, MassMemory, Mat3, Vec3

# Sensors at rest --------------------------------------------------------------------------------------


@exercise(points=2, reads="Spica Sec. 5.1")
def gyro_bias(samples: Array, max_std: float) -> Vec3:
    """What the gyro says when the aircraft does not turn: the mean of its readings at rest.

    Parameters
    ----------
    samples : Array
        Readings [rad/s], shape (n, 3), a row for each sample.
    max_std : float
        Largest standard deviation [rad/s] that noise alone makes, on any axis.

    Returns
    -------
    Vec3
        Bias [rad/s], body, shape (3,).

    Raises
    ------
    ValueError
        The aircraft moved: the standard deviation along some axis is above `max_std`. Or a reading
        is NaN.
    """
    ...


gyro_bias.check(checks.mean_of_the_readings)
gyro_bias.check(checks.refused_when_it_moved)


@exercise(points=3, reads="Spica Sec. 5.2")
def accelerometer_calibration(samples: Array, attitudes: Array) -> tuple[Mat3, Vec3]:
    """Scale, mounting and offset of an accelerometer, from standing still in several orientations.

    With T and b the true specific force [m/s²], body, is ``T @ (reading - b)``. At rest it is +9.81
    along the direction that is up.

    Parameters
    ----------
    samples : Array
        One reading a_m [m/s²] for each orientation, in the sensor's own axes, shape (n, 3).
    attitudes : Array
        The orientations body → world, shape (n, 3, 3).

    Returns
    -------
    tuple[Mat3, Vec3]
        T [1], shape (3, 3), and b [m/s²], shape (3,), that fit best: least squares of the equations
        in T and T b.

    Raises
    ------
    ValueError
        The orientations do not determine T and b: the stacked matrix has a rank below 4.
    """
    ...


accelerometer_calibration.check(checks.gravity_in_every_orientation)


# Motors and thrust ------------------------------------------------------------------------------------


@exercise(points=3, reads="Spica Sec. 5.3")
def motor_time_constant(t: Array, command: Array, speed: Array) -> float:
    """Time constant of a motor: a first-order lag that settles at its command.

    Parameters
    ----------
    t : Array
        Times of the samples [s], rising, shape (n,); the steps between them may differ.
    command : Array
        Commanded speed [rad/s], shape (n,): each is held until the next sample. Any steps, up or
        down, and the speed need not settle between them.
    speed : Array
        Measured speed [rad/s], shape (n,), with noise.

    Returns
    -------
    float
        Time constant [s].

    Raises
    ------
    ValueError
        The speed is at its command all the time: there is nothing to measure. Or the times do not
        rise.
    """
    ...


motor_time_constant.check(checks.one_clean_step)


@exercise(points=2, reads="Spica Sec. 5.3, Fig. 2b")
def thrust_polynomial(speed: Array, force: Array) -> Array:
    """The quadratic ``force = p_0 + p_1 speed + p_2 speed²`` that fits a motor bench best.

    Parameters
    ----------
    speed : Array
        Rotor speeds [rad/s] (or commands in proportion to them), shape (n,).
    force : Array
        Thrust at each of them [N], shape (n,), with noise.

    Returns
    -------
    Array
        p_0 [N], p_1 [N s/rad], p_2 [N s²/rad²], shape (3,), in this order: of least squares.

    Raises
    ------
    ValueError
        There are fewer than three different speeds.
    """
    ...


thrust_polynomial.check(checks.on_a_parabola)


@exercise(points=2, reads="MRS eq. (33), Sec. 5.4")
def thrust_curve(throttle: Array, mass: Array, g: float) -> tuple[float, float]:
    """Thrust curve of an aircraft from hover tests: known masses on board, and the throttle read off.

    The curve is the one of lab 01, throttle = a_t √f + b_t, with the force of all rotors together.

    Parameters
    ----------
    throttle : Array
        Throttle in hover [1], shape (n,).
    mass : Array
        Mass of the aircraft with its load [kg], shape (n,), above zero.
    g : float
        Gravity [m/s²], above zero.

    Returns
    -------
    tuple[float, float]
        Slope a_t [1/√N] and offset b_t [1] that fit the throttles best: least squares.

    Raises
    ------
    ValueError
        All hovers had the same mass.
    """
    ...


thrust_curve.check(checks.hovers_on_a_curve)
thrust_curve.check(checks.on_the_moon)


# Drag -------------------------------------------------------------------------------------------------


@exercise(points=2, reads="Bangura eq. (3), Sec. V-A")
def drag_coefficient(accel: Array, v_body: Array) -> tuple[Array, Array, Array]:
    """Rotor drag along body x and y: the c that turns an accelerometer into a speedometer in lab 04.

    On each axis, with its own c and offset: ``a = -sqrt(a_z) (c V + offset)``. (In the paper z points
    down, so it says −a_z where we say a_z.)

    Parameters
    ----------
    accel : Array
        Specific force [m/s²], body, shape (n, 3): +9.81 along z at rest.
    v_body : Array
        Velocity through the air along body x and y [m/s], shape (n, 2).

    Returns
    -------
    tuple[Array, Array, Array]
        c [m^-½], offset [m^½/s] and R² [1], each of shape (2,): for x and y. Least squares of
        ``a / sqrt(a_z)`` on V; R² is the share of the variance of ``a / sqrt(a_z)`` that the fit
        explains. Samples near free fall, a_z ≤ 1 m/s², are left out.

    Raises
    ------
    ValueError
        The speed along one of the axes does not change: slope and offset cannot be told apart.
    """
    ...


drag_coefficient.check(checks.an_ideal_sweep)


@exercise(points=2, reads="Bangura Sec. V-A, below eq. (3)")
def quadratic_drag(accel: Array, v_body: Array) -> tuple[Array, Array, Array, Array]:
    """The same with the drag of the frame, which grows with the square of the speed and opposes it.

    On each axis ``a = -sqrt(a_z) (c_2 V |V| + c V + offset)``.

    Parameters
    ----------
    accel : Array
        Specific force [m/s²], body, shape (n, 3): +9.81 along z at rest.
    v_body : Array
        Velocity through the air along body x and y [m/s], shape (n, 2).

    Returns
    -------
    tuple[Array, Array, Array, Array]
        c_2 [s/m^3/2], c [m^-½], offset [m^½/s] and R² [1], each of shape (2,), as in
        `drag_coefficient`.

    Raises
    ------
    ValueError
        The speeds along one of the axes do not determine the three numbers.
    """
    ...


quadratic_drag.check(checks.an_ideal_fast_sweep)


# Mass and inertia while it flies ----------------------------------------------------------------------


@exercise(points=4, reads="Spica eq. (6)-(10), Sec. 5.4")
def mass_step(
    memory: MassMemory, v_z: float, R: Mat3, u_1: float, dt: float, *, a: float, k: float, g: float
) -> MassMemory:
    """One step of an estimate of the mass that learns from thrust and vertical velocity.

    All inputs are held during the step. First the three filters make their step, exactly. Then 1/m
    makes its own by (10), exactly again, with the filtered values now held: the equation is stiff,
    and a step of Euler runs away. World z is up and g is positive: mind the signs of (6), (7), (9).

    Parameters
    ----------
    memory : MassMemory
        Filtered v_z [m/s], filtered vertical thrust [N], filtered g [m/s²], estimate of 1/m [1/kg].
    v_z : float
        Vertical velocity [m/s], world, up.
    R : Mat3
        Rotation body → world, shape (3, 3).
    u_1 : float
        Commanded collective thrust [N] along body z; without thrust nothing is learnt.
    dt : float
        Time [s], above zero: also longer than 1 / (k · thrust²).
    a : float
        Pace of the filters P(s) = a / (s + a) [rad/s].
    k : float
        Gain k_est,m of (10), above zero.
    g : float
        Gravity [m/s²], positive.

    Returns
    -------
    MassMemory
        The memory after the step.
    """
    ...


mass_step.check(checks.weighed_in_hover)
mass_step.check(checks.filters_close_a_share_of_the_gap)


@exercise(points=2, reads="Spica Sec. 5.4, last paragraph")
def inertia_step(
    memory: InertiaMemory, omega: Vec3, torque: Vec3, dt: float, *, a: float, k: float
) -> InertiaMemory:
    """The same law for the inertia: three axes, each by itself, and no gravity.

    As in `mass_step`: all inputs are held, first the filters and then 1/J make an exact step.

    Parameters
    ----------
    memory : InertiaMemory
        Filtered angular velocity [rad/s], filtered torque [N m], estimate of 1/J [1/(kg m²)]: body,
        each of shape (3,).
    omega : Vec3
        Angular velocity [rad/s], body, shape (3,).
    torque : Vec3
        Commanded torque [N m], body, shape (3,); an axis without torque learns nothing.
    dt : float
        Time [s], above zero.
    a : float
        Pace of the filters [rad/s].
    k : float
        Gain, above zero.

    Returns
    -------
    InertiaMemory
        The memory after the step.
    """
    ...


inertia_step.check(checks.pushed_evenly)


# The attitude loop ------------------------------------------------------------------------------------


@exercise(points=4, reads="Landing eq. (12), Sec. 6.1")
def attitude_response(t: Array, reference: Array, measured: Array) -> tuple[float, float, float]:
    """How the tilt follows its reference: ``θ̈ = -b_0 θ - b_1 θ̇ + b_r θ^r``, fitted to a flight.

    The paper fits in the frequency domain. Mind three things: noise that is differentiated grows, a
    record that is cut out of a flight neither begins nor ends at rest, and either signal may have a
    constant trim, which means nothing. The grader waits two seconds for an answer.

    Parameters
    ----------
    t : Array
        Times of the samples [s], in even steps, shape (n,).
    reference : Array
        Commanded tilt angle θ^r about one axis [rad], shape (n,), joined by straight lines.
    measured : Array
        Measured tilt angle θ [rad], shape (n,), with noise.

    Returns
    -------
    tuple[float, float, float]
        b_0 [1/s²], b_1 [1/s], b_r [1/s²].

    Raises
    ------
    ValueError
        The reference does not move: nothing can be learnt from the flight. Or the times do not rise.
    """
    ...


attitude_response.check(checks.a_clean_flight)
