"""A slowly wandering error: Gauss-Markov, stepped exactly."""

from __future__ import annotations

from math import exp, sqrt

import numpy as np

from uavlab.types import Vec3


def drift_step(
    drift: Vec3, tau: float, walk: float | Vec3, dt: float, rng: np.random.Generator
) -> Vec3:
    """`drift` (3,) after `dt` [s] of ḃ = −b/τ + walk · white noise of unit density.

    Parameters
    ----------
    drift : Vec3
        In its own unit, (3,).
    tau : float
        Correlation time [s].
    walk : float or Vec3
        Density of the driving noise [unit/√s]. The standard deviation tends to walk √(τ/2).
    dt : float
        [s].
    rng : numpy.random.Generator
        Where chance comes from.
    """
    keep = exp(-dt / tau)
    return keep * drift + walk * sqrt(0.5 * tau * (1.0 - keep * keep)) * rng.standard_normal(3)
