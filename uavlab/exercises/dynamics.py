"""Lab 01, what a multirotor is: a rigid body, rotors around it, and motors that take their time."""

from __future__ import annotations

import numpy as np

from uavlab import so3
from uavlab.exercises import draw
from uavlab.exercises.expect import expect_rotation, expect_state_rate
from uavlab.exercises.spec import Function, exercise, expect, expect_close, numbers
from uavlab.types import Array, Mat3, State, StateRate, Vec3


@exercise(points=4, reads="MRS eq. (1), (2), Sec. 2; Spica eq. (3)")
def rigid_body_rate(state: State, force: Vec3, torque: Vec3, *, m: float, J: Mat3) -> StateRate:
    """Time derivative of the state of a rigid body that is pushed and twisted.

    A force moves the centre of mass, a torque turns the body about it. The force is told in the
    world and the torque in the body; the angular momentum of a turning body must be differentiated
    in a frame that turns with it.

    Parameters
    ----------
    state : State
        Position ``r`` [m], velocity ``v`` [m/s] (world), rotation ``R`` (body → world), angular
        velocity ``omega`` [rad/s] (body).
    force : Vec3
        Sum of all forces [N], world, shape (3,): thrust, weight and whatever else there is.
    torque : Vec3
        Sum of all torques about the centre of mass [N m], body, shape (3,).
    m : float
        Mass [kg], above zero.
    J : Mat3
        Inertia about the centre of mass [kg m²], body, shape (3, 3), in general not diagonal.

    Returns
    -------
    StateRate
        ``(r_dot, v_dot, R_dot, omega_dot)``: world [m/s, m/s²], [1/s], body [rad/s²].
    """
    ...


@rigid_body_rate.check
def velocity_and_force(f: Function, rng: np.random.Generator) -> None:
    """The position changes with the velocity, and the velocity with force over mass, both in the world."""
    for _ in range(3):
        state, force, torque, m, J = draw.pushed(rng)
        rate = expect_state_rate(f(state, force, torque, m=m, J=J))
        expect_close(rate.r_dot, state.v, "r_dot is not right.")
        expect_close(m * rate.v_dot, force, "v_dot is not right.")


@rigid_body_rate.check
def rotation_follows_the_rate(f: Function, rng: np.random.Generator) -> None:
    """R_dot must be the derivative of R while the body turns with omega, told in body axes."""
    h = 1e-5
    for _ in range(3):
        state, force, torque, m, J = draw.pushed(rng)
        ahead, behind = (state.R @ so3.exp(s * h * state.omega) for s in (1, -1))
        rate = expect_state_rate(f(state, force, torque, m=m, J=J))
        expect_close(rate.R_dot, (ahead - behind) / (2 * h), "R_dot is not right.", atol=1e-6)


@rigid_body_rate.check
def spin_about_a_principal_axis(f: Function, rng: np.random.Generator) -> None:
    """Twisted back about an axis of symmetry, the body only turns slower about that same axis."""
    for axis in np.eye(3):
        state, force, _, m, _ = draw.pushed(rng)
        moments = rng.uniform(0.01, 0.1, size=3)
        state = state._replace(omega=rng.uniform(1.0, 5.0) * axis)
        torque = -rng.uniform(0.1, 1.0) * moments * axis
        rate = expect_state_rate(f(state, force, torque, m=m, J=np.diag(moments)))
        expect_close(np.cross(rate.omega_dot, axis), np.zeros(3), "omega_dot leaves the axis.")
        expect(rate.omega_dot @ axis < -0.05, "omega_dot must have the sign of the torque.")


@exercise(points=3, reads="MRS eq. (2), Sec. 2")
def step_on_so3(R: Mat3, omega: Vec3, dt: float) -> Mat3:
    """Rotation after `dt` seconds of turning with a constant body rate.

    The exact solution of (2): the result is a rotation however long `dt` is, and two half steps
    make one whole step.

    Parameters
    ----------
    R : Mat3
        Rotation at the start, body → world, shape (3, 3).
    omega : Vec3
        Angular velocity [rad/s], body, shape (3,), constant. Zero is allowed, and leaves R.
    dt : float
        Time [s], any sign, any length.

    Returns
    -------
    Mat3
        Rotation at the end, body → world, shape (3, 3), orthonormal to rounding.
    """
    ...


@step_on_so3.check
def stays_a_rotation(f: Function, rng: np.random.Generator) -> None:
    """However long the step is, the result must be a rotation, and not the one it started from."""
    for dt in (0.01, 0.3, 2.0):
        R, omega = draw.rotation(rng), rng.uniform(0.5, 4.0) * draw.direction(rng)
        new = expect_rotation(f(R, omega, dt))
        angle = np.linalg.norm(omega) * dt
        expect_close(np.cos(so3.angle(R, new)), np.cos(angle), "It turned by the wrong angle.")


@step_on_so3.check
def about_one_axis(f: Function, rng: np.random.Generator) -> None:
    """Turning about the body z axis turns the body x axis towards the body y axis."""
    for dt in (0.05, 0.3, 1.0):
        R, angle = draw.rotation(rng), draw.angle(rng)
        want = R[:, 0] * np.cos(angle) + R[:, 1] * np.sin(angle)
        new = numbers(f(R, np.array((0.0, 0.0, angle / dt)), dt), (3, 3))
        expect_close(new[:, 0], want, "The x axis is not there.")


@exercise(points=3, reads="Spica eq. (1), Sec. 4")
def allocation_matrix(angles: Array, arm: float, torque_ratio: float, spins: Array) -> Array:
    """Matrix that maps the thrusts of n rotors to collective thrust and torque.

    All rotors push along body z, at one distance from the centre of mass and anywhere around it
    (two may sit above each other). For the rotors of Spica this is the matrix M of (1).

    Parameters
    ----------
    angles : Array
        Where the arms point [rad], shape (n,): from body x, counter-clockwise seen from above.
    arm : float
        Distance of every rotor axis from the centre of mass [m].
    torque_ratio : float
        Drag torque of a rotor over its thrust [m], c in (1).
    spins : Array
        +1 or −1, shape (n,): the sign of the torque about body z with which a rotor twists the body.

    Returns
    -------
    Array
        Shape (4, n): ``matrix @ thrusts`` is ``[f, tau_x, tau_y, tau_z]`` [N, N m], body.
    """
    ...


@allocation_matrix.check(weight=0)
def the_quadrotor_of_the_paper(f: Function, rng: np.random.Generator) -> None:
    """With four rotors at 0, 90, 180 and 270 degrees this must be the matrix M of Spica eq. (1)."""
    l, c = 0.25, 0.0174
    M = [[1, 1, 1, 1], [0, l, 0, -l], [-l, 0, l, 0], [c, -c, c, -c]]
    got = f(np.radians([0.0, 90.0, 180.0, 270.0]), l, c, np.array([1.0, -1.0, 1.0, -1.0]))
    expect_close(got, M)


@allocation_matrix.check
def a_push_at_an_arm(f: Function, rng: np.random.Generator) -> None:
    """The torque of a rotor is its arm crossed with its thrust, plus its drag torque about body z."""
    for n in (4, 6):
        angles, arm, c, spins = draw.layout(rng, n)
        M = numbers(f(angles, arm, c, spins), (4, n))
        thrusts = rng.uniform(0.0, 10.0, size=n)
        places = np.array([arm * so3.about_z(angle)[:, 0] for angle in angles])
        pushes = np.outer(thrusts, (0.0, 0.0, 1.0))
        tau = (np.cross(places, pushes) + c * spins[:, None] * pushes).sum(axis=0)
        expect_close(M @ thrusts, [thrusts.sum(), *tau], "The torque is not right.")


@exercise(points=2, reads="Spica Sec. 4, below eq. (5)")
def rotor_thrusts(f: float, tau: Vec3, allocation: Array) -> Array:
    """Thrusts of the rotors that make a collective thrust and a torque.

    With four rotors there is one answer. With more there are many: take the one with the least sum
    of squares. Limits are not looked at: a rotor may be asked to pull.

    Parameters
    ----------
    f : float
        Collective thrust [N] along body z.
    tau : Vec3
        Torque [N m], body, shape (3,).
    allocation : Array
        What `allocation_matrix` returns, shape (4, n), n ≥ 4, of rank 4.

    Returns
    -------
    Array
        Thrust of each rotor [N], shape (n,).
    """
    ...


@rotor_thrusts.check
def makes_what_was_asked(f: Function, rng: np.random.Generator) -> None:
    """The thrusts, sent through the allocation matrix, must give back the thrust and the torque."""
    for n in (4, 6):
        M = draw.allocation(rng, n)
        lift, tau = float(rng.uniform(5.0, 40.0)), draw.vector(rng, 0.5)
        got = numbers(f(lift, tau, M), (n,))
        expect_close(M @ got, [lift, *tau], "They make another thrust or torque.")


@rotor_thrusts.check
def hover_is_shared(f: Function, rng: np.random.Generator) -> None:
    """Where equal thrusts make no torque, every rotor carries the same share of a hover."""
    for n in (4, 6, 8):
        share = float(rng.uniform(1.0, 8.0))
        got = f(n * share, np.zeros(3), draw.allocation(rng, n, balanced=True))
        expect_close(got, np.full(n, share))


@exercise(points=2, reads="Spica Sec. 5.3")
def motor_step(speed: Array, command: Array, tau: float, dt: float) -> Array:
    """Speeds of the motors after `dt` seconds of a constant command: exact for any `dt`.

    A motor is a first-order lag: it closes a gap to the command at a rate in proportion to the gap.

    Parameters
    ----------
    speed : Array
        Speeds at the start [rad/s], shape (n,).
    command : Array
        Commanded speeds [rad/s], shape (n,), held during the step.
    tau : float
        Time constant [s], above zero; 0.047 s in the paper.
    dt : float
        Time [s], from zero to many time constants.

    Returns
    -------
    Array
        Speeds at the end [rad/s], shape (n,).
    """
    ...


@motor_step.check
def one_time_constant(f: Function, rng: np.random.Generator) -> None:
    """After one time constant 1/e of the gap is left, and after none all of it."""
    for _ in range(3):
        speed, command = rng.uniform(100.0, 900.0, size=(2, 4))
        tau = float(rng.uniform(0.02, 0.1))
        left = numbers(f(speed, command, tau, tau), (4,)) - command
        expect_close(left, (speed - command) / np.e, "Another share of the gap is left.")
        expect_close(f(speed, command, tau, 0.0), speed, "With dt = 0 nothing may change.")


@motor_step.check
def no_overshoot(f: Function, rng: np.random.Generator) -> None:
    """A long step arrives at the command, and never passes it."""
    for share in (1.5, 3.0, 40.0):
        speed, command = rng.uniform(100.0, 900.0, size=(2, 6))
        tau = float(rng.uniform(0.02, 0.1))
        new = numbers(f(speed, command, tau, share * tau), (6,))
        left = (new - command) / (speed - command)
        low, high = (0.01, 0.25) if share < 30.0 else (-1e-12, 1e-9)
        expect(np.all(left >= low), "The speed passed the command, or met it too early.")
        expect(np.all(left <= high), "The speed is still far from the command.")


@exercise(points=2, reads="MRS eq. (32), Sec. 5.4")
def throttle_from_force(f: float, a_t: float, b_t: float) -> float:
    """Collective throttle that makes a thrust force, which grows with the square of the rotor speed.

    Parameters
    ----------
    f : float
        Collective thrust force [N]. Rotors cannot pull: below zero it counts as zero.
    a_t, b_t : float
        Slope [1/√N], above zero, and offset [1] of the thrust curve, for the sum of all rotors.

    Returns
    -------
    float
        Throttle [1], not clipped: outside [0, 1] the motors cannot do it.
    """
    ...


@throttle_from_force.check
def fourfold_force(f: Function, rng: np.random.Generator) -> None:
    """Four times the force needs twice the rotor speed: twice the throttle above the offset b_t."""
    for _ in range(3):
        (a_t, b_t), force = draw.thrust_curve(rng), float(rng.uniform(1.0, 4.0))
        low, high = (numbers(f(x, a_t, b_t), ()) - b_t for x in (force, 4.0 * force))
        expect_close(high, 2.0 * low)
        expect_close((low / a_t) ** 2, force, "The slope is not right.")
        expect(low > 0.0, "More force needs more throttle.")


@exercise(points=2, reads="MRS eq. (32), (34), Sec. 5.4")
def force_from_throttle(T: float, a_t: float, b_t: float) -> float:
    """Thrust force that a collective throttle makes: the thrust curve read backwards.

    Parameters
    ----------
    T : float
        Throttle [1]. At b_t and below the rotors stand still, and there is no force.
    a_t, b_t : float
        Slope [1/√N], above zero, and offset [1] of the thrust curve, for the sum of all rotors.

    Returns
    -------
    float
        Collective thrust force [N], never below zero.
    """
    ...


@force_from_throttle.check
def lies_on_the_curve(f: Function, rng: np.random.Generator) -> None:
    """The force at throttle T must be the one that needs throttle T."""
    for _ in range(3):
        (a_t, b_t), T = draw.thrust_curve(rng), float(rng.uniform(0.1, 1.0))
        got = numbers(f(T, a_t, b_t), ())
        expect(got > 0.0, "A force above zero is asked for.")
        expect_close(a_t * np.sqrt(got) + b_t, T, "This force needs another throttle.")


@exercise(points=2, reads="MRS eq. (33), (34), Sec. 5.4")
def apparent_mass(T: float, a_t: float, b_t: float, g: float) -> float:
    """Mass that would hover at this throttle; on the ground it drops, which tells a landing.

    Parameters
    ----------
    T : float
        Throttle [1]. At b_t and below the rotors stand still and carry no mass.
    a_t, b_t : float
        Slope [1/√N], above zero, and offset [1] of the thrust curve, for the sum of all rotors.
    g : float
        Gravity [m/s²], above zero.

    Returns
    -------
    float
        Apparent mass [kg], never below zero.
    """
    ...


@apparent_mass.check
def hovers_at_that_throttle(f: Function, rng: np.random.Generator) -> None:
    """An aircraft of the apparent mass must hover at throttle T, by eq. (33)."""
    for _ in range(3):
        a_t, b_t = draw.thrust_curve(rng)
        T, g = float(rng.uniform(0.1, 1.0)), float(rng.uniform(1.5, 12.0))
        got = numbers(f(T, a_t, b_t, g), ())
        expect(got > 0.0, "A mass above zero is asked for.")
        expect_close(a_t * np.sqrt(got * g) + b_t, T, "It hovers at another throttle.")
