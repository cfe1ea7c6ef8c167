"""The plant in the functions of lab 01: the same world as the compiled one, some five hundred times slower."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass, field, replace
from typing import Any, ClassVar, final

import numpy as np

from uavlab.errors import BadInput
from uavlab.interfaces import asks
from uavlab.plant.airframe import Airframe
from uavlab.plant.compiled import STILL, CompiledPlant, inputs, known_rotors, laden
from uavlab.plant.reallocation import reallocated
from uavlab.plant.world import World, first_world, total_force
from uavlab.types import Array, Command, Mat3, State, StateRate, Vec3


@final
@dataclass(frozen=True)
class ReadablePlant:
    """An aircraft flown with the functions that lab 01 asks for.

    It holds what the functions do not: the rate loop, what gives way at saturation, drag, gravity, the ground, and the
    order of things in one step. `tests/plant/test_twins.py` holds it equal to `CompiledPlant`.
    """

    airframe: Airframe
    _: KW_ONLY
    rigid_body_rate: Callable[..., StateRate] = asks("dynamics")
    step_on_so3: Callable[[Mat3, Vec3, float], Mat3] = asks("dynamics")
    allocation_matrix: Callable[[Array, float, float, Array], Array] = asks("dynamics")
    rotor_thrusts: Callable[[float, Vec3, Array], Array] = asks("dynamics")
    motor_step: Callable[[Array, Array, float, float], Array] = asks("dynamics")
    allocation: Array = field(init=False, repr=False)  # (4, n), from allocation_matrix
    mixer: Array = field(init=False, repr=False)  # (n, 4), from rotor_thrusts
    stand_in: ClassVar[type] = CompiledPlant

    def __post_init__(self) -> None:
        """Ask for the two matrices once: rotor thrusts are linear in thrust and torque."""
        a = self.airframe
        allocation = self.allocation_matrix(a.angles, a.arm, a.torque_ratio, a.spins)
        allocation = _shaped("allocation_matrix", allocation, (4, a.n))
        columns = [
            _shaped("rotor_thrusts", self.rotor_thrusts(u[0], u[1:], allocation), (a.n,))
            for u in np.eye(4)
        ]
        object.__setattr__(self, "allocation", allocation)
        object.__setattr__(self, "mixer", np.stack(columns, axis=1))

    def init(self, state: State) -> World:
        """The world at t = 0; as `CompiledPlant.init`."""
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
        """The world `dt` [s] later, in `n` inner steps; as `CompiledPlant.advance`."""
        asked, n = inputs(self.airframe, world, command, wind, dt, n, shares)
        f_d, omega_d, wind, left = asked[0], asked[1:4], asked[4:7], asked[7:]
        mixer = self.mixer
        if dead:
            known_rotors(self.airframe, dead)
            mixer, still = reallocated(self.airframe, self.allocation, dead)
            left[list(still)] = 0.0
        state, speed, contact, impact = world.state, world.speed, world.contact, 0.0
        a, h = self.airframe, dt / n
        for _ in range(n):
            thrust = left * self.mix(f_d, self.rate_loop(state.omega, omega_d), mixer)
            target = np.sqrt(thrust / a.thrust_coefficient)
            speed = self.motor_step(speed, target, a.motor_tau, h / 2)
            f, *tau = self.allocation @ (a.thrust_coefficient * speed**2)
            if contact and total_force(a, state, f, wind)[2] > 0.0:
                contact = False  # thrust carries it: take-off
            if not contact:
                state = self.step_body(state, f, np.array(tau), wind, h)
                if state.r[2] < 0.0:
                    impact = max(impact, float(np.linalg.norm(state.v)))
                    state, contact = _stand(state), True
            speed = self.motor_step(speed, target, a.motor_tau, h / 2)
        f = float(self.allocation[0] @ (a.thrust_coefficient * speed**2))
        rest = np.zeros(3)
        accel = rest if contact else self.rate(state, f, rest, wind).v_dot
        return World(world.t + dt, *state, speed, accel, contact, impact)

    def rate_loop(self, omega: Vec3, omega_d: Vec3) -> Vec3:
        """Torque [N m], body: proportional on the rate error, with the gyroscopic torque fed forward (Spica eq. 5)."""
        a = self.airframe
        return a.J @ (a.rate_gain * (omega_d - omega)) + np.cross(omega, a.J @ omega)

    def laden(self, load: float) -> ReadablePlant:
        """The same aircraft with `load` [kg] more at its centre of mass."""
        return replace(self, airframe=laden(self.airframe, load))

    def mix(self, f: float, tau: Vec3, mixer: Array | None = None) -> Array:
        """Rotor thrusts (n,) [N] for thrust f and torque τ; at saturation yaw gives way, then f, then tilt.

        By its own mixer, or by another one (n, 4).
        """
        mixer = self.mixer if mixer is None else mixer
        low, high = self.airframe.thrust_min, self.airframe.thrust_max
        p, q, y = mixer[:, 0], mixer[:, 1:3] @ tau[:2], mixer[:, 3] * tau[2]
        asked = p * f + q + y
        if (asked >= low).all() and (asked <= high).all():
            return asked
        up = p > 0.0  # always so, unless rotor_thrusts is wrong
        lowest, highest, tilt = low / p[up], high / p[up], q[up] / p[up]
        # Rotor j may stand above rotor i by no more than the limits are apart.
        gap = tilt[None, :] - tilt[:, None]
        room = np.maximum(highest[None, :] - lowest[:, None], 0.0)
        share = min(1.0, np.min(room[gap > room] / gap[gap > room], initial=1.0))
        f = max(f, np.max(lowest - share * tilt, initial=-np.inf))
        f = min(f, np.min(highest - share * tilt, initial=np.inf))
        base = p * f + share * q
        over, under = (y > 0.0) & (y > high - base), (y < 0.0) & (y < low - base)
        share = min(
            np.min(np.maximum(high - base[over], 0.0) / y[over], initial=1.0),
            np.min(np.minimum(low - base[under], 0.0) / y[under], initial=1.0),
        )
        return np.clip(base + share * y, low, high)

    def rate(self, state: State, f: float, tau: Vec3, wind: Vec3) -> StateRate:
        """Time derivative of the state under thrust f [N] and torque τ [N m]."""
        a = self.airframe
        return self.rigid_body_rate(state, total_force(a, state, f, wind), tau, m=a.m, J=a.J)

    def step_body(self, x: State, f: float, tau: Vec3, wind: Vec3, dt: float) -> State:
        """One step of `dt` [s]: Runge-Kutta 4 for r, v and ω, its commutator-free companion for R.

        Celledoni, Marthinsen, Owren 2003: R is only ever turned by constant rates, so it stays on SO(3).
        """
        h, turn = dt / 2, self.step_on_so3
        k1 = self.rate(x, f, tau, wind)
        x2 = _moved(x, k1, h, turn(x.R, x.omega, h))
        k2 = self.rate(x2, f, tau, wind)
        x3 = _moved(x, k2, h, turn(x.R, x2.omega, h))
        k3 = self.rate(x3, f, tau, wind)
        x4 = _moved(x, k3, dt, turn(x2.R, x3.omega - x.omega / 2, dt))
        k4 = self.rate(x4, f, tau, wind)

        both = 2 * x2.omega + 2 * x3.omega
        early = (3 * x.omega + both - x4.omega) / 12
        late = (-x.omega + both + 3 * x4.omega) / 12
        mean = StateRate(*((a + 2 * b + 2 * c + d) / 6 for a, b, c, d in zip(k1, k2, k3, k4)))  # noqa: B905
        return _moved(x, mean, dt, turn(turn(x.R, early, dt), late, dt))


def _moved(x: State, rate: StateRate, dt: float, R: Mat3) -> State:
    """`x` after `dt` [s] at this rate, with the rotation R."""
    return State(x.r + dt * rate.r_dot, x.v + dt * rate.v_dot, R, x.omega + dt * rate.omega_dot)


def _stand(x: State) -> State:
    """At rest on the ground, where `x` has come down."""
    return State(np.array((x.r[0], x.r[1], 0.0)), np.zeros(3), x.R, np.zeros(3))


def _shaped(name: str, value: Any, shape: tuple[int, ...]) -> Array:
    out = np.asarray(value, dtype=float)
    if out.shape != shape:
        raise BadInput(f"{name} returned an array of shape {out.shape}; {shape} is needed.")
    return out
