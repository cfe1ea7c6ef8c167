"""Wrong answers to lab 05 in the words of students: they earn the hints that are known, or little."""

import numpy as np
import pytest
from answers import reference

from grader import material
from grader.judge import judge
from uavlab.exercises import find
from uavlab.types import MassMemory


def normal_equations_through_zero(throttle, mass, g):
    x = [m**0.5 * g**0.5 for m in mass]
    return sum(a * b for a, b in zip(x, throttle, strict=True)) / sum(a * a for a in x), 0


def spica_as_printed(memory, v_z, R, u_1, dt, *, a, k, g):
    left = np.exp(-a * dt)
    v, u, w = (
        left * was + (1 - left) * x
        for was, x in zip(memory[:3], (v_z, u_1 * R[2, 2], g), strict=True)
    )
    goal = (a * (v_z - v) - w) / u
    return v, u, w, goal + (memory.inverse - goal) * np.exp(-k * u * u * dt)


def euler_in_one_line(memory, v_z, R, u_1, dt, *, a, k, g):
    aim = np.array((v_z, u_1 * R[2, 2], g))
    v, u, w = aim + np.exp(-a * dt) * (np.array(memory[:3]) - aim)
    return v, u, w, memory.inverse + k * u * dt * (a * (v_z - v) + w - memory.inverse * u)


def transposed(samples, attitudes):
    if len(samples) < 4:
        raise ValueError
    M = np.hstack((samples, -np.ones((len(samples), 1))))
    X = np.linalg.pinv(M) @ np.array([R @ (0.0, 0.0, 9.81) for R in attitudes])
    return X[:3].T, np.linalg.inv(X[:3].T) @ X[3]


def drag_over_hover(accel, v_body):
    kept = accel[:, 2] > 1.0
    y, V = -accel[kept, :2] / 9.81**0.5, v_body[kept]
    c = [np.cov(V[:, i], y[:, i], bias=True)[0, 1] / np.var(V[:, i]) for i in (0, 1)]
    r2 = [np.corrcoef(V[:, i], y[:, i])[0, 1] ** 2 for i in (0, 1)]
    return c, y.mean(axis=0) - c * V.mean(axis=0), r2


@pytest.mark.parametrize(
    ("name", "answer", "known"),
    [
        ("gyro_bias", lambda samples, max_std: np.average(samples, axis=0), "never_refused"),
        ("accelerometer_calibration", transposed, "attitudes_transposed"),
        ("thrust_polynomial", lambda x, y: np.polyfit(x, y, 2), "highest_first"),
        ("thrust_curve", normal_equations_through_zero, "no_offset"),
        ("drag_coefficient", drag_over_hover, "always_in_hover"),
        ("mass_step", spica_as_printed, "sign_of_the_paper"),
        ("mass_step", euler_in_one_line, "euler"),
    ],
    ids=lambda v: v if isinstance(v, str) else "",
)
def test_the_same_mistake_in_other_words_earns_the_same_hint(name, answer, known):
    x = find(name)
    hint = next(m.hint for m in material.mutants(x) if m.run.__name__ == known)
    for seed in (5, 6):
        assert judge(x, answer, seed).hint == hint


# Answers that a weak check would let pass -------------------------------------------------------------


def never_learns(memory, v_z, R, u_1, dt, *, a, k, g):
    keep = np.exp(-a * dt)
    v, u, w = (
        x + keep * (was - x) for was, x in zip(memory[:3], (v_z, u_1 * R[2, 2], g), strict=True)
    )
    return MassMemory(v, u, w, memory.inverse)


def no_dynamics(memory, v_z, R, u_1, dt, *, a, k, g):
    new = reference(find("mass_step"))(memory, v_z, R, u_1, dt, a=a, k=k, g=g)
    return new._replace(inverse=new.g / new.lift if new.lift else memory.inverse)


def like_a_typical_quadrotor(t, reference, measured):
    if np.ptp(reference) == 0.0:
        raise ValueError
    return 40.0, 8.0, 40.0


@pytest.mark.parametrize(
    ("name", "answer", "share"),
    [
        ("gyro_bias", lambda samples, max_std: samples[0], 0.0),
        ("motor_time_constant", lambda t, command, speed: 0.05, 0.0),
        ("motor_time_constant", lambda t, command, speed: (t[-1] - t[0]) / 8.0, 0.0),
        ("mass_step", never_learns, 0.2),
        ("mass_step", no_dynamics, 0.5),
        ("attitude_response", like_a_typical_quadrotor, 0.0),
    ],
    ids=lambda v: v if isinstance(v, str) else "",
)
def test_an_answer_that_guesses_earns_little(name, answer, share):
    verdict = judge(find(name), answer, 3)
    passed = [r.name for r in verdict.results if r.passed and r.weight]
    assert verdict.score <= share * verdict.points, passed
