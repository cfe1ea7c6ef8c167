"""Known wrong answers of lab 07, continued: torques, and what the rotors can give."""

from __future__ import annotations

import numpy as np

from grader.material import Arguments, mutant, sample
from uavlab import so3
from uavlab.exercises import draw
from uavlab.exercises.geometric import scale_to_limits, torque_command
from uavlab.exercises.geometric_checks import some_mass, three
from uavlab.gains import TorqueGains
from uavlab.solutions import geometric as right
from uavlab.types import GRAVITY

CANARY = "canary-d95b63e01fa84c27b80c4d16"

# torque_command ---------------------------------------------------------------------------------------


@sample(torque_command)
def tumbling_bodies(rng: np.random.Generator) -> list[Arguments]:
    made = []
    for _ in range(4):
        R = draw.rotation(rng)
        k = TorqueGains(
            k_R=three(rng, 0.5, 2.0), k_iR=three(rng, 0.2, 1.0), k_omega=three(rng, 0.1, 0.4)
        )
        omega, omega_d, dot, integral = (draw.vector(rng) for _ in range(4))
        R_d = R @ so3.exp(draw.vector(rng, 0.6))
        made.append((R, R_d, omega, omega_d, dot, integral, draw.inertia(rng), k))
    return made


def torque(
    R, R_d, w, w_d, dot, integral, J, k, *, e=1.0, i=1.0, v=1.0, gyro=1.0, cross=1.0, seen=True, ahead=True
):  # fmt: skip
    """(5), for whatever is taken for its parts."""
    Q = R.T @ R_d
    wanted = Q @ w_d if seen else w_d
    pull = e * np.multiply(k.k_R, -right.attitude_error(R, R_d)) + i * np.multiply(k.k_iR, integral)
    pull = pull + np.multiply(k.k_omega, v * (wanted - w))
    forward = (Q @ dot if ahead else dot) - cross * np.cross(w, Q @ w_d if ahead else w_d)
    return pull + gyro * np.cross(w, J @ w) + J @ forward


@mutant(
    torque_command,
    hint="The attitude error has the sign of MRS: Spica's is wanted less flown, and is added.",
)
def error_of_mrs(R, R_d, omega, omega_d, omega_dot_d, integral, J, gains):
    return torque(R, R_d, omega, omega_d, omega_dot_d, integral, J, gains, e=-1.0)


@mutant(
    torque_command,
    hint="The half in the attitude error is missing: a small turn must give its own vector.",
)
def whole_error(R, R_d, omega, omega_d, omega_dot_d, integral, J, gains):
    return torque(R, R_d, omega, omega_d, omega_dot_d, integral, J, gains, e=2.0)


@mutant(torque_command, hint="The integral is not used: a crooked propeller will stay uncorrected.")
def integral_forgotten(R, R_d, omega, omega_d, omega_dot_d, integral, J, gains):
    return torque(R, R_d, omega, omega_d, omega_dot_d, integral, J, gains, i=0.0)


@mutant(
    torque_command,
    hint="The integral has the wrong sign: it is that of Spica's e_R, and is added.",
)
def integral_subtracted(R, R_d, omega, omega_d, omega_dot_d, integral, J, gains):
    return torque(R, R_d, omega, omega_d, omega_dot_d, integral, J, gains, i=-1.0)


@mutant(
    torque_command,
    hint="The rate error has the wrong sign: wanted less flown, or it will not damp.",
)
def spun_up(R, R_d, omega, omega_d, omega_dot_d, integral, J, gains):
    return torque(R, R_d, omega, omega_d, omega_dot_d, integral, J, gains, v=-1.0)


@mutant(
    torque_command,
    hint="The gyroscopic torque ω × J ω is not taken off: the body's axes will couple.",
)
def gyroscopic_forgotten(R, R_d, omega, omega_d, omega_dot_d, integral, J, gains):
    return torque(R, R_d, omega, omega_d, omega_dot_d, integral, J, gains, gyro=0.0)


@mutant(
    torque_command,
    hint="The gyroscopic torque has the wrong sign: it stands on the left of (3), with a plus.",
)
def gyroscopic_doubled(R, R_d, omega, omega_d, omega_dot_d, integral, J, gains):
    return torque(R, R_d, omega, omega_d, omega_dot_d, integral, J, gains, gyro=-1.0)


@mutant(
    torque_command,
    hint="The wanted rates are compared as they are: turn them from the wanted axes into the flown ones.",
)
def rates_not_turned(R, R_d, omega, omega_d, omega_dot_d, integral, J, gains):
    return torque(R, R_d, omega, omega_d, omega_dot_d, integral, J, gains, seen=False)


@mutant(
    torque_command,
    hint="What is fed forward is not turned from the wanted axes into the flown ones.",
)
def feedforward_not_turned(R, R_d, omega, omega_d, omega_dot_d, integral, J, gains):
    return torque(R, R_d, omega, omega_d, omega_dot_d, integral, J, gains, ahead=False)


@mutant(
    torque_command,
    hint="The last term of (5) is missing: seen from a turning body the wanted rates turn.",
)
def turning_frame_forgotten(R, R_d, omega, omega_d, omega_dot_d, integral, J, gains):
    return torque(R, R_d, omega, omega_d, omega_dot_d, integral, J, gains, cross=0.0)


@mutant(torque_command, hint="The last term of (5) has the wrong sign: it is subtracted, −ω × ….")
def turning_frame_added(R, R_d, omega, omega_d, omega_dot_d, integral, J, gains):
    return torque(R, R_d, omega, omega_d, omega_dot_d, integral, J, gains, cross=-1.0)


@mutant(
    torque_command,
    hint="The feedback is multiplied by the inertia: these gains are torques already.",
)
def gains_times_inertia(R, R_d, omega, omega_d, omega_dot_d, integral, J, gains):
    whole = torque(R, R_d, omega, omega_d, omega_dot_d, integral, J, gains)
    rest = torque(
        R, R_d, omega, omega_d, omega_dot_d, integral, J, TorqueGains(k_R=(0,) * 3, k_iR=(0,) * 3, k_omega=(0,) * 3)
    )  # fmt: skip
    return rest + J @ (whole - rest)


@mutant(
    torque_command,
    hint="What is fed forward is an acceleration: J makes a torque of it.",
)
def inertia_forgotten(R, R_d, omega, omega_d, omega_dot_d, integral, J, gains):
    gyro = np.cross(omega, J @ omega)
    rest = torque(R, R_d, omega, omega_d, omega_dot_d, integral, np.eye(3), gains)
    return rest + gyro


# scale_to_limits --------------------------------------------------------------------------------------


@sample(scale_to_limits)
def wishes(rng: np.random.Generator) -> list[Arguments]:
    made = []
    for n, size, more in (
        (4, 3.0, 0.0),
        (6, 3.0, 0.0),
        (4, 0.05, 0.0),
        (4, 0.0, 3.0),
        (6, 0.0, -2.0),
        (8, 3.0, 0.0),
    ):
        M, weight = draw.allocation(rng, n, balanced=True), some_mass(rng) * GRAVITY
        hold = np.array((weight, 0.0, 0.0, 0.0))
        wish = M @ (size * weight / n * rng.normal(size=n)) + more * hold
        made.append((
            hold + wish,
            hold,
            M,
            0.3 * weight / n,
            float(rng.uniform(1.5, 2.0)) * weight / n,
        ))
    return made


def shares(u, u_gravity, M, f_min, f_max):
    """Of each rotor, the largest share that its two limits allow; infinite where it does not move."""
    inverse = np.linalg.pinv(M)
    hover, pull = inverse @ u_gravity, inverse @ (u - u_gravity)
    with np.errstate(all="ignore"):
        return np.where(pull > 0, (f_max - hover) / pull, np.inf), np.where(
            pull < 0, (f_min - hover) / pull, np.inf
        )


def shrunk(u, u_gravity, share):
    return u_gravity + share * (u - u_gravity)


@mutant(
    scale_to_limits,
    hint="What could be done is stretched until a rotor is at its limit: the share is one at most.",
)
def stretched(u, u_gravity, allocation, f_min, f_max):
    share = np.min(shares(u, u_gravity, allocation, f_min, f_max))
    return shrunk(u, u_gravity, float(share) if np.isfinite(share) else 1.0)


@mutant(
    scale_to_limits,
    hint="Each rotor is cut by itself: that turns the direction of what is asked. Shrink it as a whole.",
)
def cut_one_by_one(u, u_gravity, allocation, f_min, f_max):
    return allocation @ np.clip(np.linalg.pinv(allocation) @ u, f_min, f_max)


@mutant(
    scale_to_limits,
    hint="The whole of u is shrunk, the weight too: keep what holds the aircraft up, and shrink the rest.",
)
def weight_shrunk_too(u, u_gravity, allocation, f_min, f_max):
    rotors = np.linalg.pinv(allocation) @ u
    return u * min(1.0, f_max / np.abs(rotors).max())


@mutant(scale_to_limits, hint="The lower limit is not kept: rotors can neither stop nor pull down.")
def upper_limit_only(u, u_gravity, allocation, f_min, f_max):
    return shrunk(u, u_gravity, min(1.0, shares(u, u_gravity, allocation, f_min, f_max)[0].min()))


@mutant(scale_to_limits, hint="The upper limit is not kept: rotors cannot push harder than f_max.")
def lower_limit_only(u, u_gravity, allocation, f_min, f_max):
    return shrunk(u, u_gravity, min(1.0, shares(u, u_gravity, allocation, f_min, f_max)[1].min()))


@mutant(
    scale_to_limits,
    hint="Only the yaw torque is shrunk: here everything beyond the hover is shrunk alike.",
)
def yaw_shrunk(u, u_gravity, allocation, f_min, f_max):
    share = min(1.0, float(np.min(shares(u, u_gravity, allocation, f_min, f_max))))
    return u * (1.0, 1.0, 1.0, share)


@mutant(
    scale_to_limits,
    hint="The thrust is left as it is and only the torques are shrunk: it is asked for beyond the hover, too.",
)
def thrust_kept(u, u_gravity, allocation, f_min, f_max):
    share = min(1.0, float(np.min(shares(u, u_gravity, allocation, f_min, f_max))))
    return np.array((u[0], *shrunk(u, u_gravity, share)[1:]))


@mutant(
    scale_to_limits,
    hint="Nothing is shrunk: some rotors are asked for what they cannot do.",
)
def as_asked(u, u_gravity, allocation, f_min, f_max):
    return u.copy()


@mutant(
    scale_to_limits,
    hint="The share is the mean over the rotors, or that of another one: the rotor that can do least decides.",
)
def mean_of_shares(u, u_gravity, allocation, f_min, f_max):
    each = np.minimum(*shares(u, u_gravity, allocation, f_min, f_max))
    return shrunk(u, u_gravity, float(np.minimum(each, 1.0).mean()))


@mutant(
    scale_to_limits,
    hint="The rotors are found with the transpose of the allocation: its inverse is asked for.",
)
def transposed_allocation(u, u_gravity, allocation, f_min, f_max):
    inverse = allocation.T / allocation.shape[1]
    hover, pull = inverse @ u_gravity, inverse @ (u - u_gravity)
    room = np.where(pull > 0, f_max - hover, f_min - hover)
    return shrunk(u, u_gravity, min(1.0, float(np.min(room / pull))))
