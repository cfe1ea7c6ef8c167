"""Hidden checks of lab 02, continued: answers that are formulas, not quotients of differences."""

from __future__ import annotations

import numpy as np

from grader.material import hidden
from uavlab.exercises import draw
from uavlab.exercises.heading import (
    heading_rate,
    parasitic_yaw_rate,
    yaw_rate_from_heading_rate,
)
from uavlab.exercises.spec import Function, expect_close

CANARY = "canary-7be2c9904f1ad35c86d0e1f2"

EXACT = 1e-12  # what a formula reaches and a quotient of differences does not
MOST = 12.0  # heavy: differences of the public helper or of frames.heading pass every other check


@hidden(heading_rate, weight=MOST)
def exact_to_the_last_digits(f: Function, rng: np.random.Generator) -> None:
    """The heading rate must be exact, as (15) is: a quotient of small differences is not."""
    for _ in range(4):
        R, omega = draw.tilted(rng, 0.2, 1.0), draw.vector(rng, 2.0)
        want = (omega[1] * R[2, 1] + omega[2] * R[2, 2]) / (1.0 - R[2, 0] ** 2)
        expect_close(f(R, omega), want, atol=EXACT, rtol=EXACT)


@hidden(yaw_rate_from_heading_rate, weight=MOST)
def exact_yaw_rate(f: Function, rng: np.random.Generator) -> None:
    """The yaw rate must be exact, as (27) to (31) are: a quotient of small differences is not."""
    for _ in range(4):
        R, rate = draw.tilted(rng, 0.2, 1.0), rng.uniform(-2.0, 2.0)
        expect_close(f(R, rate), rate * (1.0 - R[2, 0] ** 2) / R[2, 2], atol=EXACT, rtol=EXACT)


@hidden(parasitic_yaw_rate, weight=MOST)
def exact_compensation(f: Function, rng: np.random.Generator) -> None:
    """The compensation must be exact: a quotient of small differences is not."""
    for _ in range(4):
        R, omega = draw.tilted(rng, 0.2, 1.0), draw.vector(rng, 2.0)
        expect_close(f(R, omega), -omega[1] * R[2, 1] / R[2, 2], atol=EXACT, rtol=EXACT)
