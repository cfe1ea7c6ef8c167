"""What a filter is given: arrays that fit each other, and covariances that are some."""

from __future__ import annotations

import numpy as np

from uavlab.errors import BadInput
from uavlab.types import Array


def check_arrays(**given: tuple[Array, tuple[int, ...]]) -> None:
    """Refuse arrays that do not fit each other, or are not finite.

    Parameters
    ----------
    **given
        Name → the array, and the shape that it should have.

    Raises
    ------
    BadInput
        One has another shape, or holds NaN or infinity.
    """
    for name, (value, shape) in given.items():
        if np.shape(value) != shape:
            raise BadInput(f"{name} has shape {np.shape(value)}; {shape} fits the others.")
        if not np.isfinite(value).all():
            raise BadInput(f"{name} = {value} is not finite: reject it before it gets here.")


def check_covariance(name: str, M: Array, *, singular: bool = False) -> None:
    """Refuse a matrix that is no covariance.

    Parameters
    ----------
    name : str
        How to call it in the message.
    M : Array
        The matrix, shape (n, n), finite.
    singular : bool
        Whether something may be known exactly: eigenvalues of 0 are allowed.

    Raises
    ------
    BadInput
        It is not symmetric, or has an eigenvalue that is not above 0.
    """
    size = np.abs(M).max()
    if np.abs(M - M.T).max() > 1e-9 * size:
        raise BadInput(f"{name} = {M} is not symmetric: it is no covariance.")
    least = np.linalg.eigvalsh(M)[0]
    if least < -1e-12 * size if singular else least <= 0.0:
        raise BadInput(
            f"{name} = {M} has the eigenvalue {least:.3g}: those of a covariance are above 0."
        )
