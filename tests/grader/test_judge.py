"""The judge: right answers get everything, trivial ones nothing, and a known mistake is called by its name."""

import numpy as np
import pytest
from answers import reference, through

from grader import judge as judging
from grader import material
from grader.canaries import TOKEN, canaries, secret_files
from grader.judge import PURITY, Watched, judge
from uavlab.exercises import STEMS, all_exercises, find

ALL = list(all_exercises())
VARIANTS = [(x, v) for x in ALL for v in material.variants(x)]
each = pytest.mark.parametrize("x", ALL, ids=lambda x: x.name)
each_variant = pytest.mark.parametrize(
    ("x", "other"), VARIANTS, ids=[f"{x.name}-{v.run.__name__}" for x, v in VARIANTS]
)


def full_marks(x, answer, seeds):
    for seed in seeds:
        verdict = judge(x, answer, seed)
        assert verdict.score == x.points, (seed, [r for r in verdict.results if not r.passed])
        assert verdict.hint == ""
        assert verdict.finished


# Right answers ----------------------------------------------------------------------------------------


@each
def test_the_reference_gets_full_marks(x):
    full_marks(x, reference(x), range(1))


@pytest.mark.slow
@each
def test_the_reference_gets_full_marks_for_ten_seeds(x):
    full_marks(x, reference(x), range(100, 110))


@each_variant
def test_a_right_answer_written_differently_gets_full_marks(x, other):
    full_marks(x, other.run, range(1))


@pytest.mark.slow
@each_variant
def test_a_right_answer_written_differently_gets_full_marks_for_five_seeds(x, other):
    full_marks(x, other.run, range(200, 205))


def test_a_warning_costs_no_points():
    def throttle_from_force(f, a_t, b_t):
        np.sqrt(np.array(-1.0))
        return reference(find("throttle_from_force"))(f, a_t, b_t)

    full_marks(find("throttle_from_force"), throttle_from_force, range(1))


@each
def test_there_is_enough_to_judge_with(x):
    assert len(x.checks) >= 1
    assert len(material.hidden_checks(x)) >= 3
    assert len(material.mutants(x)) >= 5
    assert len(material.variants(x)) >= 2
    assert len(material.samples(x, np.random.default_rng(0))) >= 4
    names = [c.name for c in x.checks + material.hidden_checks(x)]
    assert len(set(names)) == len(names)


@each
def test_hints_are_sentences_and_no_two_are_the_same(x):
    hints = [m.hint for m in material.mutants(x)]
    assert len(set(hints)) == len(hints)
    assert all(len(h) > 20 and h.endswith(".") for h in hints)


@each
def test_a_stub_is_unfinished(x):
    verdict = judge(x, x, 0)
    assert (verdict.score, verdict.finished, verdict.hint) == (0.0, False, x.unfinished)


# How it judges ----------------------------------------------------------------------------------------


def raising(kind):
    def answer(*args, **kwargs):
        raise kind("no")

    return answer


def record(x, answer, seed):
    asked = []

    def spy(ask, text, args):
        asked.append(text)
        return ask()

    return judge(x, through(x, answer, spy), seed), asked


@each
def test_one_seed_asks_the_same_twice_and_another_seed_asks_other_things(x):
    answer = material.mutants(x)[0].run
    first, asked = record(x, answer, 1)
    again, asked_again = record(x, answer, 1)
    _, other = record(x, answer, 2)
    assert (first, asked) == (again, asked_again)
    assert len(set(asked) & set(other)) < len(asked) / 2


@each
def test_an_answer_is_called_a_bounded_number_of_times(x):
    calls = []
    for item in x.checks + material.hidden_checks(x):
        watched = Watched(reference(x), x.methods)
        item.run(watched, np.random.default_rng(0))
        calls.append(watched.calls)
    flights = [n for n in calls if n > 100]
    short = sum(calls) - sum(flights) + len(material.samples(x, np.random.default_rng(0)))
    assert short <= (600 if x.methods else 400)  # a class is made and asked again
    assert sum(flights) <= 1500


@pytest.mark.parametrize("stem", STEMS)
def test_every_lab_is_flown_with_the_student_s_own_function(stem):
    flown = []
    for x in ALL:
        for item in material.hidden_checks(x) if x.stem == stem else ():
            watched = Watched(reference(x), x.methods)
            item.run(watched, np.random.default_rng(0))
            flown += [item.name] if watched.calls >= (70 if x.methods else 200) else []
    assert flown


def test_what_a_known_mistake_says_is_asked_once_for_a_whole_class(monkeypatch):
    x, asked = find("motor_step"), []
    known = material.mutants(x)[0]

    def counted(*args):
        asked.append(args)
        return known.run(*args)

    alone = [material.Mutant(x.name, counted, known.hint)]
    monkeypatch.setattr(judging, "mutants", lambda exercise: alone)
    assert {judge(x, known.run, 41).hint for _ in range(3)} == {known.hint}
    assert len(asked) == len(material.samples(x, np.random.default_rng(0)))
    assert judge(x, known.run, 42).hint == known.hint
    assert len(asked) == 2 * len(material.samples(x, np.random.default_rng(0)))


def test_partial_credit_is_given_check_by_check():
    x = find("rigid_body_rate")
    wrong = next(m for m in material.mutants(x) if m.run.__name__ == "no_gyroscopic_term")
    verdict = judge(x, wrong.run, 0)
    won = sum(r.weight for r in verdict.results if r.passed)
    assert 0.0 < verdict.score < x.points
    assert verdict.score == round(x.points * won / sum(r.weight for r in verdict.results), 2)


def test_an_exception_costs_the_check_it_happens_in_and_its_text_is_not_repeated():
    x = find("rotor_thrusts")

    def rotor_thrusts(f, tau, allocation):
        if allocation.shape[1] > 4:
            raise RuntimeError(f"secret {tau}")
        return reference(x)(f, tau, allocation)

    verdict = judge(x, rotor_thrusts, 0)
    assert 0.0 < verdict.score < x.points
    broken = next(r for r in verdict.results if r.name == "none_is_wasted")
    assert broken.sentence.endswith("(Your code raised an error.)")
    assert "secret" not in repr(verdict)


def test_a_class_name_cannot_carry_text_into_the_feedback():
    kind = type("<script>alert(1)</script>", (Exception,), {})
    verdict = judge(find("motor_step"), raising(kind), 0)
    assert "script" not in repr(verdict)
    assert "raised an error" in verdict.results[0].sentence


def test_an_unfinished_branch_costs_its_checks_only():
    x = find("rotor_thrusts")

    def rotor_thrusts(f, tau, allocation):
        if allocation.shape[1] > 4:
            raise NotImplementedError
        return reference(x)(f, tau, allocation)

    verdict = judge(x, rotor_thrusts, 0)
    assert verdict.finished
    assert verdict.score > 0.0


def test_an_answer_that_changes_its_inputs_is_told_so_and_loses_little():
    x = find("parasitic_yaw_rate")

    def parasitic_yaw_rate(R, omega):
        said = reference(x)(R, omega)
        omega[2] = 0.0
        return said

    verdict = judge(x, parasitic_yaw_rate, 0)
    assert [r.name for r in verdict.results if not r.passed] == [PURITY]
    assert 0.8 * x.points < verdict.score < x.points
    assert "work on a copy" in verdict.hint


@each
def test_a_hidden_law_is_told_in_one_sentence(x):
    for item in material.hidden_checks(x):
        assert item.sentence[0].isupper()
        assert item.sentence.endswith(".")
        assert len(item.sentence) < 140


def test_every_secret_file_carries_a_token_of_its_own():
    tokens = canaries()
    assert sorted(tokens.values()) == sorted(secret_files())
    assert len(tokens) >= 10
    assert all(TOKEN.fullmatch(t) for t in tokens)


def test_judging_an_exercise_takes_a_fraction_of_a_second():
    import time

    began = time.process_time()
    for x in ALL:
        judge(x, reference(x), 0)
    assert time.process_time() - began < 0.15 * len(ALL)
