"""What every exercise owes: a reading, checks that bite, and one signature for stub and reference."""

import importlib
import inspect

import numpy as np
import pytest
from answers import reference, through
from numpy.testing import assert_array_equal

from uavlab.errors import CheckFailed, UnknownName
from uavlab.exercises import (
    STEMS,
    WrongForm,
    all_exercises,
    check,
    exercise,
    exercises,
    expect_close,
    failure,
    find,
    numbers,
)
from uavlab.flight.fill import unfinished

ALL = list(all_exercises())
CONTRACT = {
    "dynamics": "rigid_body_rate step_on_so3 allocation_matrix rotor_thrusts motor_step "
    "throttle_from_force force_from_throttle apparent_mass",
    "heading": "heading_rate with_heading attitude_by_projection attitude_with_heading "
    "yaw_rate_from_heading_rate parasitic_yaw_rate",
    "kalman_bank": "translation_model heading_model predict correct KalmanBank arbitrate shift_between "
    "moved_reference",
    "complementary": "attitude_step position_observer_step drag_velocity vertical_step "
    "body_filter_step inertial_filter_step CoupledFilter",
    "identification": "gyro_bias accelerometer_calibration motor_time_constant thrust_polynomial "
    "thrust_curve drag_coefficient quadratic_drag mass_step inertia_step attitude_response",
    "mpc": "discretize prediction_matrices initial_state build_force_qp build_soft_qp solve "
    "MpcController MpcTracker",
    "geometric": "attitude_error desired_force jerk_feedforward rate_command disturbance_step "
    "estimated_mass unbiased_acceleration torque_command scale_to_limits GeometricController",
}


each = pytest.mark.parametrize("x", ALL, ids=lambda x: x.name)


@pytest.mark.parametrize("stem", STEMS)
def test_a_lab_asks_for_every_name_of_the_contract(stem):
    assert set(CONTRACT[stem].split()) <= {x.name for x in exercises(stem)}


@each
def test_the_reference_has_the_signature_that_was_asked_for(x):
    assert inspect.signature(reference(x)) == inspect.signature(x.stub)
    for name in x.methods:
        asked = inspect.signature(getattr(x.stub, name))
        assert inspect.signature(getattr(reference(x), name)) == asked


@each
def test_an_exercise_says_what_is_asked_in_what_units_and_after_which_paper(x):
    for asked in [getattr(x.stub, name) for name in x.methods] or [x.stub]:
        said = inspect.getdoc(asked)
        assert "Parameters\n-------" in said
        assert "Returns\n-------" in said
        for name in inspect.signature(asked).parameters:
            assert name == "self" or name in said
    said = inspect.getdoc(x.stub)
    assert all(name in said for name in inspect.signature(x.stub).parameters)
    assert x.reads.startswith(("MRS", "Spica", "Bangura", "Landing"))
    assert x.points > 0


@each
def test_the_stub_ships_without_an_answer_and_says_that_it_is_unfinished(x):
    room = dict(vars(importlib.import_module(x.stub.__module__)))  # what a lab imports, and more
    code = f"from __future__ import annotations\n{x.source()}"
    exec(compile(code, "<answer cell>", "exec"), room)
    answer = room[x.name]
    assert unfinished(answer)
    for asked in [getattr(answer, name) for name in x.methods] or [answer]:
        parameters = inspect.signature(asked).parameters.values()
        given = [0.0 for p in parameters if p.kind is not p.KEYWORD_ONLY]
        named = {p.name: 0.0 for p in parameters if p.kind is p.KEYWORD_ONLY}
        with pytest.raises(NotImplementedError, match=f"{x.name} is not finished"):
            asked(*given, **named)
    with pytest.raises(NotImplementedError, match=f"{x.name} is not finished"):
        check(x)


@each
def test_some_public_check_counts_and_every_check_speaks_in_a_sentence(x):
    assert any(item.weight > 0 for item in x.checks)
    assert len({item.name for item in x.checks}) == len(x.checks)
    for item in x.checks:
        assert item.sentence[0].isupper()
        assert item.sentence.endswith(".")


@each
def test_the_reference_passes_what_a_student_calls(x, capsys):
    check(reference(x), seed=3)
    assert f"all {len(x.checks)} public checks pass" in capsys.readouterr().out


@each
def test_public_checks_take_other_inputs_for_another_seed(x):
    for item in x.checks:
        seen = []

        def spy(ask, text, args, _seen=seen):
            _seen.append(text)
            return ask()

        for seed in (1, 2):
            answer = through(x, reference(x), spy)
            assert failure(item, answer, np.random.default_rng(seed)) is None
        first, second = seen[: len(seen) // 2], seen[len(seen) // 2 :]
        assert item.weight == 0 or not set(first) & set(second)


def test_a_wrong_answer_is_told_which_law_it_broke(capsys):
    def motor_step(speed, command, tau, dt):
        return command

    with pytest.raises(CheckFailed, match="motor_step: 2 of 2 public checks"):
        check(motor_step)
    said = capsys.readouterr().out
    assert "✗ one time constant: After one time constant 1/e of the gap is left" in said


def test_an_answer_that_raises_is_shown_its_own_error(capsys):
    def motor_step(speed, command, tau, dt):
        return speed / [][0]

    with pytest.raises(CheckFailed):
        check(motor_step)
    assert "IndexError: list index out of range" in capsys.readouterr().out


def test_a_name_that_nobody_asked_for_is_refused_with_the_nearest():
    with pytest.raises(UnknownName, match="Did you mean 'heading_rate'"):
        find("headingrate")


def test_a_check_without_feedback_is_refused():
    @exercise(points=1, reads="MRS eq. (1)")
    def thing(x: float) -> float:
        """Do it."""
        ...

    with pytest.raises(TypeError, match="docstring"):
        thing.check(lambda f, rng: None)


@pytest.mark.parametrize(
    "said",
    [None, "0.0", 1j, [1.0, [2.0]], {"x": 1.0}, np.array([None]), np.array("1.0"), object(), True],
    ids=lambda x: type(x).__name__,
)
def test_what_is_not_a_number_is_not_taken_for_one(said):
    with pytest.raises(WrongForm, match="One number is asked for"):
        numbers(said, ())


def test_numbers_of_another_shape_or_not_finite_are_refused():
    with pytest.raises(WrongForm, match=r"shape \(3,\) are asked for. This one has shape \(1, 3\)"):
        numbers(np.zeros((1, 3)), (3,))
    with pytest.raises(WrongForm, match="finite"):
        numbers([1.0, np.nan, 0.0], (3,))


def test_an_array_that_lies_about_itself_is_seen_as_it_is():
    class Liar(np.ndarray):
        def __eq__(self, other):
            return True

        def __array_function__(self, *args):
            return True

        def __array_ufunc__(self, *args, **kwargs):
            return np.zeros(3)

    liar = np.ones(3).view(Liar)
    plain = numbers(liar, (3,))
    assert type(plain) is np.ndarray
    assert_array_equal(plain, np.ones(3))
    with pytest.raises(CheckFailed):
        expect_close(liar, np.zeros(3))


def test_close_means_close():
    expect_close([1.0, 2.0 + 1e-10], [1.0, 2.0])
    with pytest.raises(CheckFailed, match=r"off by 0\.001"):
        expect_close([1.0, 2.001], [1.0, 2.0])
