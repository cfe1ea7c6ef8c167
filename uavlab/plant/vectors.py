"""Three floats at a time: vectors as tuples, matrices as tuples of rows.

Compiled, a tuple lives in registers where a small array would be fetched from the heap; as plain Python it is several
times faster than numpy as well.
"""

from __future__ import annotations

from typing import TypeAlias

from uavlab import so3
from uavlab.plant.jit import kernel

V: TypeAlias = tuple[float, float, float]
M: TypeAlias = tuple[V, V, V]

exp = kernel(so3.exp_rows)  # rotation vector [rad] → rotation (Rodrigues)


@kernel
def plus(a: V, k: float, b: V) -> V:
    """a + k b."""
    return (a[0] + k * b[0], a[1] + k * b[1], a[2] + k * b[2])


@kernel
def mean4(a: V, b: V, c: V, d: V, k: V, last: float) -> V:
    """The sum of a, b, c, d, weighted with k[0], k[1], k[2] and `last`."""
    return (
        k[0] * a[0] + k[1] * b[0] + k[2] * c[0] + last * d[0],
        k[0] * a[1] + k[1] * b[1] + k[2] * c[1] + last * d[1],
        k[0] * a[2] + k[1] * b[2] + k[2] * c[2] + last * d[2],
    )


@kernel
def dot(a: V, b: V) -> float:
    """Inner product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def cross(a: V, b: V) -> V:
    """Vector product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@kernel
def apply(A: M, x: V) -> V:
    """A x."""
    return (dot(A[0], x), dot(A[1], x), dot(A[2], x))


@kernel
def apply_transposed(A: M, x: V) -> V:
    """Aᵀ x."""
    return (
        A[0][0] * x[0] + A[1][0] * x[1] + A[2][0] * x[2],
        A[0][1] * x[0] + A[1][1] * x[1] + A[2][1] * x[2],
        A[0][2] * x[0] + A[1][2] * x[1] + A[2][2] * x[2],
    )


@kernel
def times(A: M, B: M) -> M:
    """A B."""
    return (apply_transposed(B, A[0]), apply_transposed(B, A[1]), apply_transposed(B, A[2]))


@kernel
def vector(x):  # noqa: ANN001, ANN201  # type: ignore[no-untyped-def]
    """Array (3,) → tuple."""
    return (x[0], x[1], x[2])


@kernel
def matrix(A):  # noqa: ANN001, ANN201  # type: ignore[no-untyped-def]
    """Array (3, 3) → tuple of rows."""
    return (
        (A[0, 0], A[0, 1], A[0, 2]),
        (A[1, 0], A[1, 1], A[1, 2]),
        (A[2, 0], A[2, 1], A[2, 2]),
    )


@kernel
def orthonormal(R: M) -> M:
    """R (3 − Rᵀ R) / 2: one Newton step to the nearest rotation; takes away what rounding adds up."""
    E = times((tuple3(R, 0), tuple3(R, 1), tuple3(R, 2)), R)
    half = (
        (1.5 - 0.5 * E[0][0], -0.5 * E[0][1], -0.5 * E[0][2]),
        (-0.5 * E[1][0], 1.5 - 0.5 * E[1][1], -0.5 * E[1][2]),
        (-0.5 * E[2][0], -0.5 * E[2][1], 1.5 - 0.5 * E[2][2]),
    )
    return times(R, half)


@kernel
def tuple3(A: M, j: int) -> V:
    """Column j of A."""
    return (A[0][j], A[1][j], A[2][j])
