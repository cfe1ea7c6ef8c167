"""Lab 06, continued: the two parts that fly on its programmes, each a class."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from uavlab.exercises import mpc_parts_checks as laws
from uavlab.exercises.spec import exercise
from uavlab.gains import MpcGains
from uavlab.interfaces import Memory
from uavlab.limits import ForceLimits, Limits
from uavlab.types import Command, Estimate, Reference, Shift, Trajectory


@exercise(points=6, reads="MRS eq. (18)-(20), (24), (31), (35)-(53), Sec. 5.7, 5.8")
@dataclass(frozen=True)
class MpcController:
    """A force by looking ahead, an attitude by feedback: the controller for estimates that are rough.

    *Plan.* For each axis `build_force_qp`, from its row of `initial_state`, to the position of the reference,
    without velocity or acceleration, at all steps (44). x, y: ``limits.horizontal``, p = 0, HORIZONTAL; z:
    ``limits.vertical``, p = 0.5, VERTICAL. The first input of each plan is c_d, and the last input of the next.
    Plan with `uavlab.solvers.Solver` and `affine`: a step that takes more than 5 ms is too slow.

    *Force.* (39): m_e (a of the reference + c_d + g e_3) − d_w − H d_b, leaning no more than ``tilt_max``
    (`uavlab.parts.controllers.limited_tilt`).

    *Disturbances.* First of all each step (but one that takes over) adds, with e_p = r − r_d: k_iw e_p dt to
    d_w (world) and k_ib Hᵀ e_p dt to d_b (heading frame; H turns it when it is used), horizontally, within
    ±d_max on each axis; and −k_m e_z dt to m_e (against the sign of (37)), within m_max of `mass`. d_w and d_b
    rest above 0.3 m/s.

    *Attitude.* R_d of (18)-(20) from force and heading wanted, and the rate −k_R ∘ e_R (24), plus the yaw
    rate for the heading rate of the reference (31), within ±rate_max. f_d is the force along the measured
    b_3, and a_d = (f_d b_3 + d_w + H d_b)/m_e − g e_3, which is (53), corrected.

    *Hand-over.* The first step after an `init` with a command repeats it. It learns nothing, and its period
    is 0, so that the inputs stay as they were. What differs fades with 0.5 s afterwards:
    `uavlab.parts.controllers.fading`. `uavlab.frames.moved` turns a command.

    *Failure.* An axis without a solution, or with numbers that are not finite, flies on with its last
    plan, shifted by one step. Disturbances and mass rest; no command is NaN.

    Parameters
    ----------
    mass, limits : float, ForceLimits
        What it is told [kg]; velocity, acceleration and jerk.
    N, dt, gains : int, float, MpcGains
        Steps of a plan; length of each [s]; attitude, disturbances and mass.
    """

    slot: ClassVar[str] = "controller"
    mass: float
    limits: ForceLimits = ForceLimits()
    N: int = 26
    dt: float = 0.05
    gains: MpcGains = MpcGains()

    def init(self, estimate: Estimate, last: Command | None) -> Memory:
        """Take over: a_d of the last command, within the limits, is the last input; without one, 0.

        Parameters
        ----------
        estimate, last : Estimate, Command or None
            Where the aircraft is; what was commanded before.

        Returns
        -------
        Memory
            Yours, of any kind.
        """
        ...

    def step(
        self, memory: Memory, estimate: Estimate, reference: Reference, dt: float
    ) -> tuple[Memory, Command]:
        """Plan, and command the beginning of the plan.

        Parameters
        ----------
        memory, estimate, reference, dt : Memory, Estimate, Reference, float
            `dt` [s] is the time since the last step, and the period of the QPs.

        Returns
        -------
        tuple[Memory, Command]
            After the step.
        """
        ...

    def reframe(self, memory: Memory, shift: Shift) -> Memory:
        """Tell in another world all that is told in this one: inputs, plans, d_w, the hand-over.

        Parameters
        ----------
        memory, shift : Memory, Shift
            Told in the old world; old world → new one. (Inputs of x and y turn as one vector.)

        Returns
        -------
        Memory
            Told in the new world.
        """
        ...

    def failures(self, memory: Memory) -> int:
        """How many steps have flown on an old plan, on one axis or more.

        Parameters
        ----------
        memory : Memory
            As in `step`.

        Returns
        -------
        int
            Since `init`.
        """
        ...


@exercise(points=6, reads="MRS eq. (16), Sec. 4.1")
@dataclass(frozen=True)
class MpcTracker:
    """A reference that an aircraft can follow, from a goal that it could not: a model that a QP steers.

    *Model.* Each axis is a chain of position, velocity, acceleration, jerk, driven by its snap; the heading
    is a fourth one. A step gives the reference of now, and moves the model on by the first snap of the plan.

    *Plan.* N steps of `dt`, anew in each step, towards the position of the goal (a moving one goes on with
    its v). The reference must keep within 3 % of all limits, also between the points of the plan, once it has
    been within them: plan for a little less. ``up`` bounds what is above 0, ``down`` what is below. Speeds
    and accelerations are better soft. Choose weights that arrive: near a goal at rest, within 0.05 m, in due
    time, and no more than 0.1 m beyond.

    *Trajectory.* Points at times t since it was given, linear in between; held after the last, as the first is
    before. The plan looks along it. (`uavlab.parts.trackers`: `unwrapped`, `along`, and `why_not` for bad goals.)

    *Heading.* The short way round, told within [−π, π].

    *Failure.* Without a new plan the last one, shifted by one step. A goal that is not finite is passed
    over, and counts as a failure.

    Parameters
    ----------
    limits : Limits
        Of speed, acceleration, jerk, snap: ``horizontal`` of x and of y, ``up``, ``down``, ``heading``.
    N, dt : int, float
        Steps of a plan; length of each [s].
    """

    slot: ClassVar[str] = "tracker"
    limits: Limits
    N: int = 40
    dt: float = 0.2

    def init(self, estimate: Estimate, last: Reference | None) -> Memory:
        """Continue from the last reference; without one, from position, velocity and heading of the estimate.

        Parameters
        ----------
        estimate, last : Estimate, Reference or None
            Where the aircraft is; what was wanted last.

        Returns
        -------
        Memory
            Yours, of any kind. Until there is a goal, the model comes to rest.
        """
        ...

    def step(
        self, memory: Memory, estimate: Estimate, goal: Reference | Trajectory | None, dt: float
    ) -> tuple[Memory, Reference]:
        """The reference of now; then the model moves on.

        Parameters
        ----------
        memory, estimate : Memory, Estimate
            The estimate is not used: what is wanted does not follow what is.
        goal, dt : Reference or Trajectory or None, float
            A new goal, from now on; None: as before. Time until the next step [s].

        Returns
        -------
        tuple[Memory, Reference]
            The model after `dt`; and what it was before.
        """
        ...

    def reframe(self, memory: Memory, shift: Shift) -> Memory:
        """Tell the model, its plans and its goal in another world.

        Parameters
        ----------
        memory, shift : Memory, Shift
            Told in the old world; old world → new one.

        Returns
        -------
        Memory
            Told in the new world.
        """
        ...

    def failures(self, memory: Memory) -> int:
        """How many steps had no new plan, or a goal that was not finite.

        Parameters
        ----------
        memory : Memory
            As in `step`.

        Returns
        -------
        int
            Since `init`.
        """
        ...


# What is checked in public
MpcController.check(laws.hovers_where_it_is_wanted)
MpcController.check(laws.takes_over_unnoticed)
MpcController.check(laws.goes_to_a_point)
MpcTracker.check(laws.continues_what_was_wanted)
MpcTracker.check(laws.one_moves_the_other)
MpcTracker.check(laws.arrives_within_its_limits)
