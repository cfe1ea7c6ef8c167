"""Wrong answers: known mistakes are called by their names, in whatever words."""

import re
from functools import cache

import numpy as np
import pytest
from answers import reference

from grader import material
from grader.judge import judge
from uavlab import frames, so3
from uavlab.errors import CheckFailed
from uavlab.exercises import all_exercises, find
from uavlab.exercises.expect import expect_heading_rate
from uavlab.solutions import dynamics, heading

ALL = list(all_exercises())
each_mutant = pytest.mark.parametrize(
    ("x", "known"),
    [
        pytest.param(
            x,
            m,
            id=f"{x.name}-{m.run.__name__}",
            marks=[pytest.mark.slow]
            if x.is_class and i > 1
            else [],  # classes fly, mistake by mistake
        )
        for x in ALL
        for i, m in enumerate(material.mutants(x))
    ],
)


# Wrong answers ----------------------------------------------------------------------------------------


@cache
def verdict_on(name, run, seed):
    """What the judge says of a known mistake, judged once for all tests."""
    return judge(find(name), run, seed)


def loses_points_and_earns_its_hint(x, known, seeds):
    for seed in seeds:
        verdict = verdict_on(x.name, known.run, seed)
        assert verdict.score < x.points
        assert any(r.weight > 0 and not r.passed for r in verdict.results)
        assert verdict.hint == known.hint


@each_mutant
def test_a_known_mistake_loses_points_and_earns_its_own_hint(x, known):
    loses_points_and_earns_its_hint(x, known, range(1))


@pytest.mark.slow
@each_mutant
def test_a_known_mistake_loses_points_and_earns_its_own_hint_for_two_more_seeds(x, known):
    loses_points_and_earns_its_hint(x, known, range(300, 302))


@each_mutant
def test_feedback_holds_no_number_of_the_hidden_inputs(x, known):
    laws = {c.name: c.sentence for c in x.checks + material.hidden_checks(x)}
    for result in verdict_on(x.name, known.run, 0).results:
        said = result.sentence.removeprefix(laws.get(result.name, result.sentence))
        assert not re.search(r"\d", re.sub(r"of shape \([\d, ]*\)", "", said))


def degrees_per_second(R, omega):
    x_dot, y_dot = R[:2, 1] * omega[2] - R[:2, 2] * omega[1]
    return 180.0 / np.pi * (R[0, 0] * y_dot - R[1, 0] * x_dot) / (R[0, 0] ** 2 + R[1, 0] ** 2)


def no_cross_term(state, force, torque, *, m, J):
    S = np.array([np.cross(row, state.omega) for row in state.R])
    return state.v, force / m, S, np.linalg.inv(J) @ torque


def lee_by_gram_schmidt(f_d, heading_d):
    z = f_d / np.linalg.norm(f_d)
    x = np.array((np.cos(heading_d), np.sin(heading_d), 0.0))
    x = x - z * (z @ x)
    x = x / np.linalg.norm(x)
    return np.array([x, np.cross(z, x), z]).T


def series_of_one_term(R, omega, dt):
    x, y, z = np.asarray(omega) * dt
    return R + np.stack(
        (R[:, 1] * z - R[:, 2] * y, R[:, 2] * x - R[:, 0] * z, R[:, 0] * y - R[:, 1] * x), 1
    )


def heading_of_arcsin(R_o, heading):
    now = np.arcsin(R_o[1, 0] / np.hypot(R_o[0, 0], R_o[1, 0]))
    c, s = np.cos(heading - now), np.sin(heading - now)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ R_o


def arctan_by_hand(R_o, heading):
    turn = np.exp(1j * (heading - np.arctan(R_o[1, 0] / R_o[0, 0])))
    flat = turn * (R_o[0] + 1j * R_o[1])
    return np.vstack((flat.real, flat.imag, R_o[2]))


def spica_s_construction(f_d, heading_d):
    x = np.cross(np.array((-np.sin(heading_d), np.cos(heading_d), 0.0)), f_d)
    y = np.cross(f_d, x)
    return np.transpose([v / np.sqrt(v @ v) for v in (x, y, f_d)])


def spins_forgotten(angles, arm, torque_ratio, spins):
    columns = [(1.0, arm * np.sin(a), -arm * np.cos(a), torque_ratio) for a in angles]
    return np.array(columns).T


def inverse_of_a_wide_matrix(f, tau, allocation):
    return np.linalg.solve(allocation, np.append(f, tau))


def parabola(T, a_t, b_t):
    return (T * T - 2.0 * T * b_t + b_t * b_t) / a_t**2


@pytest.mark.parametrize(
    ("name", "answer", "known"),
    [
        ("heading_rate", lambda R, omega: float(omega[-1]), "yaw_rate_taken"),
        ("heading_rate", degrees_per_second, "in_degrees"),
        (
            "heading_rate",
            lambda R, omega: (
                -(R[2, 1] * omega[1] - R[2, 2] * omega[2]) / (R[0, 0] ** 2 + R[1, 0] ** 2)
            ),
            "pitch_part_subtracted",
        ),
        ("heading_rate", lambda R, omega: (R @ omega)[2], "vertical_part"),
        ("rigid_body_rate", no_cross_term, "no_gyroscopic_term"),
        ("step_on_so3", series_of_one_term, "euler"),
        ("with_heading", arctan_by_hand, "arctan_for_atan2"),
        ("attitude_with_heading", lee_by_gram_schmidt, "lee_instead"),
        ("attitude_with_heading", spica_s_construction, "backwards_upside_down"),
        ("allocation_matrix", spins_forgotten, "spins_ignored"),
        ("rotor_thrusts", inverse_of_a_wide_matrix, "inverse_only"),
        ("motor_step", lambda s, c, tau, dt: s - (s - c) * dt / tau, "euler_lag"),
        ("throttle_from_force", lambda f, a, b: a * max(0, f) + b, "no_root"),
        ("force_from_throttle", parabola, "other_branch"),
        ("apparent_mass", lambda T, a, b, g: parabola(max(T, b), a, b), "weight_for_mass"),
        (
            "yaw_rate_from_heading_rate",
            lambda R, rate: rate * np.hypot(R[0, 0], R[1, 0]) / R[2, 2],
            "unit_shadow",
        ),
        ("parasitic_yaw_rate", lambda R, w: w[1] / R[2, 2] * R[2, 1], "sign_of_the_paper"),
    ],
    ids=lambda v: v if isinstance(v, str) else "",
)
def test_the_same_mistake_in_other_words_earns_the_same_hint(name, answer, known):
    x = find(name)
    hint = next(m.hint for m in material.mutants(x) if m.run.__name__ == known)
    for seed in (5, 6):
        assert judge(x, answer, seed).hint == hint


def test_a_mistake_that_nobody_knows_earns_the_sentence_of_the_first_law_it_broke():
    x = find("with_heading")
    verdict = judge(x, heading_of_arcsin, 1)
    first = next(r for r in verdict.results if not r.passed)
    assert verdict.hint == first.sentence
    assert 0.0 <= verdict.score < x.points


def test_the_issue_s_own_example_is_called_by_its_name():
    known = next(m for m in material.mutants(find("heading_rate")) if "tilted" in m.hint)
    assert known.hint.startswith("The heading rate has the wrong sign when the aircraft is tilted")


# Answers that a weak check would let pass -------------------------------------------------------------


def two_errors_that_cancel(state, force, torque, *, m, J):
    return state.v, force / m, np.zeros((3, 3)), np.linalg.solve(J, torque)


def by_differences(R, omega):
    h = 1e-5
    change = frames.heading(R @ so3.exp(h * omega)) - frames.heading(R @ so3.exp(-h * omega))
    return frames.wrap(change) / (2.0 * h)


def yaw_by_differences(R, heading_rate):
    return heading_rate / by_differences(R, np.eye(3)[2]) if abs(R[2, 2]) > 1e-6 else 0.0


def parasite_by_differences(R, omega):
    return yaw_by_differences(R, -by_differences(R, omega * (1.0, 1.0, 0.0)))


@pytest.mark.parametrize(
    ("name", "answer", "share"),
    [
        ("rigid_body_rate", two_errors_that_cancel, 0.5),
        ("apparent_mass", lambda T, a, b, g: 1.0 / g, 0.0),
        ("motor_step", lambda s, c, tau, dt: dynamics.motor_step(s, c, 1.0, dt), 0.0),
        (
            "allocation_matrix",
            lambda at, arm, c, s: dynamics.allocation_matrix(at + np.pi / 2, arm, c, s),
            0.0,
        ),
        ("heading_rate", lambda R, omega: R[2] @ omega, 0.0),
        ("heading_rate", by_differences, 0.4),
        ("yaw_rate_from_heading_rate", yaw_by_differences, 0.4),
        ("parasitic_yaw_rate", parasite_by_differences, 0.4),
    ],
    ids=lambda v: v if isinstance(v, str) else "",
)
def test_an_answer_that_only_keeps_a_symmetry_or_a_difference_earns_little(name, answer, share):
    verdict = judge(find(name), answer, 3)
    passed = [r.name for r in verdict.results if r.passed and r.weight]
    assert verdict.score <= share * verdict.points, passed


@pytest.mark.parametrize("kind", [TimeoutError, RuntimeError, OSError, ValueError])
@pytest.mark.parametrize("name", ["attitude_by_projection", "attitude_with_heading"])
def test_only_a_refusal_counts_as_one_not_a_hang_or_a_crash(name, kind):
    x = find(name)

    def answer(f_d, heading_d):
        try:
            return reference(x)(f_d, heading_d)
        except ValueError:
            raise kind from None

    assert (judge(x, answer, 3).score == x.points) == (kind is ValueError)


def test_the_public_helper_does_not_give_the_heading_rate_away():
    R, omega = so3.exp(np.array((0.3, -0.4, 1.0))), np.array((0.5, 1.1, -0.7))
    right = heading.heading_rate(R, omega)
    with pytest.raises(CheckFailed) as failed:
        expect_heading_rate(right + 50.0, R, omega)
    frame, seen = failed.value.__traceback__, []
    while frame is not None:
        if frame.tb_frame.f_code.co_filename.endswith("expect.py"):
            seen += [v for v in frame.tb_frame.f_locals.values() if isinstance(v, float)]
        frame = frame.tb_next
    assert not any(abs(v - right) < 1e-3 for v in seen)
    assert f"{right:.3f}" not in str(failed.value)
