"""Lab 04, complementary filters: attitude, position, height and wind from cheap sensors."""

from __future__ import annotations

from dataclasses import dataclass

from uavlab.exercises import complementary_checks as laws
from uavlab.exercises.spec import exercise
from uavlab.interfaces import Memory, Readings
from uavlab.types import (
    AidedGains,
    Array,
    BodyMemory,
    Command,
    CoupledEstimate,
    CoupledGains,
    Estimate,
    Imu,
    InertialMemory,
    Mat3,
    Pull,
    Quat,
    Shift,
    Vec3,
    VerticalGains,
    VerticalMemory,
)

# Attitude and position --------------------------------------------------------------------------------


@exercise(points=5, reads="Spica eq. (12), Sec. 6.1")
def attitude_step(q: Quat, omega: Vec3, q_meas: Quat, gain: float, dt: float) -> Quat:
    """One step of the passive complementary filter: turned by the gyro, drawn to the measured attitude.

    The step solves (12) exactly, for a body rate that is constant over dt and a measured attitude that
    is true at its beginning and turns along. So it is stable for any gain and dt. Along a fixed axis the
    error angle θ obeys θ̇ = −gain sin θ; what does tan(θ/2) do?

    Parameters
    ----------
    q : Quat
        Estimate, [w, x, y, z], Hamilton, body → world, shape (4,), of any length above zero.
    omega : Vec3
        Angular velocity [rad/s], body, shape (3,), bias taken off.
    q_meas : Quat
        Measured attitude, shape (4,), of any length above zero and either sign.
    gain, dt : float
        K of (12) [1/s], and step [s].

    Returns
    -------
    Quat
        Estimate after the step, of length one, shape (4,). Of its two signs the one of `q`.
    """
    ...


@exercise(points=3, reads="Spica eq. (11), Sec. 6.1")
def position_observer_step(
    r: Vec3, v: Vec3, accel_W: Vec3, r_meas: Vec3 | None, k_p: float, k_v: float, dt: float
) -> tuple[Vec3, Vec3]:
    """One step of the position observer: carried by the acceleration, drawn to the measured position.

    The step solves (11) exactly while acceleration and measurement stand still. It is called at the rate
    of the accelerometer; between two measurements the last one is handed in again.

    Parameters
    ----------
    r, v : Vec3
        Estimated position [m] and velocity [m/s], world, shape (3,).
    accel_W : Vec3
        Acceleration [m/s²], world, shape (3,), gravity taken off (0 at rest).
    r_meas : Vec3 or None
        Last measured position [m], world, shape (3,); None before the first: then dead reckoning.
    k_p, k_v, dt : float
        Gains on the position [1/s] and on the velocity [1/s²], and step [s].

    Returns
    -------
    tuple[Vec3, Vec3]
        Position [m] and velocity [m/s] after the step, world, each of shape (3,).

    Raises
    ------
    ValueError
        A gain that is not above zero.
    """
    ...


# Measurements of velocity -----------------------------------------------------------------------------


@exercise(points=2, reads="Bangura eq. (3)")
def drag_velocity(accel: Vec3, c: float) -> Array:
    """Horizontal velocity through the air, from the drag of the rotors that the accelerometer feels.

    Parameters
    ----------
    accel : Vec3
        Specific force [m/s²], body, z up, shape (3,), bias taken off; +g along z at rest.
    c : float
        Drag coefficient [1/√m], that of (3) with the mass in it.

    Returns
    -------
    Array
        Velocity through the air [m/s], along body x and y, shape (2,). Near free fall, where accel along
        body z is not above 1 m/s², the drag says nothing: NaN twice.

    Raises
    ------
    ValueError
        `c` is not above zero.
    """
    ...


@exercise(points=3, reads="Bangura eq. (4), Filter 0")
def vertical_step(
    memory: VerticalMemory,
    R: Mat3,
    accel: Vec3,
    z_meas: float | None,
    dt: float,
    *,
    gains: VerticalGains,
) -> VerticalMemory:
    """One step of Filter 0: height (up), vertical velocity and bias; explicit Euler will do.

    Parameters
    ----------
    memory : VerticalMemory
        Height z [m], vertical velocity v_z [m/s], up, and bias b_z [m/s²] before the step.
    R : Mat3
        Attitude, body → world, shape (3, 3).
    accel : Vec3
        Specific force [m/s²], body, shape (3,).
    z_meas : float or None
        Last measured height [m]; None before the first: then no innovation.
    dt : float
        Step [s].
    gains : VerticalGains
        k_1 [1/s], k_2 [1/s²], k_3 [1/s³].

    Returns
    -------
    VerticalMemory
        The same after the step.

    Raises
    ------
    ValueError
        Gains with which the error grows: one that is not above zero, or k_3 not below k_1 k_2.
    """
    ...


# The two filters --------------------------------------------------------------------------------------


@exercise(points=5, reads="Bangura eq. (6), (7), Filter 1")
def body_filter_step(
    memory: BodyMemory,
    imu: Imu,
    V_meas: Vec3 | None,
    m_meas: Vec3 | None,
    dt: float,
    *,
    m_W: Vec3,
    gains: AidedGains,
    pull: Pull,
) -> BodyMemory:
    """One step of Filter 1: velocity through the air, told in the body, and attitude.

    Everything is told z up: gravity is −g e_3. Two laws differ from print: the gyro bias follows
    R^T Δ^r, the innovation told in the body, and the magnetometer helps it:
    ``b_omega_dot = k_b_omega Rᵀ Δ^r − k_b_m Δ^μ``, with k^μ in Δ^μ and without k^r. The biases of
    accelerometer and gyro are what is to be taken off. The attitude must stay a rotation.

    Parameters
    ----------
    memory : BodyMemory
        V, R, u, b_a, b_omega before the step.
    imu : Imu
        Biased readings.
    V_meas : Vec3 or None
        Velocity through the air [m/s], body, shape (3,); None: its innovation is 0.
    m_meas : Vec3 or None
        Magnetic field, body, shape (3,); None: its innovation is 0 (Remark 1).
    dt, m_W : float, Vec3
        Step [s], explicit Euler will do for all but R; and the magnetic field, world, shape (3,).
    gains : AidedGains
        All gains, of either filter.
    pull : Pull
        What the other filter adds: v_dot to V̇, turn (world) to the attitude, b_a_dot to b_a.

    Returns
    -------
    BodyMemory
        The same after the step.
    """
    ...


@exercise(points=5, reads="Bangura eq. (9), (10), Filter 2")
def inertial_filter_step(
    memory: InertialMemory,
    imu: Imu,
    v_meas: Vec3 | None,
    m_meas: Vec3 | None,
    dt: float,
    *,
    m_W: Vec3,
    gains: AidedGains,
    pull: Pull,
) -> InertialMemory:
    """One step of Filter 2: velocity over ground, told in the world, and attitude.

    Everything is told z up: gravity is −g e_3. Four laws differ from print: u weighs gravity in (9a);
    the error v̂ − v drives u in (9d); both biases follow their innovation told in the body, R^T Δ; and
    the magnetometer helps the gyro bias as in Filter 1, with an innovation of its own, of this R and u.

    Parameters
    ----------
    memory : InertialMemory
        v, R, u, b_a, b_omega before the step.
    imu : Imu
        Biased readings.
    v_meas : Vec3 or None
        Velocity over ground [m/s], world, shape (3,); None while it has dropped out: no innovation.
    m_meas : Vec3 or None
        Magnetic field, body, shape (3,); None: its innovation is 0 (Remark 1).
    dt, m_W : float, Vec3
        Step [s], explicit Euler will do for all but R; and the magnetic field, world, shape (3,).
    gains : AidedGains
        All gains, of either filter.
    pull : Pull
        What the other filter adds: v_dot to v̇, turn (world) to the attitude, b_a_dot to b_a.

    Returns
    -------
    InertialMemory
        The same after the step.
    """
    ...


# The coupled pair -------------------------------------------------------------------------------------


@exercise(points=5, reads="Bangura eq. (8), (11), (9e), Remark 1, Sec. II-E")
@dataclass(frozen=True)
class CoupledFilter:
    """The coupled filters: both kinds of velocity, attitude and wind, also while satellites are lost.

    Each step reads what has arrived, and holds it until the next (innovations are made anew at every
    step). Filter 0 with R of Filter 1 gives v_z; with the drag velocity, of the specific force without
    the bias of Filter 1, it gives V_meas of Filter 1 (none where drag gives NaN, or |R33| is below 0.2).
    Then both filters step, pulled to each other by (8), (11) and the coupling terms of (6e), (9f), and
    the wind by (9e). All rates are taken before the step. `CoupledMemory` is a memory that serves.

    Parameters
    ----------
    m_W : Vec3
        The magnetic field, world in which the flight begins, shape (3,).
    c, gains : float, CoupledGains
        Drag coefficient of (3) [1/√m]; all gains.
    patience : float
        Age [s] from which a velocity over ground has dropped out: then Filter 2 has no innovation, and
        the wind decays (Sec. II-E). Before the first velocity it has dropped out too.
    velocity : str
        The instrument that gives it: ``readings[velocity]`` is a `Fix`, and its v is used.
    """

    m_W: Vec3
    c: float
    gains: CoupledGains = CoupledGains()
    patience: float = 0.5
    velocity: str = "gnss"

    def init(self, estimate: Estimate) -> Memory:
        """Start from an estimate, in still air, without biases.

        Parameters
        ----------
        estimate : Estimate
            Height, velocity and attitude are used.

        Returns
        -------
        Memory
            Whatever `step` needs.
        """
        ...

    def step(
        self, memory: Memory, readings: Readings, command: Command | None, dt: float
    ) -> tuple[Memory, CoupledEstimate]:
        """One step of all filters, once the first ``imu`` is there.

        Parameters
        ----------
        memory : Memory
            From `init` or the step before.
        readings : Readings
            What has arrived since: perhaps ``imu`` (`Imu`), ``barometer`` (`Height`), ``magnetometer``
            (`Field`) and the velocity. One with a number that is not finite is passed over.
        command : Command or None
            Not used.
        dt : float
            Step [s].

        Returns
        -------
        tuple[Memory, CoupledEstimate]
            The memory after the step, and what it believes (a is R (accel − b_a) − g e_3).
        """
        ...

    def reframe(self, memory: Memory, shift: Shift) -> Memory:
        """Tell everything in another world; also the magnetic field.

        Parameters
        ----------
        memory : Memory
            Told in the old world.
        shift : Shift
            Old world → new world.

        Returns
        -------
        Memory
            Told in the new world.
        """
        ...


# What is checked in public
attitude_step.check(laws.only_the_gyro, weight=0)
attitude_step.check(laws.small_errors_fade)
position_observer_step.check(laws.dead_reckoning, weight=0)
position_observer_step.check(laws.one_long_step_or_many)
drag_velocity.check(laws.drag_of_a_velocity)
vertical_step.check(laws.hover_with_a_bias)
body_filter_step.check(laws.the_truth_is_kept_in_the_body)
inertial_filter_step.check(laws.the_truth_is_kept_in_the_world)
CoupledFilter.check(laws.the_wind_is_found)
