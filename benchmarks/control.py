"""Controllers in closed loop: ours on SE(3) and with MPC beside RotorPy's, on the same circle of a T650.

The quick circle is MRS Fig. 9: 5 m, 7 m/s, 9.8 m/s². The MPC controller keeps to 2 m/s and 2 m/s² (MRS Sec. 5.7.2), so
it gets the same circle at 1.5 m/s, and so do the others. Its reference stands still over its horizon (MRS eq. 44): it
lags, by design, and the error at the end says so.
"""

from __future__ import annotations

from benchmarks import ours, peers
from benchmarks.rounds import Run, compare
from uavlab.gains import gains_for
from uavlab.plant import load_airframe

SLOW = 1.5  # [m/s], what the MPC controller can fly within its own limits


def contestants() -> dict[str, tuple[Run, float]]:
    """Name → (what flies, simulated seconds of one round: about half a CPU second)."""
    from uavlab.solutions.geometric import GeometricController
    from uavlab.solutions.mpc import MpcController

    mass = float(load_airframe("T650").m)
    geometric = GeometricController(mass, gains_for("T650", "soft"))
    return {
        "7 m/s: uavlab GeometricController": (ours.lean(1000.0, geometric), 20),
        "7 m/s: RotorPy SE3Control, 1 kHz": (peers.rotorpy_lean(1000.0), 0.5),
        "7 m/s: RotorPy SE3Control, 100 Hz": (peers.rotorpy_lean(100.0), 2),
        "1.5 m/s: uavlab GeometricController": (ours.lean(1000.0, geometric, SLOW), 20),
        "1.5 m/s: uavlab MpcController": (ours.lean(1000.0, MpcController(mass), SLOW), 10),
        "1.5 m/s: RotorPy SE3Control, 1 kHz": (peers.rotorpy_lean(1000.0, speed=SLOW), 0.5),
        "1.5 m/s: RotorPy SE3Control, 100 Hz": (peers.rotorpy_lean(100.0, speed=SLOW), 2),
    }


def report(rounds: int) -> None:
    """Fly all of them in turn, and print medians and ratios."""
    print("\ncontrollers at 100 Hz on the true state, T650 on a circle of 5 m; plant at 1 kHz")
    compare(contestants(), [(0, 1), (0, 2), (3, 5), (4, 5), (4, 6), (3, 4)], rounds)
