"""Short words for the tests of the world."""

import numpy as np

from uavlab import so3
from uavlab.plant import Airframe
from uavlab.types import Command, State


def command(f_d: float, omega_d: object = (0.0, 0.0, 0.0)) -> Command:
    """A command that tells the estimator nothing."""
    return Command(f_d, np.array(omega_d, dtype=float), np.zeros(3))


def state(
    r: object = (0, 0, 100),
    v: object = (0, 0, 0),
    w: object = (0, 0, 0),
    omega: object = (0, 0, 0),
) -> State:
    """A state; `w` is the rotation vector of R."""
    r, v, w, omega = (np.array(x, dtype=float) for x in (r, v, w, omega))
    return State(r, v, so3.exp(w), omega)


def without_rotors(airframe: Airframe) -> Airframe:
    """The same body with rotors that neither push nor turn nor drag."""
    return airframe._replace(allocation=np.zeros((4, airframe.n)), drag_rotor=0.0)
