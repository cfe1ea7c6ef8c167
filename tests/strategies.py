"""What hypothesis draws from: rotations, headings, tilts, rates, states. One place for every test."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from uavlab import so3
from uavlab.types import Mat3, State


def floats(low: float, high: float) -> st.SearchStrategy[float]:
    """Plain floats of a closed range; no subnormal numbers, no surprises but the ends."""
    return st.floats(low, high, allow_nan=False, allow_infinity=False, allow_subnormal=False)


def vectors(size: float = 10.0) -> st.SearchStrategy[np.ndarray]:
    """Vectors (3,) with entries of at most `size`."""
    return arrays(float, 3, elements=floats(-size, size))


headings = floats(-np.pi, np.pi)  # [rad], both ends too
tilts = floats(0.0, np.radians(80.0))  # [rad] from the vertical
rates = vectors(10.0)  # [rad/s], body
rotation_vectors = vectors(4.0)  # [rad], beyond half a turn


@st.composite
def rotations(draw: st.DrawFn) -> Mat3:
    """Any rotation."""
    return so3.exp(draw(rotation_vectors))


@st.composite
def tilted(draw: st.DrawFn, low: float = 0.0, high: float = np.radians(80.0)) -> Mat3:
    """Rotations whose thrust axis leans between `low` and `high` [rad]."""
    lean, azimuth = draw(floats(low, high)), draw(headings)
    axis = np.array((np.cos(azimuth), np.sin(azimuth), 0.0))
    return so3.exp(lean * axis) @ so3.about_z(draw(headings))


@st.composite
def forces(draw: st.DrawFn, low: float = 0.0, high: float = np.radians(80.0)) -> np.ndarray:
    """Desired forces [N], world, that lean between `low` and `high` [rad]."""
    return draw(floats(1.0, 100.0)) * draw(tilted(low, high))[:, 2]


@st.composite
def states(draw: st.DrawFn) -> State:
    """Rigid bodies on their way."""
    return State(draw(vectors(50.0)), draw(vectors(20.0)), draw(rotations()), draw(rates))


@st.composite
def inertias(draw: st.DrawFn) -> Mat3:
    """Inertia tensors [kg m²] of real bodies, not diagonal."""
    masses = np.array([draw(floats(0.01, 0.1)) for _ in range(3)])
    R = draw(rotations())
    return R @ np.diag(masses.sum() - masses) @ R.T
