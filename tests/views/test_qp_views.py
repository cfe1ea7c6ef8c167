"""The picture of a QP, and sliders beside a picture."""

import sys
import types

import matplotlib.pyplot as plt
import numpy as np
import pytest

from uavlab import views
from uavlab.errors import BadInput
from uavlab.qp import INFEASIBLE, QP, SOLVED, Plan, hard
from uavlab.views import plot_qp, sliders
from uavlab.views import qp as qp_views

INF = np.inf


def problem():
    """Minimise (z₀² + z₁²)/2 + 3 z₀ − 2 z₁ with z₀ ≥ −1 hard, z₁ ≤ 1 soft at 0.25, and a row that is idle."""
    A = np.array(((1.0, 0.0), (0.0, 1.0), (1.0, 1.0)))
    l, u = np.array((-1.0, -INF, -10.0)), np.array((INF, 1.0, 10.0))
    qp = QP(np.eye(2), np.array((3.0, -2.0)), A, l, u, np.array((INF, 0.25, INF)))
    plan = Plan(np.array((-1.0, 1.75)), np.array((-2.0, 0.25, 0.0)), SOLVED, -4.28, 4)
    return qp, plan


def test_the_plan_of_the_example_is_the_best_one():
    qp, plan = problem()
    np.testing.assert_allclose(qp.P @ plan.z + qp.q + qp.A.T @ plan.y, 0.0, atol=1e-12)


def test_rows_at_work_are_those_with_a_multiplier_and_a_soft_one_may_be_missed():
    qp, plan = problem()
    assert qp_views.working(qp, plan).tolist() == [True, True, False]
    np.testing.assert_allclose(qp_views.missed(qp, plan), (0.0, 0.75, 0.0))


def test_a_row_lies_at_its_bounds_or_between_or_beyond_them():
    qp, plan = problem()
    np.testing.assert_allclose(qp_views.place(qp, plan), (0.0, 1.75, 0.5375))
    free = qp._replace(l=np.full(3, -INF), u=np.full(3, INF))
    assert qp_views.place(free, plan).tolist() == [0.5] * 3
    one = qp._replace(l=np.array((-1.0, 1.75, 1.0)), u=np.array((-1.0, 1.75, 1.0)))
    np.testing.assert_allclose(qp_views.place(one, plan), (0.5, 0.5, 0.25))


def test_the_picture_says_what_is_in_it():
    figure = plot_qp(*problem())
    titles = [at.get_title(loc="left") for at in figure.axes]
    assert "P (2 × 2): 50% filled" in titles
    assert "A (3 × 2): 67% filled" in titles
    assert "the plan z (2): solved" in titles
    said = figure.texts[-1].get_text()
    assert "2 of 3 rows at work; 1 rows are soft, 1 of them at work, 1 missed" in " ".join(
        said.split()
    )
    plt.close(figure)


def test_what_is_no_answer_is_drawn_as_such():
    qp, plan = problem()
    figure = plot_qp(qp, plan._replace(status=INFEASIBLE, z=np.zeros(2), y=np.zeros(3)))
    assert "NO ANSWER (infeasible)" in figure.texts[-1].get_text()
    plt.close(figure)


def test_a_problem_without_rows_or_cost_can_be_drawn():
    qp = QP(np.zeros((2, 2)), np.zeros(2), np.zeros((0, 2)), np.zeros(0), np.zeros(0), hard(0))
    figure = plot_qp(qp, Plan(np.zeros(2), np.zeros(0), SOLVED, 0.0, 0))
    figure.canvas.draw()
    plt.close(figure)


def test_the_plan_of_another_problem_is_refused():
    qp, plan = problem()
    with pytest.raises(BadInput, match="2 variables and 3 rows, the plan 3 and 3"):
        plot_qp(qp, plan._replace(z=np.zeros(3)))


# Sliders -----------------------------------------------------------------------------------------------


CONTROLS = {
    "gain": (1.0, 12.0, 6.0), "horizon": (5, 40, 26), "group": ["slow", "fast"], "wind": True
}  # fmt: skip


def figure_of(seen):
    def draw(**values):
        seen.append(values)
        figure, at = plt.subplots()
        at.plot([0, values.get("gain", 0.0)])
        return figure

    return draw


def test_without_a_notebook_it_draws_once_and_says_so(capsys):
    seen = []
    drawn = sliders(figure_of(seen), **CONTROLS)
    assert seen == [{"gain": 6.0, "horizon": 26, "group": "slow", "wind": True}]
    said = capsys.readouterr().out
    assert said.startswith("Drawn once, with gain = 6.0, horizon = 26, group = slow, wind = True:")
    assert said.count("\n") == 1
    assert drawn.value.axes
    assert drawn._repr_mimebundle_()["image/png"].startswith("iVBOR")
    assert not plt.get_fignums()


def test_what_is_no_figure_comes_back_as_it_is():
    assert sliders(lambda gain: 2.0 * gain, gain=(0.0, 2.0, 1.0)) == 2.0


@pytest.fixture
def watched(monkeypatch):
    """A notebook in a browser, as far as sliders can tell; gives the pictures that it shows, newest last."""
    shown = []

    class Handle:
        def update(self, value):
            shown.append(value)

    def display(value, display_id):
        shown.append(value)
        return Handle()

    kernel = types.SimpleNamespace(get_parent=lambda: {"metadata": {"cellId": "a"}})
    monkeypatch.setattr("IPython.get_ipython", lambda: types.SimpleNamespace(kernel=kernel))
    monkeypatch.setattr("IPython.display.display", display)
    return shown


def test_in_a_notebook_a_slider_that_is_let_go_draws_again(watched, capsys):
    seen = []
    box = sliders(figure_of(seen), **CONTROLS)
    gain, horizon, group, wind = box.children
    assert capsys.readouterr().out == ""
    assert not gain.continuous_update
    assert (gain.min, gain.max, horizon.step) == (1.0, 12.0, 1)
    gain.value, horizon.value = 3.0, 10
    group.value, wind.value = "fast", False
    assert len(seen) == len(watched) == 5
    assert seen[-1] == {"gain": 3.0, "horizon": 10, "group": "fast", "wind": False}
    assert watched[0].png != watched[-1].png
    assert not plt.get_fignums()


def test_an_error_after_a_slider_was_moved_is_shown_in_place_of_the_picture(watched):
    def draw(gain):
        if gain > 5.0:
            raise BadInput("too much")
        return plt.figure()

    box = sliders(draw, gain=(0.0, 10.0, 1.0))
    box.children[0].value = 8.0
    assert watched[-1]._repr_mimebundle_() == {"text/plain": "BadInput: too much"}
    box.children[0].value = 2.0
    assert watched[-1].png


def test_an_error_of_the_first_picture_is_raised_where_everybody_sees_it(watched):
    def draw(gain):
        raise NotImplementedError("exercise 6.1")

    with pytest.raises(NotImplementedError, match=r"exercise 6\.1"):
        sliders(draw, gain=(0.0, 10.0, 1.0))


def test_without_ipywidgets_a_notebook_gets_one_picture(watched, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "ipywidgets", None)
    seen = []
    sliders(figure_of(seen), gain=(1.0, 12.0, 6.0))
    assert seen == [{"gain": 6.0}]
    assert "sliders need ipywidgets" in capsys.readouterr().out
    assert watched == []


def test_what_runs_notebooks_for_the_book_gets_one_picture(watched, monkeypatch, capsys):
    kernel = types.SimpleNamespace(get_parent=lambda: {"metadata": {}})
    monkeypatch.setattr("IPython.get_ipython", lambda: types.SimpleNamespace(kernel=kernel))
    sliders(figure_of([]), gain=(1.0, 12.0, 6.0))
    assert "Drawn once" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (3.0, r"control gain is 3\.0; give \(low, high, start\)"),
        ((0.0, 1.0), "give"),
        ((0.0, np.inf, 1.0), "give"),
        ([], "give"),
        ((2.0, 1.0, 1.5), "must grow"),
        ((0.0, 1.0, 1.5), "low 0.0, start 1.5 and high 1.0 must grow"),
        ((0.0, 1.0, 0.5, 0.0), "its step is 0.0; it must be > 0"),
    ],
)
def test_what_is_no_control_is_refused(given, said):
    with pytest.raises(BadInput, match=said):
        views.sliders(lambda gain: None, gain=given)
