"""Three floats at a time: vectors as tuples, matrices as tuples of rows.

Compiled, a tuple lives in registers where a small array would be fetched from the heap; as plain Python it is several
times faster than numpy as well.
"""

from __future__ import annotations

from typing import TypeAlias

from uavlab import so3
from uavlab.plant.jit import kernel
from uavlab.types import Array

V: TypeAlias = tuple[float, float, float]
M: TypeAlias = tuple[V, V, V]

ZERO = (0.0, 0.0, 0.0)

exp = kernel(so3.exp_rows)  # rotation vector [rad] → rotation (Rodrigues)


@kernel
def plus(a: V, k: float, b: V) -> V:
    """The sum a + k b."""
    return (a[0] + k * b[0], a[1] + k * b[1], a[2] + k * b[2])


@kernel
def weighted(k: tuple[float, float, float, float], a: V, b: V, c: V, d: V) -> V:
    """The sum k₀ a + k₁ b + k₂ c + k₃ d."""
    return (
        k[0] * a[0] + k[1] * b[0] + k[2] * c[0] + k[3] * d[0],
        k[0] * a[1] + k[1] * b[1] + k[2] * c[1] + k[3] * d[1],
        k[0] * a[2] + k[1] * b[2] + k[2] * c[2] + k[3] * d[2],
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
def three(x: Array, first: int) -> V:
    """Three entries of an array, as a tuple."""
    return (x[first], x[first + 1], x[first + 2])


@kernel
def matrix(A: Array) -> M:
    """Array (3, 3) → tuple of rows."""
    return (
        (A[0, 0], A[0, 1], A[0, 2]),
        (A[1, 0], A[1, 1], A[1, 2]),
        (A[2, 0], A[2, 1], A[2, 2]),
    )


@kernel
def column(A: M, j: int) -> V:
    """Column j of A."""
    return (A[0][j], A[1][j], A[2][j])


@kernel
def orthonormal(R: M) -> M:
    """R (3 − Rᵀ R) / 2, one Newton step to the nearest rotation: takes away what rounding adds up."""
    E = times((column(R, 0), column(R, 1), column(R, 2)), R)
    half = (
        (1.5 - 0.5 * E[0][0], -0.5 * E[0][1], -0.5 * E[0][2]),
        (-0.5 * E[1][0], 1.5 - 0.5 * E[1][1], -0.5 * E[1][2]),
        (-0.5 * E[2][0], -0.5 * E[2][1], 1.5 - 0.5 * E[2][2]),
    )
    return times(R, half)
