"""Lab 06, the reference answers: prediction, quadratic programmes, and what flies on them. One file each."""

# canary-b7431f0aa95e62c8d01d7f3e

from uavlab.solutions.mpc_qp import (
    build_force_qp,
    build_soft_qp,
    discretize,
    initial_state,
    prediction_matrices,
    solve,
)

__all__ = [
    "build_force_qp",
    "build_soft_qp",
    "discretize",
    "initial_state",
    "prediction_matrices",
    "solve",
]
