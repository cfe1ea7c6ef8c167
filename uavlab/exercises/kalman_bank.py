"""Lab 03, many hypotheses and one flight: a Kalman filter, a bank of them, who flies, and what a switch does."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from uavlab.exercises import kalman_bank_checks as laws
from uavlab.exercises.spec import exercise
from uavlab.interfaces import Memory, Readings
from uavlab.types import Array, Command, Estimate, Hypothesis, Reference, Shift

# One filter -------------------------------------------------------------------------------------------


@exercise(points=2, reads="MRS eq. (8)-(10), Sec. 3.1")
def translation_model(dt: float, p: float) -> tuple[Array, Array]:
    """Model of one axis, x[t] = A x[t−1] + B u[t], with the states position, velocity, acceleration.

    The acceleration goes towards the one that was asked for, the input.

    Parameters
    ----------
    dt, p : float
        Step [s]; share of the acceleration that is left after one step, 0 to 1.

    Returns
    -------
    tuple[Array, Array]
        A, shape (3, 3), and B, shape (3, 1).
    """
    ...


@exercise(points=1, reads="MRS eq. (8), (9), (11), Sec. 3.1")
def heading_model(dt: float, p: float) -> tuple[Array, Array]:
    """Model of the heading, with the states heading and heading rate; the rate goes towards the input.

    Parameters
    ----------
    dt, p : float
        Step [s]; share of the rate that is left after one step, 0 to 1.

    Returns
    -------
    tuple[Array, Array]
        A, shape (2, 2), and B, shape (2, 1).
    """
    ...


@exercise(points=3, reads="MRS eq. (7), Sec. 3.2")
def predict(x: Array, P: Array, u: Array, A: Array, B: Array, Q: Array) -> tuple[Array, Array]:
    """One step of a linear Kalman filter without a measurement.

    Parameters
    ----------
    x, P : Array
        State, shape (n,); covariance of its error, shape (n, n), symmetric and positive definite.
    u : Array
        Input, shape (k,).
    A, B : Array
        Model of one step, shapes (n, n) and (n, k).
    Q : Array
        Covariance of what the model misses in one step, shape (n, n), symmetric; it may be
        singular. (Not per second: the MRS software keeps that, and multiplies by dt.)

    Returns
    -------
    tuple[Array, Array]
        State, shape (n,), and its covariance, shape (n, n), symmetric.

    Raises
    ------
    ValueError
        Shapes that do not fit, numbers that are not finite, P not symmetric and positive definite,
        or Q with a negative eigenvalue. `uavlab.covariance` has functions that raise it.
    """
    ...


@exercise(points=4, reads="MRS Sec. 3.2")
def correct(x: Array, P: Array, z: Array, H: Array, R_z: Array) -> tuple[Array, Array, float]:
    """One measurement z = H x + noise, weighed against what the filter believes.

    Parameters
    ----------
    x, P : Array
        State, shape (n,); covariance of its error, shape (n, n), symmetric and positive definite.
    z : Array
        Measurement, shape (m,).
    H : Array
        What it sees of the state, shape (m, n).
    R_z : Array
        Covariance of its noise, shape (m, m), symmetric and positive definite.

    Returns
    -------
    tuple[Array, Array, float]
        State, shape (n,); its covariance, shape (n, n), symmetric and positive definite; and the
        normalised innovation squared νᵀ S⁻¹ ν of this measurement, with ν the innovation and S its
        covariance. About m when all is well.

    Raises
    ------
    ValueError
        Shapes that do not fit, numbers that are not finite, P or R_z not symmetric and positive
        definite. `uavlab.covariance` has functions that raise it.
    """
    ...


# A bank of them ---------------------------------------------------------------------------------------


@exercise(points=9, reads="MRS Sec. 3.1.1, 3.2, 3.4, 3.5")
@dataclass(frozen=True)
class KalmanBank:
    """Filters in parallel, each corrected by other sources, each in its own world, 11 states each.

    A member is four small filters that do not know of each other: x, y, z with `translation_model`,
    the heading with `heading_model`. A source is ``"instrument.quantity"``, one of
    `uavlab.sources.SOURCES`; `uavlab.sources.measured` says what a reading of it tells. A position
    or velocity corrects x and y, each with the variance of the source; a height corrects z.

    Parameters
    ----------
    members : dict[str, tuple[str, ...]]
        Member → the sources that correct it.
    variances : dict[str, float]
        Source → variance of its noise, in the square of its unit.
    p : tuple[float, float, float]
        What is left of horizontal acceleration, vertical acceleration and heading rate after 0.01 s
        (after dt: p to the power dt / 0.01). A heading has no input, so its rate is kept.
    q_xy, q_z, q_heading : tuple
        Variances that the states gain per second: Q = dt diag(q).
    start : tuple[float, float, float, float, float]
        Standard deviations at the start of position [m], velocity [m/s], acceleration [m/s²],
        heading [rad] and heading rate [rad/s].
    gate, forget, limits : float, float, tuple[float, float]
        Of normalised innovations squared per degree of freedom: above which one is rejected; the weight
        of the newest in their running mean; below which mean of each source a member becomes
        reliable, and above which it ceases to be.
    patience : float
        Time [s] without a reading that was taken, after which a source counts as lost.
    tilt : float
        Tilt [rad] beyond which instruments that look down (flow, rangefinder) are rejected.

    Raises
    ------
    LookupError
        A source that is not known, or has no variance (`uavlab.sources.check_members` raises it).
    """

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

    def init(self, estimate: Estimate) -> Memory:
        """Every member believes the estimate, with the standard deviations of `start`.

        Parameters
        ----------
        estimate : Estimate
            Where the aircraft is. If ``estimate.world`` names a member, that member lives in this
            world already: it is reliable, and its sources count as heard just now. The others have
            heard nothing yet, and are not reliable.

        Returns
        -------
        Memory
            Yours, of any kind.
        """
        ...

    def step(
        self, memory: Memory, readings: Readings, command: Command, dt: float, flies: str = ""
    ) -> tuple[Memory, dict[str, Hypothesis]]:
        """Predict every member by `dt`, correct each with those of the readings that it hears.

        *Input.* ``command.a_d``, turned about the vertical into the world of each member.

        *Attitude.* The autopilot's (``readings["attitude"]``), else the last one turned on by the
        gyro. A member's own attitude is that one, turned about the vertical to the member's
        heading. The gyro gives the heading rate through (15), source ``"imu.heading_rate"``.

        *Start.* The first reading of a source, and the first after it was lost, is taken as it is:
        the state that it tells becomes what it says, with the variance of the source. So a member
        begins in the world of its instruments. If that is a heading, velocity and acceleration of
        the member turn along, unless an instrument already tells its position or velocity.

        *Delay.* A reading that is true at an earlier time than the newest one heard of corrects
        what was true then (`uavlab.sources.late`).

        *Rejected and counted* are: numbers that are not finite; times that are not later than the
        last of that instrument, or further than `patience` from the newest time; normalised
        innovations above `gate` (of x and y together); instruments that look down, beyond `tilt`;
        and positions and heights whose own ``std`` is more than three times that of their source.

        *Health.* For each source a running mean m ← m + forget (min(ν, gate) − m) from m = 1, ν the
        normalised innovation squared per degree of freedom, of rejected innovations too. Reliable
        is a member none of whose sources is lost, nor has a mean above the limit.

        Parameters
        ----------
        memory : Memory
            Of `init`, `step` or `reframe`.
        readings : Readings
            What arrived since the last step, by instrument.
        command : Command
            The last one. Its ``a_d`` [m/s²] is told in the world of the member that flies.
        dt : float
            Step [s].
        flies : str
            The member that flies. Empty: nobody yet; ``a_d`` is taken as it is by all.

        Returns
        -------
        tuple[Memory, dict[str, Hypothesis]]
            What each member believes. ``nis`` is the mean over its sources.
        """
        ...

    def reframe(self, memory: Memory, shift: Shift) -> Memory:
        """The same memory after the worlds of all members, and of all their instruments, have moved.

        Parameters
        ----------
        memory : Memory
            As in `step`.
        shift : Shift
            Old worlds → new ones. North, and the ground below the rangefinder, move along.

        Returns
        -------
        Memory
            Told in the new worlds.
        """
        ...

    def rejected(self, memory: Memory) -> dict[str, int]:
        """How many readings were rejected.

        Parameters
        ----------
        memory : Memory
            As in `step`.

        Returns
        -------
        dict[str, int]
            Member → how many of what it hears. One that is bad as a whole (not finite, wrong time)
            counts once, else each source counts; an attitude counts for everybody.
        """
        ...


# Who flies, and what a switch does --------------------------------------------------------------------


@exercise(points=3, reads="MRS Sec. 3.5")
def arbitrate(hypotheses: Mapping[str, Hypothesis], current: str, request: str) -> str:
    """Which hypothesis flies next.

    First the one that was requested, if it is reliable. Else, if the current one is not reliable,
    the reliable one with the least covariance; if it is, only one with less than half of its covariance
    (ours: two of about the same size would take turns). If none is reliable, the current one stays.
    Covariances are compared by the trace of the positions' part.

    Parameters
    ----------
    hypotheses : Mapping[str, Hypothesis]
        All of them, by name.
    current : str
        The one that flies now.
    request : str
        The one that was asked for; empty: none.

    Returns
    -------
    str
        A name.

    Raises
    ------
    LookupError
        No such name: ``uavlab.errors.UnknownName("hypothesis", name, hypotheses)``, or a KeyError.
    """
    ...


@exercise(points=2, reads="MRS Sec. 3.5")
def shift_between(a: Hypothesis, b: Hypothesis) -> Shift:
    """Change of world from that of `a` to that of `b`: a turn about the vertical, and a translation.

    Parameters
    ----------
    a : Hypothesis
        What one filter believes, in its world.
    b : Hypothesis
        What another one believes of the same aircraft, in its world.

    Returns
    -------
    Shift
        ``r_b = Rz(heading) r_a + r``, with a heading in [−π, π).
    """
    ...


@exercise(points=2, reads="MRS Sec. 3.5")
def moved_reference(reference: Reference, shift: Shift) -> Reference:
    """The same reference, told in another world: it stays where it physically is.

    Parameters
    ----------
    reference : Reference
        Told in the old world.
    shift : Shift
        Old world → new world.

    Returns
    -------
    Reference
        Told in the new world. Its heading [rad] is not wrapped: one that has wound up some turns goes on.
    """
    ...


# What is checked in public
translation_model.check(laws.a_throw)
translation_model.check(laws.towards_the_input)
heading_model.check(laws.a_steady_turn)
predict.check(laws.a_cloud_of_points)
correct.check(laws.two_opinions_of_one_number)
KalmanBank.check(laws.each_in_its_own_world)
KalmanBank.check(laws.one_member_is_one_filter)
KalmanBank.check(laws.a_source_that_is_not_there, weight=0)
arbitrate.check(laws.requested_or_left)
shift_between.check(laws.one_aircraft)
moved_reference.check(laws.as_the_aircraft_sees_it)
