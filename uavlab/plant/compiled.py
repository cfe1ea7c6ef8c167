"""The plant that flies fast: the compiled world behind two functions."""

from __future__ import annotations

from math import inf, sqrt
from typing import final

import numpy as np

from uavlab.errors import BadInput
from uavlab.plant.airframe import Airframe
from uavlab.plant.reallocation import Reallocation, reallocated
from uavlab.plant.world import SPEED, World, first_world, unpack
from uavlab.types import Array, Command, State, Vec3

RATE = 1000.0  # [Hz] of rate loop and physics, if nothing else is said
STILL = np.zeros(3)
STILL.setflags(write=False)


@final
class CompiledPlant:
    """An aircraft with its embedded autopilot, in moving air above flat ground at z = 0.

    Modelled: rigid body with gyroscopic torque, motors with first-order lag and limits, thrust ∝ speed², drag of body
    and rotors, take-off, standing and touch-down. Not modelled: ground effect, the gyroscopic torque and the spin-up
    torque of the rotors, friction (on the ground the aircraft stands still).
    """

    def __init__(self, airframe: Airframe) -> None:
        from uavlab.plant import constants, kernel  # numba starts here, not with `import uavlab`

        self.airframe = airframe
        self._numbers, self._allocation, self._mixer = constants.pack(airframe)
        self._without: dict[tuple[int, ...], Reallocation] = {}
        self._advance = kernel.advance

    def init(self, state: State) -> World:
        """The world at t = 0: rotors at hover speed in the air, at rest on the ground (z = 0).

        Raises
        ------
        BadInput
            A wrong shape, a number that is not finite, no rotation, below the ground, or moving on it.
        """
        return first_world(state, self.airframe)

    def advance(
        self,
        world: World,
        command: Command,
        wind: Vec3 = STILL,
        dt: float = 0.01,
        n: int | None = None,
        shares: Array | None = None,
        dead: tuple[int, ...] = (),
    ) -> World:
        """The world `dt` later, under a constant command in air that moves with constant velocity.

        Parameters
        ----------
        world : World
            From `init` or `advance`.
        command : Command
            Collective thrust `f_d` [N] and body rates `omega_d` [rad/s]; held for `dt`.
        wind : Vec3
            Velocity of the air [m/s], world, (3,).
        dt : float
            Control tick [s].
        n : int, optional
            Inner steps in it; 1 kHz if there is no number.
        shares : Array, optional
            Of the thrust that is asked of it, what each motor still makes, (n,); all of it if nothing is said.
        dead : tuple of int
            Rotors that the autopilot knows to be dead, and does without (`uavlab.plant.reallocation`).

        Raises
        ------
        BadInput
            `dt` or `n` is not positive, a vector is not (3,), `world` has another number of rotors, a share is
            negative, or there is no such rotor.
        """
        asked, n = inputs(self.airframe, world, command, wind, dt, n, shares)
        mixer = self._mixer
        if dead:
            mixer, still = self._reallocated(dead)
            asked[[7 + i for i in still]] = 0.0
        out = np.empty(SPEED + self.airframe.n)
        contact, impact = self._advance(
            world.r, world.v, world.R, world.omega, world.speed, world.contact,
            asked, self._numbers, self._allocation, mixer, float(dt), n, out,
        )  # fmt: skip
        return unpack(world.t + dt, out, contact, impact)

    def laden(self, load: float) -> CompiledPlant:
        """The same aircraft with `load` [kg] more at its centre of mass."""
        return CompiledPlant(laden(self.airframe, load))

    def _reallocated(self, dead: tuple[int, ...]) -> Reallocation:
        """What the autopilot does without the rotors in `dead`; made once."""
        if dead not in self._without:
            known_rotors(self.airframe, dead)
            self._without[dead] = reallocated(self.airframe, self._allocation, dead)
        return self._without[dead]


def laden(airframe: Airframe, load: float) -> Airframe:
    """The airframe with `load` [kg] more at its centre of mass; its rotors drag as before.

    Raises
    ------
    BadInput
        Nothing is left of its mass.
    """
    m = airframe.m + load
    if not 0.0 < m < inf:
        raise BadInput(
            f"laden: {airframe.name} weighs {airframe.m:g} kg and cannot carry {load} kg."
        )
    # The drag of the rotors is told per root of mass, and must not grow with it.
    return airframe._replace(m=m, drag_rotor=airframe.drag_rotor * sqrt(airframe.m / m))


def known_rotors(airframe: Airframe, dead: tuple[int, ...]) -> None:
    """Refuse rotors that are not there.

    Raises
    ------
    BadInput
        Names the rotor.
    """
    for i in dead:
        if not 0 <= i < airframe.n:
            raise BadInput(
                f"advance: rotor {i} is dead, but {airframe.name} has rotors 0 to {airframe.n - 1}."
            )


def inputs(
    airframe: Airframe,
    world: World,
    command: Command,
    wind: Vec3,
    dt: float,
    n: int | None,
    shares: Array | None = None,
) -> tuple[Array, int]:
    """What is asked in one array (7 + rotors,), and the number of inner steps; checked, for kernels do not look.

    Thrust, rates, wind, and what share of its thrust each motor makes.
    """
    if not 0.0 < dt < inf or (n is not None and not 1 <= n < inf):
        raise BadInput(f"advance: dt is {dt} s and n is {n}; dt must be > 0 and n ≥ 1.")
    n = max(round(dt * RATE), 1) if n is None else int(n)
    if len(world.speed) != airframe.n:
        raise BadInput(
            f"advance: the world has {len(world.speed)} rotors, {airframe.name} has {airframe.n}. "
            "Make the world with this plant's init."
        )
    asked = np.empty(7 + airframe.n)
    asked[7:] = 1.0 if shares is None else _checked(airframe, shares)
    try:
        asked[0], asked[1:4], asked[4:7] = command.f_d, command.omega_d, wind
        if len(command.omega_d) == 3 and len(wind) == 3:  # numpy would stretch a vector of one
            return asked, n
    except (TypeError, ValueError):
        pass
    raise BadInput(
        f"advance: f_d has shape {np.shape(command.f_d)}, omega_d {np.shape(command.omega_d)} and "
        f"wind {np.shape(wind)}; numbers of shape (), (3,) and (3,) are needed."
    )


def _checked(airframe: Airframe, shares: Array) -> Array:
    x = np.asarray(shares, dtype=float)
    if x.shape != (airframe.n,) or not (np.isfinite(x).all() and (x >= 0.0).all()):
        raise BadInput(
            f"advance: shares are {x.tolist()}; {airframe.name} needs {airframe.n} numbers ≥ 0, one for each rotor."
        )
    return x
