"""Classes as answers: their memory stays with the student, and nothing of theirs is taken at its word."""

from __future__ import annotations

import gc
import importlib

import lag as lags
import numpy as np
import pytest
from lag import Lag

from grader import judge as judging
from grader.build_answer import BEGIN, END, instructor_answer
from grader.handles import MAX_HELD, Ledger, Lost
from grader.judge import PURITY, judge, outcome
from grader.material import Mutant
from grader.remote import ProcessEnded, Remote, Step
from grader.sandbox import Limits
from uavlab.errors import BadFile, CheckFailed
from uavlab.flight.fill import unfinished
from uavlab.types import Estimate, Hypothesis

QUICK = Limits(call=0.5, cell=1.5, submission=6.0)


@pytest.fixture(autouse=True)
def no_material(monkeypatch):
    """The exercise of this file has no hidden part."""
    for name in ("hidden_checks", "mutants", "samples"):
        monkeypatch.setattr(judging, name, lambda *a: [])


def remote(source):
    return Remote([Step(0, source=source), Step(1, keep="Lag")], QUICK)


def verdict(source):
    with remote(source) as box:
        return judge(Lag, box.answer("Lag", Lag.methods), 1)


def failed(said):
    return {r.name for r in said.results if not r.passed}


# In the box -------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("isolation")
def test_a_right_class_gets_full_marks_in_the_box():
    said = verdict(lags.RIGHT)
    assert (said.score, said.hint) == (4.0, "")


@pytest.mark.usefixtures("isolation")
def test_an_unfinished_class_earns_nothing_and_is_told_that_it_is_not_finished():
    head = lags.RIGHT.partition("ZERO =")[0]
    said = verdict(head + Lag.source())
    assert (said.score, said.finished, said.hint) == (0.0, False, Lag.unfinished)


@pytest.mark.usefixtures("isolation")
@pytest.mark.parametrize("source", lags.WORTHLESS.values(), ids=lags.WORTHLESS)
def test_a_class_that_lies_or_forges_earns_nothing(source):
    assert verdict(source).score == 0.0


@pytest.mark.usefixtures("isolation")
@pytest.mark.parametrize("source", [lags.HANGS, lags.DIES, lags.BIG_OUTPUT, lags.ODD, lags.HOARDS])
def test_a_method_that_hangs_dies_or_gives_odd_things_costs_its_checks(source):
    said = verdict(source)
    assert {"exact_decay", "moved_along"} <= failed(said)
    assert said.finished


@pytest.mark.usefixtures("isolation")
def test_a_memory_of_a_process_that_ended_is_lost_and_the_next_object_is_fine():
    with remote(lags.DIES_ONCE) as box:
        answer = box.answer("Lag", Lag.methods)
        part = answer(0.5)
        memory = part.init(np.ones(3))
        with pytest.raises(ProcessEnded):
            part.reframe(memory, np.ones(3))
        for spoilt in (lambda: part.step(memory, np.ones(3), 0.1), lambda: part.init(np.ones(3))):
            with pytest.raises(Lost):
                spoilt()
        part = answer(0.5)
        assert np.allclose(part.step(part.init(np.ones(3)), np.ones(3), 0.1)[1].r, 1.0)
        assert len(answer.faults) == 1


@pytest.mark.usefixtures("isolation")
def test_records_and_dicts_of_them_cross_and_memory_does_not():
    with remote(lags.RIGHT) as box:
        part = box.answer("Lag", Lag.methods)(tau=0.5)
        memory = part.init(np.ones(3))
        assert vars(memory).keys() == {"ledger", "epoch", "number"}
        memory, estimate = part.step(memory, u=np.zeros(3), dt=0.1)
        assert type(estimate) is Estimate
        assert estimate.world == "lag"
        assert type(part.hypotheses(memory)["lag"]) is Hypothesis
        with pytest.raises(AttributeError):
            part.tau  # noqa: B018  (only what was asked for is there)


WATCHES = (
    lags.RIGHT
    + """
import gc, grader.worker
def count():
    return sum(len(x.held) for x in gc.get_objects() if isinstance(x, grader.worker.Namespace))
"""
)


@pytest.mark.usefixtures("isolation")
def test_what_the_judge_lets_go_of_is_forgotten_by_the_student_s_process():
    steps = [Step(0, source=WATCHES), Step(1, keep="Lag"), Step(2, keep="count")]
    with Remote(steps, QUICK) as box:
        part = box.answer("Lag", Lag.methods)(0.5)
        memory = part.init(np.ones(3))
        for _ in range(50):
            memory, _ = part.step(memory, np.zeros(3), 0.1)
        gc.collect()
        box.answer("count")()
        assert box.answer("count")() <= 3


# Without a box ----------------------------------------------------------------------------------------


def test_a_ledger_is_bounded():
    ledger = Ledger()
    for _ in range(MAX_HELD):
        ledger.new()
    with pytest.raises(RuntimeError, match="at once"):
        ledger.new()


@pytest.mark.parametrize("source", [lags.IN_PLACE, lags.GLOBAL], ids=["in place", "global"])
def test_a_memory_that_is_changed_or_kept_elsewhere_is_seen_and_said(source):
    said = judge(Lag, lags.made(source), 1)
    assert PURITY in failed(said)
    assert "The same memory" in next(r.sentence for r in said.results if r.name == PURITY)


def test_a_pure_class_is_called_pure_also_outside_the_box():
    assert judge(Lag, lags.made(lags.RIGHT), 1).score == 4.0


def test_a_result_of_another_form_is_told_so_without_a_number():
    said = judge(Lag, lags.made(lags.NO_TUPLE), 1)
    assert "step must return the tuple that its signature says." in said.results[0].sentence


def test_a_known_mistake_of_a_class_is_called_by_its_name(monkeypatch):
    euler = lags.changed("-np.expm1(-dt / self.tau)", "dt / self.tau")
    still = lags.changed("return memory + shift", "return memory")
    known = [
        Mutant("Lag", lags.made(x), hint) for x, hint in ((still, "Still."), (euler, "Euler."))
    ]

    def play(make):
        part = make(tau=0.5)
        memory = part.reframe(part.init(np.ones(3)), np.ones(3))
        memory, first = part.step(memory, np.zeros(3), 0.1)
        return first, part.hypotheses(memory)

    monkeypatch.setattr(judging, "mutants", lambda x: known)
    monkeypatch.setattr(judging, "samples", lambda x, rng: [play])
    assert judge(Lag, lags.made(euler + "\n"), 1).hint == "Euler."
    assert judge(Lag, lags.made(still + "\n"), 1).hint == "Still."
    assert outcome(lags.made(lags.NO_TUPLE), play) is None


def test_texts_truths_and_names_are_part_of_an_outcome():
    said = [outcome(lambda x: x, (x, {})) for x in ("a", "b", True, {"a": 1.0}, {"b": 1.0}, [1.0])]
    assert all(not judging.agree(a, b) for i, a in enumerate(said) for b in said[:i])


def test_a_student_checks_a_class_in_the_notebook(monkeypatch, capsys):
    checking = importlib.import_module("uavlab.exercises.check")
    monkeypatch.setattr(checking, "find", lambda name: {"Lag": Lag}[name])
    checking.check(lags.made(lags.RIGHT))
    assert "Lag: all 3 public checks pass" in capsys.readouterr().out
    with pytest.raises(CheckFailed, match="2 of 3"):
        checking.check(lags.made(lags.NO_TUPLE))
    stub = lags.made(lags.RIGHT.partition("ZERO =")[0] + Lag.source())
    with pytest.raises(NotImplementedError, match="Lag is not finished"):
        checking.check(stub)
    assert unfinished(stub)
    assert not unfinished(lags.made(lags.RIGHT))


# The instructor's answer ------------------------------------------------------------------------------


class Made:
    """As much of a lab as an answer needs."""

    stem, exercises = "lag", {"Lag": Lag}

    def __init__(self, folder, text):
        self.solutions = folder / "lag.py"
        self.solutions.write_text(text)


def test_the_instructor_gets_the_stub_with_the_reference_s_bodies_and_helpers(tmp_path):
    answer = instructor_answer(Made(tmp_path, lags.RIGHT), Lag)
    assert answer.count(BEGIN) == answer.count(END) == 6  # ZERO, four methods, _share
    assert "Memory that starts at `x`" in answer
    assert "# the exact step" in answer
    assert "NotImplementedError" not in answer
    head = lags.RIGHT.partition("ZERO =")[0]
    assert judge(Lag, lags.made(head + answer), 1).score == 4.0


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("tau: float", "tau: float = 1.0"),
        ("@dataclass(frozen=True)\n", "@dataclass\n"),
        ("def step(self, memory: Memory, u", "def step(self, memory: Memory, v"),
        ("    def _share", "    def share"),
    ],
)
def test_a_reference_class_of_another_form_is_refused(old, new, tmp_path):
    with pytest.raises(BadFile, match="Lag differs from its exercise"):
        instructor_answer(Made(tmp_path, lags.changed(old, new)), Lag)
