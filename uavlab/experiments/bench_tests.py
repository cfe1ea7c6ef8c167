"""003-4, 003-5 and 000-33: what is measured before anything flies, of motors, of sensors, and of the thrust curve."""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np

from uavlab import so3
from uavlab.errors import BadInput
from uavlab.experiments.answers import answer
from uavlab.experiments.spec import Band, Experiment, Line, Outcome, Panel, Row
from uavlab.plant import Airframe, load_airframe
from uavlab.types import GRAVITY, Array, Mat3

STEM = "identification"

# 003-4: the motor bench -------------------------------------------------------------------------------

RATE = 200.0  # [Hz] of load cell and tachometer
STEPS, FITTED = np.arange(30.0, 191.0, 10.0), (30.0, 180.0)  # commands, and those that Spica fits
HELD, REST, SETTLED = 5.0, 10.0, 1.0  # [s]
FORCE_NOISE, TORQUE_NOISE = 0.1, 2e-3  # [N] and [N m], one sample, mostly vibration
SPEED_NOISE = 3.0  # [rad/s]
PRINTED = {"tau": 0.047, "c": 0.0174, "least": 0.3131, "most": 6.03}


class BenchRecord(NamedTuple):
    """What a motor on a load cell was told and did."""

    t: Array  # (n,) [s]
    command: Array  # (n,)
    speed: Array  # (n,) [rad/s] as measured
    force: Array  # (n,) [N] as measured
    torque: Array  # (n,) [N m] as measured


class Motor(NamedTuple):
    """What was found of a motor."""

    tau: float  # [s]
    c: float  # [m]
    rms: float  # of the relative error of the force, over the fitted commands
    least: float  # [N] at command 30
    most: float  # [N] at command 180
    command: Array  # (k,) the fitted commands
    measured: Array  # (k,) [N] mean of each step
    model: Array  # (k,) [N]


def bench_record(airframe: Airframe, seed: int) -> BenchRecord:
    """A motor of `airframe` on the bench: 17 steps of 5 s with rests of 10 s, as in Spica's Fig. 2a."""
    rng = np.random.default_rng([seed, 34])
    one = [np.full(round(RATE * REST), FITTED[0]), np.zeros(round(RATE * HELD))]
    command = np.concatenate([np.concatenate((one[0], one[1] + step)) for step in STEPS])
    asked, speed = wanted_speed(airframe, command), np.empty(len(command))
    keep, now = np.exp(-1.0 / (RATE * airframe.motor_tau)), airframe.speed_min
    for k, target in enumerate(asked.tolist()):
        speed[k] = now
        now = target + (now - target) * keep
    force = airframe.thrust_coefficient * speed**2
    noise = rng.normal(size=(3, len(command)))
    return BenchRecord(
        np.arange(len(command)) / RATE,
        command,
        speed + SPEED_NOISE * noise[0],
        force + FORCE_NOISE * noise[1],
        airframe.torque_ratio * force + TORQUE_NOISE * noise[2],
    )


def wanted_speed(airframe: Airframe, command: Array) -> Array:
    """Speed [rad/s] that a command asks for: 30 and 180 give the printed limits of the thrust."""
    low, high = FITTED
    share = (command - low) / (high - low)
    return airframe.speed_min + share * (airframe.speed_max - airframe.speed_min)


def identified(airframe: Airframe, record: BenchRecord) -> Motor:
    """Means of each step for the static curves, the second after each step for the time constant."""
    held, rest = round(RATE * HELD), round(RATE * REST)
    starts = rest + np.arange(len(STEPS)) * (rest + held)
    calm = [slice(k + round(RATE * SETTLED), k + held) for k in starts]
    speed, force, torque = (
        np.array([x[s].mean() for s in calm]) for x in (record.speed, record.force, record.torque)
    )
    low, high = FITTED
    fitted = (low <= STEPS) & (high >= STEPS)
    p = answer(STEM, "thrust_polynomial")(speed[fitted], force[fitted])
    model = np.polynomial.polynomial.polyval(speed[fitted], p)
    true = airframe.thrust_coefficient * wanted_speed(airframe, STEPS[fitted]) ** 2
    c = float(torque[fitted] @ force[fitted] / (force[fitted] @ force[fitted]))
    return Motor(
        _time_constant(record, starts, np.polyfit(STEPS, speed, 1)),
        c,
        float(np.sqrt(np.mean((model / true - 1.0) ** 2))),
        float(model[0]),
        float(model[-1]),
        STEPS[fitted],
        force[fitted],
        model,
    )


def _time_constant(record: BenchRecord, starts: Array, line: Array) -> float:
    """Median over the steps that are larger than the noise; `line` turns a command into the speed that it asks for."""
    asked = np.polyval(line, record.command)
    found = []
    for k in starts[4:]:  # from 70 on
        part = slice(k - round(0.2 * RATE), k + round(RATE * SETTLED))
        found.append(
            answer(STEM, "motor_time_constant")(record.t[part], asked[part], record.speed[part])
        )
    return float(np.median(found))


def motor_bench(seeds: int) -> Outcome:
    """The bench of Spica's Sec. 5.3 with the motor of the MK-Quadro."""
    airframe = load_airframe("MK-Quadro")
    records = [bench_record(airframe, seed) for seed in range(seeds)]
    found = [identified(airframe, record) for record in records]

    def row(quantity: str, paper: str, name: str, band: Band) -> Row:
        each = [getattr(motor, name) for motor in found]
        return Row(quantity, paper, float(np.mean(each)), band, float(np.std(each)))

    def near(x: float, share: float) -> Band:
        return Band(x * (1.0 - share), x * (1.0 + share))

    rows = (
        row("time constant of a motor [s]", "0.047", "tau", near(PRINTED["tau"], 0.03)),
        row("torque over thrust [m]", "0.0174", "c", near(PRINTED["c"], 0.03)),
        row("relative error of the thrust, rms", "—", "rms", Band(0.0, 0.02)),
        row("thrust at command 30 [N]", "0.3131", "least", near(PRINTED["least"], 0.02)),
        row("thrust at command 180 [N]", "6.03", "most", near(PRINTED["most"], 0.02)),
    )
    remarks = (
        f"The motor is that of our MK-Quadro; load cell {FORCE_NOISE} N and {TORQUE_NOISE} N m, tachometer "
        f"{SPEED_NOISE} rad/s of noise at {RATE:g} Hz are ours, the paper prints none.",
        "Spica's speed is proportional to the command. Then 180 would give 36 times the thrust of 30; he prints "
        "19.3 times. Ours is a straight line through both of his points.",
        "A time constant comes from 0.2 s before and the second after a step; told is the median of 13 steps.",
    )
    return Outcome(rows, _bench_panels(records[0], found[0]), remarks)


def _bench_panels(record: BenchRecord, motor: Motor) -> tuple[Panel, ...]:
    every = round(RATE / 4.0)
    t_mean, force = (x.reshape(-1, every).mean(axis=1) for x in (record.t, record.force))
    step = slice(
        round(RATE * (REST * 10 + HELD * 9 - 0.1)), round(RATE * (REST * 10 + HELD * 9 + 0.5))
    )
    t = record.t[step] - (REST * 10 + HELD * 9)
    level = record.speed[step]
    low, high = level[:10].mean(), level[-40:].mean()
    gone = np.clip(t, 0.0, None)
    return (
        Panel("Spica Fig. 2a: commands from 30 to 190, with rests", "time [s]", "thrust [N]", (
            Line("means of 0.25 s", t_mean, force),
        ), tuple((REST * (k + 1) + HELD * k, f"{STEPS[k]:g}") for k in range(0, len(STEPS), 4))),
        Panel("Spica Fig. 2b: command over thrust", "thrust [N]", "command", (
            Line("mean of 4 s", motor.measured, motor.command, "points"),
            Line("quadratic in the speed", motor.model, motor.command),
            Line("limits as printed", np.array((PRINTED["least"], PRINTED["most"])), np.array(FITTED), "points"),
        )),
        Panel("One step, to command 120", "time after it [s]", "speed [rad/s]", (
            Line("measured", t, level, "points"),
            Line(f"τ = {motor.tau:.4f} s", t, high + (low - high) * np.exp(-gone / motor.tau)),
        )),
    )  # fmt: skip


# 003-5: sensors at rest -------------------------------------------------------------------------------

ACCEL_NOISE, ORIENTATIONS = 0.05, 24  # [m/s²]
GYRO_NOISE, GYRO_BIAS, GYRO_SAMPLES = 1.87e-3, 8.7e-3, 500  # [rad/s], a sample and at switch-on
GYRO_STILL = 2.0 * GYRO_NOISE  # [rad/s], the threshold
WOBBLE = 0.02  # [rad/s], of a hand that holds the aircraft


class Rest(NamedTuple):
    """One aircraft on the bench."""

    T_off: float  # largest singular value of T̂ T⁻¹ − I
    b_off: Array  # (3,) [m/s²]
    gyro_off: float  # [rad/s], largest of the three axes
    refused: bool  # whether a gyro that was moved was refused
    raw: Array  # (N,) [m/s²] size of the specific force, as measured
    right: Array  # (N,) calibrated


def at_rest(seed: int, count: int = ORIENTATIONS) -> Rest:
    """Calibrate accelerometer and gyro of an aircraft with a mounting, scales and offsets of its own."""
    rng = np.random.default_rng([seed, 35])
    T = _turn(0.05 * rng.normal(size=4) + (1, 0, 0, 0)) @ np.diag(1.0 + 0.03 * rng.normal(size=3))
    b = 0.2 * rng.normal(size=3)
    R = np.array([_turn(q) for q in rng.normal(size=(count, 4))])
    samples = GRAVITY * R[:, 2] @ np.linalg.inv(T).T + b + ACCEL_NOISE * rng.normal(size=(count, 3))
    T_found, b_found = answer(STEM, "accelerometer_calibration")(samples, R)

    bias, noise = GYRO_BIAS * rng.normal(size=3), rng.normal(size=(2, GYRO_SAMPLES, 3))
    gyro_bias = answer(STEM, "gyro_bias")
    found = gyro_bias(bias + GYRO_NOISE * noise[0], GYRO_STILL)
    sway = WOBBLE * np.sin(2.0 * np.pi * np.arange(GYRO_SAMPLES) / 100.0)
    try:
        gyro_bias(bias + sway[:, None] * rng.normal(size=3) + GYRO_NOISE * noise[1], GYRO_STILL)
        refused = False
    except BadInput:
        refused = True
    return Rest(
        float(np.linalg.norm(T_found @ np.linalg.inv(T) - np.eye(3), 2)),
        np.abs(b_found - b),
        float(np.abs(found - bias).max()),
        refused,
        np.linalg.norm(samples, axis=1),
        np.linalg.norm((samples - b_found) @ T_found.T, axis=1),
    )


def _turn(q: Array) -> Mat3:
    """Rotation of a quaternion [w, x, y, z] of any length."""
    return so3.rotation_from_quaternion(q / np.linalg.norm(q))


def sensors_at_rest(seeds: int) -> Outcome:
    """Offsets, scales and mounting, from 24 attitudes."""
    found = [at_rest(seed) for seed in range(seeds)]
    b_off = np.array([x.b_off for x in found])
    T_off, gyro = np.array([x.T_off for x in found]), np.array([x.gyro_off for x in found])
    rows = (
        Row("accelerometer offset off by, each axis [m/s²]", "—", float(b_off.mean()),
            Band(0.0, 0.02), float(b_off.std())),
        Row("the same, worst axis of the worst seed [m/s²]", "—", float(b_off.max())),
        Row("T off by, largest singular value [%]", "—", 100.0 * T_off.mean(), Band(0.0, 1.0), 100.0 * T_off.std()),
        Row("the same, worst seed [%]", "—", 100.0 * T_off.max(), Band(0.0, 1.0)),
        Row("gyro offset off by, worst axis [rad/s]", "—", float(gyro.mean()), None, float(gyro.std())),
        Row("share refused of gyros that were moved", "all", float(np.mean([x.refused for x in found]))),
    )  # fmt: skip
    remarks = (
        f"One sample with {ACCEL_NOISE} m/s² of noise in each of {ORIENTATIONS} random attitudes, which are known. "
        f"The mounting is off by some 6°, the scales by 3 %, the offsets by 0.2 m/s² (1σ).",
        f"The gyro: {GYRO_SAMPLES} samples of {GYRO_NOISE} rad/s; one that sways by about {WOBBLE} rad/s is to "
        f"be refused above a standard deviation of {GYRO_STILL:.2g} rad/s. The paper prints neither.",
        f"By theory the offset is off by 0.05/√24 = {ACCEL_NOISE / sqrt(ORIENTATIONS):.3f} m/s² (1σ), which is half of "
        "the band: a few of sixty lie beyond it.",
    )
    return Outcome(rows, _rest_panels(found[0], min(seeds, 10)), remarks)


def _rest_panels(first: Rest, seeds: int) -> tuple[Panel, ...]:
    counts = np.array((5, 6, 8, 12, 16, 24, 36, 48, 96))
    mean = np.array([np.mean([at_rest(s, n).b_off for s in range(seeds)]) for n in counts.tolist()])
    n = np.arange(1, len(first.raw) + 1)
    return (
        Panel("Size of the specific force at rest", "attitude", "specific force [m/s²]", (
            Line("g", n, np.full(len(n), GRAVITY), "truth"),
            Line("as measured", n, first.raw, "points"),
            Line("calibrated", n, first.right, "points"),
        )),
        Panel("How many attitudes?", "attitudes", "error of the offset [m/s²]", (
            Line(f"mean of {seeds} seeds", counts, mean),
            Line("by theory, 0.8 · 0.05/√N", counts, 0.8 * ACCEL_NOISE / np.sqrt(counts), "dashed"),
            Line("band", counts, np.full(len(counts), 0.02), "paper"),
        ), log_y=True),
    )  # fmt: skip


# 000-33: the thrust curve from hover tests ------------------------------------------------------------


class HoverTest(NamedTuple):
    """Hovers of one aircraft, and the curve that the MRS software is configured with."""

    name: str
    n: int  # rotors
    mass: tuple[float, ...]  # [kg]
    throttle: tuple[float, ...]
    a: float  # for the force of one rotor [1/√N]
    b: float


HOVERS = (
    HoverTest("T650", 4, (3.6, 4.2, 4.78), (0.515, 0.59, 0.66), 0.32, -0.437),
    HoverTest(
        "T18", 8, (7.30, 10.20, 13.15, 16.05), (0.3548, 0.4633, 0.5748, 0.6530), 0.20912, -0.27171
    ),
)
CURVE = 0.01  # share by which a and b may differ from what is configured


def hover_tests(seeds: int) -> Outcome:
    """MRS (33) on the hover tests of two real aircraft. Nothing is left to chance: `seeds` does nothing."""
    rows, panels = [], []
    for test in HOVERS:
        mass, throttle = np.array(test.mass), np.array(test.throttle)
        a, b = answer(STEM, "thrust_curve")(throttle, mass, GRAVITY)
        each, limits = a * sqrt(test.n), sorted((test.b * (1 - CURVE), test.b * (1 + CURVE)))
        off = float(np.abs(a * np.sqrt(mass * GRAVITY) + b - throttle).max())
        rows += [
            Row(f"{test.name}: a, force of one rotor [1/√N]", f"{test.a:g}", each,
                Band(test.a * (1 - CURVE), test.a * (1 + CURVE))),
            Row(f"{test.name}: b", f"{test.b:g}", b, Band(*limits)),
            Row(f"{test.name}: a, collective force, as in MRS (32) [1/√N]", f"{test.a / sqrt(test.n):.4f}", a),
            Row(f"{test.name}: largest residual of the throttle", "—", off),
        ]  # fmt: skip
        m = np.linspace(0.9 * mass[0], 1.1 * mass[-1], 50)
        root = np.sqrt(m * GRAVITY)
        panels.append(
            Panel(f"{test.name}, {test.n} rotors", "√(m g) [√N]", "throttle", (
                Line("as configured by MRS", root, test.a * root / sqrt(test.n) + test.b, "truth"),
                Line("fitted", root, a * root + b),
                Line("hovers", np.sqrt(mass * GRAVITY), throttle, "points"),
            ))
        )  # fmt: skip
    remarks = (
        "The hovers are those in the MRS configuration of the two aircraft. Its a belongs to the force of one rotor; "
        "MRS (32) has the force of all under the root, and its a is smaller by √n.",
    )
    return Outcome(tuple(rows), tuple(panels), remarks)


EXPERIMENTS = (
    Experiment("003-4", "Motor bench", "Spica Sec. 5.3, Fig. 2", motor_bench),
    Experiment("003-5", "Accelerometer and gyro at rest", "Spica Sec. 5.1, 5.2", sensors_at_rest),
    Experiment("000-33", "Thrust curve from hover tests", "MRS Sec. 5.4, eq. 33", hover_tests, 1),
)
