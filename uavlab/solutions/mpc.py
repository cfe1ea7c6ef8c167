"""Lab 06, the reference answers: prediction, quadratic programmes, and what flies on them. A file for each."""

# canary-b7431f0aa95e62c8d01d7f3e

from uavlab.solutions.mpc_controller import MpcController
from uavlab.solutions.mpc_qp import (
    build_force_qp,
    build_soft_qp,
    discretize,
    initial_state,
    prediction_matrices,
    solve,
)
from uavlab.solutions.mpc_tracker import MpcTracker

__all__ = [
    "MpcController",
    "MpcTracker",
    "build_force_qp",
    "build_soft_qp",
    "discretize",
    "initial_state",
    "prediction_matrices",
    "solve",
]
