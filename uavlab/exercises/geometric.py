"""Lab 07, fly on SE(3): errors ask for a force, a force for an attitude, an attitude for rates; and a torque below."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from uavlab.exercises import geometric_checks as laws
from uavlab.exercises.spec import exercise
from uavlab.gains import GROUPS, GeometricGains, TorqueGains
from uavlab.interfaces import Memory
from uavlab.types import Array, Command, Estimate, Mat3, Reference, Shift, Vec3

# The cascade ------------------------------------------------------------------------------------------


@exercise(points=2, reads="MRS eq. (24), Sec. 5.1.2")
def attitude_error(R: Mat3, R_d: Mat3) -> Vec3:
    """How far an attitude is from the wanted one, for a controller.

    For a small turn it is the rotation vector from the wanted attitude to the flown one, told in the body.
    It is largest at a right angle, and upside down it vanishes.

    Parameters
    ----------
    R, R_d : Mat3
        Attitude flown and attitude wanted, body → world, shapes (3, 3).

    Returns
    -------
    Vec3
        e_R [1], body, shape (3,).
    """
    ...


@exercise(points=3, reads="MRS eq. (38), Sec. 5.6")
def desired_force(
    estimate: Estimate, reference: Reference, m_e: float, d_w: Vec3, d_b: Vec3, gains: GeometricGains
) -> Vec3:  # fmt: skip
    """Force that makes the aircraft follow its reference, in spite of weight and disturbances.

    (38) says that disturbances are in m/s². They are in newtons, as (35) sums them up, and no mass
    multiplies them. The gains are those of an acceleration.

    Parameters
    ----------
    estimate, reference : Estimate, Reference
        What is believed and what is wanted.
    m_e, gains : float, GeometricGains
        Estimated mass [kg]; ``k_p`` [1/s²] and ``k_v`` [1/s] are used, three numbers each.
    d_w, d_b : Vec3
        Forces that disturb [N], shapes (3,): one stays with the world; one turns with the nose and is told
        in the frame of the heading, x where the nose points seen from above, z up. Only what is horizontal
        counts, whatever stands in the third entries: the mass takes care of the rest.

    Returns
    -------
    Vec3
        f_d [N], world, shape (3,).
    """
    ...


@exercise(points=3, reads="MRS eq. (26), Sec. 5.1.2")
def jerk_feedforward(f_d: Vec3, m_e: float, R_d: Mat3, jerk_d: Vec3) -> Vec3:
    """Body rates with which the thrust axis turns as fast as the wanted jerk turns the wanted force.

    Printed is another law: its unit is m²/s⁵. Derive yours: jerk is the derivative of acceleration, and
    two body rates turn the thrust axis. Turning about that axis makes no jerk: there the answer is 0.

    Parameters
    ----------
    f_d, jerk_d : Vec3
        Desired force [N], along the z axis of `R_d`, and jerk [m/s³], world, shapes (3,).
    m_e, R_d : float, Mat3
        Estimated mass [kg]; desired attitude, body → world, shape (3, 3).

    Returns
    -------
    Vec3
        ω_j [rad/s], in the desired body axes, shape (3,).

    Raises
    ------
    ValueError
        `f_d` is zero.
    """
    ...


@exercise(points=4, reads="MRS eq. (25), Sec. 5.1-5.3")
def rate_command(R: Mat3, R_d: Mat3, heading_rate_d: float, omega_j: Vec3, k_R: Vec3) -> Vec3:
    """Body rates that lead to the wanted attitude, and along with it.

    *Feedback and jerk* as in (25). *Heading rate*, which (25) forgets: it is turned into a yaw rate as
    in Sec. 5.2, with the axes of the wanted attitude. *Parasites*, Sec. 5.3: what the roll and pitch
    rates of feedback and jerk together make of the heading, at the attitude that is flown, is undone by
    a yaw rate; the yaw rates of the other terms are no parasites. (ω_j is used as it is, though it is
    told in the wanted axes: the MRS software does so, and the two are near.)

    Parameters
    ----------
    R, R_d : Mat3
        Attitude flown and attitude wanted, body → world, shapes (3, 3).
    heading_rate_d, omega_j, k_R : float, Vec3, Vec3
        Wanted heading rate; what the jerk asks for [rad/s], shape (3,); gains on e_R [1/s], shape (3,).

    Returns
    -------
    Vec3
        ω_d [rad/s], body, shape (3,). Where a thrust axis is horizontal (|R33| below 1e-6), the yaw
        rate that would be made with it is 0.
    """
    ...


# What nobody told -------------------------------------------------------------------------------------


@exercise(points=3, reads="MRS eq. (35), (36), Sec. 5.5")
def disturbance_step(
    d_w: Vec3, d_b: Vec3, e_p: Vec3, heading: float, dt: float, gains: GeometricGains
) -> tuple[Vec3, Vec3]:
    """One step of the two sums that learn who pushes: the world, or something that turns with the nose.

    Printed, the second sum is turned back into the world, and then (38) cannot know which way the nose
    pointed. Here it stays in the frame of the heading, and who uses it turns it.

    Parameters
    ----------
    d_w, d_b : Vec3
        What is known so far [N], shapes (3,): in the world, and in the frame of the heading (x where
        the nose points seen from above, z up). Their third entries are 0.
    e_p, heading, dt : Vec3, float, float
        Position less wanted position [m], world, shape (3,), the vertical part of which is the mass's
        business; heading of now [rad]; step [s].
    gains : GeometricGains
        ``k_iw``, ``k_ib`` [N/(m s)], and ``d_max`` [N], beyond which no entry of either may grow.

    Returns
    -------
    tuple[Vec3, Vec3]
        d_w and d_b after the step [N], shapes (3,), third entries 0.
    """
    ...


@exercise(points=2, reads="MRS eq. (37), Sec. 5.5")
def estimated_mass(m_e: float, e_z: float, dt: float, m: float, gains: GeometricGains) -> float:
    """One step of the mass that the height tells.

    Printed is a sum that drives an aircraft with a payload into the ground. Think: its thrust is too weak;
    where is it then, which sign has its error, and what should happen to its mass?

    Parameters
    ----------
    m_e, e_z, dt, m : float
        Estimated mass so far [kg]; height less wanted height [m]; step [s]; nominal mass, as weighed [kg].
    gains : GeometricGains
        ``k_m`` [kg/(m s)], and ``m_max`` [kg], the largest difference from the nominal mass. (It is 20 kg
        in the software, for aircraft of any size: so keep a tenth of `m` at least.)

    Returns
    -------
    float
        Estimated mass after the step [kg].
    """
    ...


@exercise(points=2, reads="MRS eq. (53), Sec. 5.8")
def unbiased_acceleration(f_d: float, R: Mat3, d_w: Vec3, d_b: Vec3, m_e: float) -> Vec3:
    """Acceleration that the aircraft should now have, for its estimator: of thrust, weight and disturbances.

    Printed, gravity stands among forces, as if the aircraft had one kilogram.

    Parameters
    ----------
    f_d, R, m_e : float, Mat3, float
        Thrust [N], along the body z axis; attitude flown, body → world; estimated mass [kg].
    d_w, d_b : Vec3
        Forces that disturb [N], world and frame of the heading, shapes (3,). Their third entries do not count.

    Returns
    -------
    Vec3
        a_d [m/s²], world, shape (3,).
    """
    ...


# One floor deeper -------------------------------------------------------------------------------------


@exercise(points=4, reads="Spica eq. (3), (5), Sec. 4")
def torque_command(
    R: Mat3, R_d: Mat3, omega: Vec3, omega_d: Vec3, omega_dot_d: Vec3,
    integral: Vec3, J: Mat3, gains: TorqueGains,
) -> Vec3:  # fmt: skip
    """Torque that leads a rigid body to an attitude that moves, and along with it.

    Spica's errors are wanted less flown, so his e_R is not that of MRS. Mind the frames.

    Parameters
    ----------
    R, R_d : Mat3
        Attitude flown and attitude wanted, body → world, shapes (3, 3).
    omega, omega_d, omega_dot_d : Vec3
        Angular velocity [rad/s], body; wanted one and its derivative [rad/s²], in the wanted axes.
    integral, J : Vec3, Mat3
        Integral of Spica's e_R over time [s], shape (3,), which the caller keeps; inertia [kg m²], body.
    gains : TorqueGains
        ``k_R`` [N m], ``k_iR`` [N m/s] and ``k_omega`` [N m s], three numbers each.

    Returns
    -------
    Vec3
        Torque [N m], body, shape (3,).
    """
    ...


@exercise(points=3, reads="Spica eq. (1), Sec. 4")
def scale_to_limits(
    u: Array, u_gravity: Array, allocation: Array, f_min: float, f_max: float
) -> Array:
    """The most that the rotors can give of what is asked, without a change of direction.

    What is asked beyond the hover is shrunk as a whole until every rotor can do it, and never stretched.
    The thrusts of the rotors are the solution of least norm.

    Parameters
    ----------
    u, u_gravity : Array
        Thrust [N] and torque [N m] that are asked, and that hold the aircraft in hover, shapes (4,).
    allocation, f_min, f_max : Array, float, float
        From rotor thrusts to thrust and torque, shape (4, n), n ≥ 4, of rank 4 (Spica's M); least and
        largest thrust of each rotor [N].

    Returns
    -------
    Array
        Thrust and torque that can be done, shape (4,).

    Raises
    ------
    ValueError
        `u_gravity` alone is outside the limits of some rotor, by more than 1e-9 N.
    """
    ...


# All of it --------------------------------------------------------------------------------------------


@exercise(points=9, reads="MRS Sec. 5.1-5.6, 5.8")
@dataclass(frozen=True)
class GeometricController:
    """The agile controller of MRS: the cascade above, with everything that it learns in flight.

    Parameters
    ----------
    mass, gains : float, GeometricGains
        Nominal mass [kg]; all gains are used, the functions above say what for. ``tilt_max`` [rad] limits
        the force, ``rate_max`` [rad/s], three numbers, each body rate.
    """

    slot: ClassVar[str] = "controller"
    mass: float
    gains: GeometricGains = GROUPS["now"]["soft"]

    def init(self, estimate: Estimate, last: Command | None) -> Memory:
        """Nothing disturbs yet, and the mass is the nominal one.

        Parameters
        ----------
        estimate, last : Estimate, Command or None
            Where the aircraft is; the command before this controller takes over, None if there was none.

        Returns
        -------
        Memory
            Yours, of any kind.
        """
        ...

    def step(
        self, memory: Memory, estimate: Estimate, reference: Reference, dt: float
    ) -> tuple[Memory, Command]:
        """One tick: fly with what is known, then learn from the error of now.

        *Force* (38). It must lift: less than 1 N of vertical force is taken as 1 N. Then its horizontal
        part is cut, direction kept, until it leans by no more than ``tilt_max``.

        *Attitude* with its thrust axis along this force and exactly the heading of the reference,
        (21)-(23). *Rates* (25), with the jerk (26) of this force, each cut at ``rate_max``. *Thrust*: the
        part of this force along the thrust axis of now (Sec. 5.1, not 5.4). *a_d*: (53) of that thrust.
        *Learn*: both disturbances and the mass take one step, and count from the next tick on.

        *Take over*: the first step gives `last` of `init` again. What it differs from the law's own
        command is added to the commands after it and fades, by exp(−dt / 0.5 s) each
        (`uavlab.parts.controllers.fading`).

        Parameters
        ----------
        memory, dt : Memory, float
            Of `init`, `step` or `reframe`; step [s].
        estimate, reference : Estimate, Reference
            What is believed, and what is wanted.

        Returns
        -------
        tuple[Memory, Command]
            Thrust f_d [N], rates omega_d [rad/s], body, and a_d [m/s²], world.
        """
        ...

    def reframe(self, memory: Memory, shift: Shift) -> Memory:
        """The same memory, told in another world (lab 03): what is told in the world turns.

        Parameters
        ----------
        memory, shift : Memory, Shift
            Of `init`, `step` or `reframe`, and it stays as it is; old world → new world.

        Returns
        -------
        Memory
            Yours.
        """
        ...


# What is checked in public
attitude_error.check(laws.a_small_turn)
desired_force.check(laws.errors_die_like_springs)
desired_force.check(laws.a_push_is_taken_off)
jerk_feedforward.check(laws.the_axis_follows_the_force)
rate_command.check(laws.the_nose_turns_as_told)
rate_command.check(laws.the_error_shrinks)
disturbance_step.check(laws.learnt_along_the_nose)
disturbance_step.check(laws.no_more_than_that)
estimated_mass.check(laws.hanging_low)
unbiased_acceleration.check(laws.still_in_the_wind)
torque_command.check(laws.the_rate_error_dies)
torque_command.check(laws.at_rest_it_turns_back)
scale_to_limits.check(laws.as_much_as_can_be)
GeometricController.check(laws.hovers_at_once)
GeometricController.check(laws.taken_over_without_a_jump)
