"""Plots: what stands in them, read back from the figure."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from made_flights import circle_log

from uavlab.errors import BadInput
from uavlab.flight.metrics import position_error
from uavlab.types import Exit
from uavlab.views import picture, plot_compare, plot_flight, plot_heading, plot_path
from uavlab.views.cast import drawn_scale, rotor_places


@pytest.fixture(autouse=True)
def closed():
    """No figure outlives its test."""
    yield
    plt.close("all")


def texts(figure):
    return " ".join(t.get_text() for t in figure.texts)


def panel(figure, title):
    return next(a for a in figure.axes if a.get_title(loc="left").startswith(title))


@pytest.mark.parametrize("draw", [plot_flight, plot_heading, plot_path, picture])
def test_every_picture_says_who_flew_and_how_it_ended(draw):
    log = circle_log(1.0, exit_=Exit.CRASH, reason="hit the ground at 4.2 m/s")
    said = texts(draw(log))
    for words in ("circle", "t650", "CRASH: hit the ground", "attitude_error=mine", "stand-in"):
        assert words in said


@pytest.mark.parametrize("draw", [plot_flight, plot_heading, plot_path, picture])
def test_a_flight_of_a_single_tick_is_drawn(draw):
    draw(circle_log(0.01)).canvas.draw()


@pytest.mark.parametrize("draw", [plot_flight, plot_heading, plot_path, picture])
def test_what_was_not_recorded_is_said_and_not_drawn(draw):
    log = circle_log(1.0)
    nothing = np.full((100, 3), np.nan)
    log = log._replace(
        r_d=nothing, v_d=nothing, r_e=nothing, wind=nothing, heading_d=nothing[:, 0],
        rotors=np.zeros((100, 0)),
    )  # fmt: skip
    figure = draw(log)
    figure.canvas.draw()
    if draw is plot_flight:
        empty = [a for a in figure.axes if any(t.get_text() == "not recorded" for t in a.texts)]
        assert len(empty) == 6


def test_a_swap_is_a_line_in_every_panel_and_named_in_one():
    told = [[0.0, "controller", "soft", "first"], [0.1, "controller", "tight", "taken over"],
            [0.2, "controller", "mine", "refused: mine: its f_d is nan"]]  # fmt: skip
    log = circle_log(1.0)
    before, after = plot_flight(log), plot_flight(log._replace(meta={**log.meta, "swaps": told}))
    for old, new in zip(before.axes, after.axes, strict=True):
        assert len(new.lines) == len(old.lines) + 2
    said = [x.get_text() for x in panel(after, "tilt").texts]
    assert said == ["tight", "mine refused"]


def test_the_plotted_position_error_is_the_distance_to_the_reference():
    log = circle_log(1.0)
    norm = next(
        line
        for line in panel(plot_flight(log), "position error").lines
        if line.get_label() == "norm"
    )
    np.testing.assert_allclose(norm.get_ydata(), position_error(log))


def test_heading_is_plotted_without_jumps_beside_what_was_asked():
    log = circle_log(6.0)  # the nose turns through ±180°
    flown, asked = (
        next(x for x in panel(plot_heading(log), "heading [deg]").lines if x.get_label() == label)
        for label in ("flown", "asked")
    )
    assert np.abs(np.diff(flown.get_ydata())).max() < 5
    np.testing.assert_allclose(asked.get_ydata() - flown.get_ydata(), np.rad2deg(0.05), atol=1e-9)


def test_a_path_is_drawn_in_equal_scales():
    figure = plot_path(circle_log(6.0))
    assert all(a.get_aspect() == 1.0 for a in figure.axes)


def test_flights_are_compared_by_label_and_by_any_quantity():
    logs = {"mine": circle_log(1.0), "reference": circle_log(2.0)}
    figure = plot_compare(logs, {"height [m]": lambda log: log.r[:, 2]})
    (axes,) = figure.axes
    assert [line.get_label() for line in axes.lines] == ["mine", "reference"]
    np.testing.assert_allclose(axes.lines[1].get_ydata(), logs["reference"].r[:, 2])
    assert "mine: circle" in texts(figure)


def test_nothing_to_compare_is_refused():
    with pytest.raises(BadInput, match="no flights"):
        plot_compare({})


def test_rotor_discs_do_not_overlap_in_any_layout():
    for n in (3, 4, 6, 8):
        angles = (2 * np.pi * np.arange(n) / n).tolist()
        places, spins, radius = rotor_places(circle_log(0.1, angles=angles, spins=[1] * n))
        gaps = np.linalg.norm(places - np.roll(places, 1, axis=0), axis=1)
        assert len(places) == len(spins) == n
        assert 2 * radius < gaps.min()


def test_an_aircraft_is_never_drawn_smaller_than_it_is():
    assert drawn_scale({"hover": circle_log(0.02)}) == 1.0
    assert drawn_scale({"far": circle_log(6.0, radius=100.0)}) > 10
