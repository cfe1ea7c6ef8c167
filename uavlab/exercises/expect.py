"""What checks expect of rotations: written once for every lab."""

from __future__ import annotations

from typing import Any

import numpy as np

from uavlab import frames, so3
from uavlab.errors import CheckFailed
from uavlab.exercises.spec import Function, WrongForm, expect, expect_close, numbers
from uavlab.types import Array, Mat3, StateRate, Vec3


def expect_rotation(got: Any) -> Mat3:
    """`got` as a plain (3, 3) matrix; fail the check unless it is a rotation."""
    R = numbers(got, (3, 3))
    expect_close(R @ R.T, np.eye(3), "R Rᵀ must be the identity.")
    expect(np.linalg.det(R) > 0.0, "This is a reflection: its determinant is −1.")
    return R


def expect_heading(R: Mat3, heading: float) -> None:
    """Fail the check unless the x axis of `R`, seen from above, points to `heading` [rad]."""
    seen = R[:2, 0]
    want = np.hypot(*seen) * np.array((np.cos(heading), np.sin(heading)))
    expect_close(seen, want, "It has another heading.")


def expect_thrust_axis(R: Mat3, f_d: Vec3) -> None:
    """Fail the check unless the z axis of `R` points along the force `f_d`."""
    expect_close(R[:, 2], f_d / np.linalg.norm(f_d), "The z axis is not along the force.")


def expect_heading_rate(
    got: Any, R: Mat3, omega: Vec3, *, atol: float = 1e-6, message: str = ""
) -> None:
    """Fail the check unless the heading changes by `got` [rad/s] while `R` turns with `omega`.

    The derivative is a central difference, good to 1e-7. It is not given away, neither by the message nor by the
    traceback: it would pass as an answer.
    """
    rate = float(numbers(got, ()))
    if not _heading_changes_by(rate, R, omega, atol):
        raise CheckFailed(message or f"The heading does not change at {rate:.6g} rad/s.")


def _heading_changes_by(rate: float, R: Mat3, omega: Vec3, atol: float) -> bool:
    """Whether it does. A frame of its own: it is gone before anything is raised."""
    h = 1e-5
    ahead, behind = frames.heading(R @ so3.exp(h * omega)), frames.heading(R @ so3.exp(-h * omega))
    return bool(abs(rate - frames.wrap(ahead - behind) / (2.0 * h)) <= atol + 1e-9 * abs(rate))


def expect_state_rate(got: Any) -> StateRate:
    """`got` as plain arrays, field by field; fail the check unless it has the four of a StateRate."""
    if not isinstance(got, tuple | list) or len(got) != 4:
        asked = "A StateRate is asked for: r_dot, v_dot, R_dot, omega_dot."
        raise WrongForm(f"{asked} This is a {type(got).__name__}.", asked)
    shapes = ((3,), (3,), (3, 3), (3,))
    return StateRate(*(numbers(x, shape) for x, shape in zip(got, shapes, strict=True)))


def expect_unit(got: Any) -> Array:
    """`got` as a plain quaternion, shape (4,); fail the check unless its length is one."""
    q = numbers(got, (4,))
    expect_close(q @ q, 1.0, "The quaternion must have length one.")
    return q


def expect_record(got: Any, *shapes: tuple[int, ...]) -> tuple[Array, ...]:
    """`got` as plain arrays, field by field; fail the check unless it is a tuple with fields of these shapes."""
    if not isinstance(got, tuple | list) or len(got) != len(shapes):
        asked = f"A tuple of {len(shapes)} is asked for."
        raise WrongForm(f"{asked} This is a {type(got).__name__}.", asked)
    return tuple(numbers(x, shape) for x, shape in zip(got, shapes, strict=True))


def expect_refusal(f: Function, *args: Any) -> None:
    """Fail the check unless the answer refuses; one that hangs or dies has not."""
    try:
        f(*args)
    except (ValueError, ArithmeticError, np.linalg.LinAlgError):
        return
    expect(False, "It must raise ValueError.")


def of_shapes(got: Any, *shapes: tuple[int, ...]) -> tuple[Array, ...]:
    """`got` as plain arrays of these shapes; fail the check unless it is a tuple of just as many."""
    if not isinstance(got, tuple | list) or len(got) != len(shapes):
        asked = f"{len(shapes)} results are asked for."
        raise WrongForm(f"{asked} This is a {type(got).__name__}.", asked)
    return tuple(numbers(x, shape) for x, shape in zip(got, shapes, strict=True))


def expect_name(got: Any, want: str, message: str = "Another one is asked for.") -> None:
    """Fail the check unless `got` is that text."""
    if type(got) is not str:
        asked = "A name is asked for."
        raise WrongForm(f"{asked} This is a {type(got).__name__}.", asked)
    expect(got == want, message)
