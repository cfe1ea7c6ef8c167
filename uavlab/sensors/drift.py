"""A slowly wandering error: Gauss-Markov, stepped exactly."""

from __future__ import annotations

from math import exp, sqrt

import numpy as np

from uavlab.types import Array


def drift_step(
    drift: Array, tau: float, walk: float | Array, dt: float, rng: np.random.Generator
) -> Array:
    """`drift` (n,) after `dt` [s] of ḃ = −b/τ + walk · white noise of unit density.

    Parameters
    ----------
    drift : Array
        In its own unit, (n,).
    tau : float
        Correlation time [s].
    walk : float or Array
        Density of the driving noise [unit/√s]. The standard deviation tends to walk √(τ/2).
    dt : float
        [s].
    rng : numpy.random.Generator
        Where chance comes from.
    """
    keep = exp(-dt / tau)
    return keep * drift + walk * sqrt(0.5 * tau * (1.0 - keep * keep)) * rng.standard_normal(
        len(drift)
    )
