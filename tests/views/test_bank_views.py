"""What a bank of filters looks like: its plot, and its ghosts in the replay."""

import numpy as np
import pytest
from browser import open_page
from made_flights import banked_log, circle_log

from uavlab.errors import BadInput
from uavlab.flight.metrics import position_error
from uavlab.views import picture, plot_bank, plot_flight, plot_path, replay
from uavlab.views.style import hypothesis


def line(axes, label):
    return next(x for x in axes.lines if str(x.get_label()).startswith(label))


def test_on_the_left_the_estimate_jumps_as_it_was_told_and_on_the_right_nothing_does():
    log = banked_log()
    figure = plot_bank(log)
    told, error = figure.axes[0], figure.axes[1]
    jump = np.abs(np.diff(line(told, "estimate").get_ydata())).max()
    assert jump > 1.0
    flies = next(x for x in error.lines if x.get_linestyle() == "--").get_ydata()
    np.testing.assert_allclose(flies, log.r_e[0, 0] - log.r[0, 0], atol=1e-9)


def test_a_hypothesis_is_drawn_in_its_colour_only_while_it_is_reliable():
    log = banked_log()
    drawn = line(plot_bank(log).axes[0], "map").get_ydata()
    assert np.isnan(drawn[: len(log.t) // 4]).all()
    assert np.isfinite(drawn[len(log.t) // 4 :]).all()
    assert line(plot_bank(log).axes[0], "map").get_color() == hypothesis(1)


def test_the_strip_says_who_flew():
    strip = plot_bank(banked_log()).axes[9]
    assert [t.get_text() for t in strip.get_yticklabels()] == ["gnss", "map"]
    assert len(strip.collections) == 4  # thin and thick, for each


def test_a_flight_without_a_bank_is_refused():
    with pytest.raises(BadInput, match="no bank of filters"):
        plot_bank(circle_log(1.0))


def test_other_pictures_do_not_show_the_jump():
    log, calm = banked_log(), circle_log()
    np.testing.assert_allclose(position_error(log), position_error(calm), atol=1e-9)
    for made, wanted in zip(plot_flight(log).axes, plot_flight(calm).axes, strict=True):
        for a, b in zip(made.lines, wanted.lines, strict=True):
            np.testing.assert_allclose(a.get_ydata(), b.get_ydata(), atol=1e-6)
    asked = line(plot_path(log).axes[0], "asked")
    np.testing.assert_allclose(asked.get_xdata(), calm.r_d[:, 0], atol=1e-9)
    assert picture(log).axes


@pytest.mark.lab
def test_ghosts_fly_beside_the_truth_and_the_page_says_on_which_filter_it_flies(tmp_path):
    log = banked_log()
    address = replay(log, tmp_path / "bank.html").as_uri() + "#t=1"
    with open_page(address) as page:
        page.wait_for_function("window.replay && window.replay.animator.actions.length > 0")
        at = "replay.object('uavlab/flown/hypothesis {}/aircraft').{}.toArray()"
        assert page.inner_text("#flies") == "flies on gnss"
        assert page.evaluate(at.format(1, "scale"))[0] < 0.01  # nobody believes in the map yet
        page.evaluate("replay.seek(5)")
        assert page.inner_text("#flies") == "flies on map"
        k = int(np.searchsorted(log.t, 5.0 - 1e-9))
        np.testing.assert_allclose(
            page.evaluate(at.format(1, "position")), log.r[k] + 0.01, atol=5e-3
        )
        assert page.evaluate(at.format(1, "scale"))[0] == pytest.approx(1.0)
        gnss = page.evaluate(at.format(0, "position"))
        assert page.errors == []
    drift = 0.2 * (log.t[k] - log.t[len(log.t) // 2 - 1]) / 6.0
    assert np.linalg.norm(gnss - log.r[k]) > drift
