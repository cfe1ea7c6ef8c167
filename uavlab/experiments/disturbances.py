"""000-8: half a kilogram more than was told, and a steady wind: the controller finds both (MRS Sec. 5.5, eq. 35–37)."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from uavlab.experiments.control_flights import Altered, flown, law, memories, printed_mass
from uavlab.experiments.spec import Band, Experiment, Line, Outcome, Panel, Row
from uavlab.flight.log import Log
from uavlab.flight.metrics import position_error
from uavlab.flight.scenario import Scenario, standing
from uavlab.frames import heading
from uavlab.gains import GROUPS, GeometricGains
from uavlab.parts.missions import Waypoints
from uavlab.plant import CompiledPlant, Wind, load_airframe
from uavlab.plant.world import total_force
from uavlab.so3 import about_z
from uavlab.types import GRAVITY, Array, State, Vec3

NAME = "T650"
TOLD, MORE = 3.5, 0.5  # [kg] the mass of the airframe, and what hangs on it
BLOWS = np.array((3.0, 0.0, 0.0))  # [m/s]
HEIGHT = 5.0  # [m]
YAW, TURNS, END = 60.0, 90.0, 160.0  # [s]: a quarter turn, eight more, the end
GAINS = GROUPS["T650-sim-2020"]["soft"]
SLOW = GROUPS["now"]["soft"]  # what the software flies today


def scenario(end: float = END, wind: Vec3 = BLOWS) -> Scenario:
    """Hover in a steady wind; after a while, turn on the spot."""
    there = (0.0, 0.0, HEIGHT)
    stops = [(0.0, there, 0.0), (YAW, there, np.pi / 2)]
    stops += [(TURNS + 5.0 * k, there, (k + 2) * np.pi / 2) for k in range(8)]
    return Scenario(
        "hover", "", NAME, Waypoints(tuple(stops)), standing(there), end, {}, wind=Wind(wind)
    )


def loaded(mass: float = TOLD + MORE) -> CompiledPlant:
    """The aircraft with another mass than its airframe says."""
    return CompiledPlant(load_airframe(NAME)._replace(m=mass))


class Learned(NamedTuple):
    """A flight and what its controller learned, all in the world."""

    log: Log
    mass: Array  # (N,) [kg]
    d_w: Array  # (N, 3) [N]
    d_b: Array  # (N, 3) [N], turned into the world
    push: Array  # (3,) [N] what the air does in truth, before the first turn

    @property
    def d(self) -> Array:
        """Both disturbances together (N, 3) [N]."""
        return self.d_w + self.d_b

    def at(self, t: float) -> int:
        """The tick at `t` [s], or the last one."""
        return min(int(np.searchsorted(self.log.t, t)), len(self.log.t) - 1)


def learned(gains: GeometricGains, end: float = END) -> Learned:
    """One flight with these gains."""
    controller = law(TOLD, gains)
    log = flown(scenario(end), controller, plant=loaded())
    kept = memories(log, controller)
    turned = [about_z(heading(R)) @ x.d_b for R, x in zip(log.R_e, kept, strict=True)]
    k = min(int(np.searchsorted(log.t, YAW - 1.0)), len(log.t) - 1)
    return Learned(
        log, np.array([x.m_e for x in kept]), np.array([x.d_w for x in kept]), np.array(turned),
        of_the_air(log, k),
    )  # fmt: skip


def of_the_air(log: Log, k: int) -> Vec3:
    """Force of the air [N], world, (3,), at tick k."""
    airframe = load_airframe(NAME)._replace(m=TOLD + MORE)
    f = float(log.rotors[k].sum())
    state = State(log.r[k], log.v[k], log.R[k], log.omega[k])
    weight = np.array((0.0, 0.0, airframe.m * GRAVITY))
    return total_force(airframe, state, f, log.wind[k]) - f * log.R[k][:, 2] + weight


def time_constants(gains: GeometricGains) -> tuple[float, float]:
    """How fast mass and disturbance are found [s]: m k_p / (k_m g) and m k_p / (k_iw + k_ib)."""
    m = TOLD + MORE
    return m * gains.k_p[2] / (gains.k_m * GRAVITY), m * gains.k_p[0] / (gains.k_iw + gains.k_ib)


def as_printed(
    told: float, true: float, wind: Vec3, gains: GeometricGains, seconds: float = YAW
) -> tuple[Log, Array]:
    """A flight with (37) as printed, and the mass (N,) [kg] that it believes."""
    controller: Any = Altered(law(told, gains), printed_mass)
    log = flown(scenario(seconds, wind), controller, plant=loaded(true))
    return log, np.array([x.m_e for x in memories(log, controller)])


def run(_seeds: int) -> Outcome:
    """000-8; nothing is left to chance."""
    one = learned(GAINS)
    slow = learned(SLOW, YAW)
    tau_m, tau_d = time_constants(GAINS)
    a, b, last = one.at(5.0 * tau_m), one.at(5.0 * tau_d), len(one.log.t) - 1
    true, push = TOLD + MORE, float(np.linalg.norm(one.push[:2]))
    off = float(np.linalg.norm((one.d[b] - one.push)[:2])) / push
    split = float(np.linalg.norm((one.d_w - one.d_b)[b])) / push
    world = (one.d_w @ one.push / push**2)[[b, one.at(TURNS - 1.0), last]]
    e = position_error(one.log)
    crash, _ = printed = as_printed(TOLD, true, BLOWS, GAINS)
    light, _ = as_printed(3.0, TOLD, np.zeros(3), SLOW)
    rows = (
        Row(f"error of the mass after 5 τ = {5 * tau_m:.0f} s, share", "—", abs(one.mass[a] / true - 1.0),
            Band(0.0, 0.03)),
        Row(f"error of the disturbance after 5 τ = {5 * tau_d:.0f} s, share", "—", off, Band(0.0, 0.1)),
        Row("difference of both halves before the first turn, share", "equally split", split, Band(0.0, 0.1)),
        Row("part of the wind in d_w: before the first turn", "1/2", float(world[0])),
        Row("part of the wind in d_w: after a quarter turn", "—", float(world[1])),
        Row("part of the wind in d_w: after eight more", "1", float(world[2])),
        Row("force of the wind [N]", "—", push),
        Row("position error as the wind and the load begin, largest [m]", "—", float(e[: one.at(YAW)].max())),
        Row("position error on the quarter turn, largest [m]", "—", float(e[one.at(YAW) : one.at(TURNS)].max())),
        Row("mass after 5 τ, gains of today [kg]", "—", float(slow.mass[slow.at(5 * time_constants(SLOW)[0])])),
        Row(f"disturbance found by {YAW:g} s, gains of today, share", "—",
            float(np.linalg.norm(slow.d[-1][:2])) / push, None, None,
            f"its time constant is {time_constants(SLOW)[1]:.0f} s"),
        Row("(37) as printed: the flight is over after [s]", "—", float(crash.t[-1])),
        Row("the same, told 3.0 of 3.5 kg, calm, gains of today [s]", "—", float(light.t[-1])),
    )  # fmt: skip
    remarks = (
        f"{NAME}, told {TOLD} kg, weighs {true} kg; gains of the group soft of its simulation of 2020. The aircraft "
        "knows its state.",
        "The mass that is found is what the vertical thrust carries: the air lifts a little "
        f"({one.push[2]:.2f} N, drag of rotors that are tilted), so it stays {1e3 * (true - one.mass[b]):.0f} g low.",
        "Wind does not turn with the aircraft, and what is learned of it in d_b does: it is wrong after every turn, "
        "and each turn moves more of it into d_w.",
        f"(37) as printed: {crash.reason}. Who is heavy sags, the mass falls, and he sags more. Told 3.0 of 3.5 kg: "
        f"{light.reason}.",
        "(35) turns the disturbance of the heading frame into the world, and (37) turns it again: we learn it in the "
        "heading frame and turn it once, where it is used.",
    )  # fmt: skip
    return Outcome(rows, _panels(one, slow, printed), remarks)


def _panels(one: Learned, slow: Learned, printed: tuple[Log, Array]) -> tuple[Panel, ...]:
    n = slice(None, None, 10)
    t, marks = one.log.t[n], ((YAW, "quarter turn"), (TURNS, "eight more"))
    true = np.array((TOLD + MORE, TOLD + MORE))
    crash, mass = printed
    soon = one.log.t < 30.0
    return (
        Panel("Mass", "time [s]", "mass [kg]", (
            Line("true", one.log.t[[0, one.at(YAW)]], true, "truth"),
            Line("soft, 2020", one.log.t[: one.at(YAW) : 10], one.mass[: one.at(YAW) : 10]),
            Line("soft, today", slow.log.t[n], slow.mass[n]),
        )),
        Panel("Disturbance along x", "time [s]", "force [N]", (
            Line("of the air", t, np.full(len(t), one.push[0]), "truth"),
            Line("d_w", t, one.d_w[n, 0]), Line("d_b, in the world", t, one.d_b[n, 0]),
            Line("both", t, one.d[n, 0], "dashed"),
        ), marks),
        Panel("Disturbance along y", "time [s]", "force [N]", (
            Line("of the air", t, np.full(len(t), one.push[1]), "truth"),
            Line("d_w", t, one.d_w[n, 1]), Line("d_b, in the world", t, one.d_b[n, 1]),
            Line("both", t, one.d[n, 1], "dashed"),
        ), marks),
        Panel("Position error", "time [s]", "error [m]", (
            Line("soft, 2020", t, position_error(one.log)[n]),
            Line("soft, today", slow.log.t[n], position_error(slow.log)[n]),
        ), marks),
        Panel("(37) as printed: height", "time [s]", "height [m]", (
            Line("as printed", crash.t, crash.r[:, 2]),
            Line("corrected", one.log.t[soon], one.log.r[soon, 2]),
        )),
        Panel("(37) as printed: mass", "time [s]", "mass [kg]", (
            Line("true", np.array((0.0, 30.0)), true, "truth"),
            Line("as printed", crash.t, mass),
            Line("corrected", one.log.t[soon], one.mass[soon]),
        )),
    )  # fmt: skip


EXPERIMENTS = (
    Experiment("000-8", "A load and a wind that nobody told of", "MRS Sec. 5.5", run, seeds=1),
)
