"""The story of a flight: bands and events read from a log, and drawn where they were told."""

import itertools

import matplotlib.pyplot as plt
import numpy as np
import pytest
from made_flights import (
    AREA,
    ELSEWHERE,
    EVENTS,
    FAULTS,
    LATE,
    banked_log,
    circle_log,
    told_log,
)

from uavlab.commands import fly
from uavlab.errors import BadInput
from uavlab.managers import modes
from uavlab.types import Exit
from uavlab.views import picture, plot_flight, plot_path, plot_story, story, style
from uavlab.views.cast import bounds, frame_of, in_view
from uavlab.views.guards import guards_of, triangles


@pytest.fixture(autouse=True)
def closed():
    """No figure outlives its test."""
    yield
    plt.close("all")


def drawn(figure):
    """All words of a figure."""
    return "\n".join(t.get_text() for t in figure.findobj(plt.Text) if t.get_visible())


# What a log tells ------------------------------------------------------------------------------------


def test_a_band_begins_with_its_event_and_ends_with_the_next_of_its_kind():
    log = told_log()
    modes = [(x.name, x.start) for x in story.bands(log, "mode")]
    assert modes == [(name, t) for t, kind, name, _ in EVENTS if kind == "mode"]
    ends = [x.end for x in story.bands(log, "mode")]
    assert ends == [t for _, t in modes[1:]] + [log.t[-1]]


def test_who_was_refused_never_flew():
    flew = [x.name for x in story.bands(told_log(), "controller")]
    assert flew == ["MpcController", "GeometricController"]


def test_under_a_failsafe_neither_tracker_nor_controller_flies():
    log = told_log(events=[*EVENTS[:7], [2.0, "mode", "failsafe", "lost"]])
    for slot in ("tracker", "controller"):
        assert story.bands(log, slot)[-1] == (2.0, log.t[-1], "Failsafe")
    assert story.bands(log, "limits")[-1].name == "slow"


def test_a_fault_lasts_to_its_end_or_to_that_of_the_flight():
    log = told_log(4.0)
    assert [(x.name, x.start, x.end) for x in story.faults(log)] == [
        ("lost gnss", 3.2, log.t[-1]), ("motor 2 0.55", 3.5, log.t[-1])
    ]  # fmt: skip
    assert story.faults(told_log(3.0)) == []  # none of them had begun


@pytest.mark.parametrize(
    ("fault", "said"),
    [(["motor", 1.0, 2.0, "1", 0.0], "motor 1 0"), (["lost", 1.0, 2.0, "gnss", 0.0], "lost gnss"),
     (["gust", 1.0, 2.0, "", [4.0, 0.0, 0.0]], "gust 4, 0, 0"),
     (["part", 1.0, 2.0, "tracker", "nan"], "part tracker nan")],
)  # fmt: skip
def test_a_fault_is_told_with_its_size_where_it_has_one(fault, said):
    assert [x.name for x in story.faults(told_log(faults=[fault]))] == [said]


def test_of_one_instant_safety_speaks_first_and_its_reason_is_not_said_twice():
    at = [x.sentence for x in story.spoken(told_log()) if x.t == 4.0]
    assert at == [
        f"safety: control error: {LATE}", "mode emergency", "tracker Landoff: taken over"
    ]  # fmt: skip


def test_an_older_log_tells_its_swaps_alone():
    told = [[0.0, "tracker", "a", "first"], [0.4, "tracker", "b", "taken over"]]
    log = circle_log(1.0, swaps=told)
    assert [x.sentence for x in story.news(log)] == ["tracker b: taken over"]
    assert not story.has_modes(log)
    assert story.eventful(log)


def test_a_flight_without_a_story_is_refused():
    with pytest.raises(BadInput, match="no modes"):
        plot_story(circle_log(1.0))


def test_the_pieces_of_a_path_cover_it_and_touch():
    log = told_log()
    pieces = list(story.pieces(log))
    assert pieces[0][0].start == 0
    assert pieces[-1][0].stop == len(log.t)
    for (a, *_), (b, *_) in itertools.pairwise(pieces):
        assert a.stop == b.start + 1
    assert [(mode, color) for _, color, mode in pieces] == [
        (name, style.MODES[name]) for _, kind, name, _ in EVENTS if kind == "mode"
    ]


def test_a_path_is_blue_until_the_first_mode():
    log = told_log(events=[[2.0, "mode", "failsafe", "lost"]])
    assert [(x.start, color) for x, color, _ in story.pieces(log)] == [
        (0, style.FLOWN), (200, style.MODES["failsafe"])
    ]  # fmt: skip


def test_what_is_asked_below_the_ground_does_not_lower_the_floor():
    log = circle_log(2.0)
    log.r_d[150:, 2] = -3.0
    assert bounds({"flown": log})[0][2] == 0.0
    assert frame_of({"flown": log})[0][2] == 0.0
    log.r[:, 2] -= 5.0  # a flight in a valley
    assert bounds({"flown": log})[0][2] == log.r[:, 2].min()


def test_every_mode_of_a_pilot_has_a_colour():
    assert set(style.MODES) == set(modes.MODES)


# Colours ---------------------------------------------------------------------------------------------

# Machado, Oliveira, Fernandes (2009), severity 1.0: linear RGB as it is seen by who lacks one kind of cone
BLIND = {
    "none": np.eye(3),
    "protan": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deutan": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "tritan": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}  # fmt: skip


def lab(color, seen):
    """CIE L*a*b* of ``#rrggbb``, seen through a matrix on linear RGB."""
    c = np.array([int(color[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    linear = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
    to_xyz = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    xyz = to_xyz @ np.clip(seen @ linear, 0, 1) / [0.9505, 1.0, 1.089]
    x, y, z = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


@pytest.mark.parametrize("kind", BLIND)
def test_any_two_modes_are_told_apart_with_any_colour_blindness(kind):
    seen = {name: lab(color, np.asarray(BLIND[kind])) for name, color in style.MODES.items()}
    apart = {(a, b): np.linalg.norm(seen[a] - seen[b]) for a, b in itertools.combinations(seen, 2)}
    assert min(apart.values()) > 12, min(apart, key=apart.get)  # 2.3: just noticeable


@pytest.mark.parametrize(("color", "ink"), [("#F0E442", "#111111"), ("#4B1E7A", "#FFFFFF")])
def test_a_name_is_read_on_its_colour(color, ink):
    assert style.ink(color) == ink


# What is drawn ---------------------------------------------------------------------------------------


def test_the_bands_of_the_plot_are_the_events_of_the_log():
    strip = plot_story(told_log()).axes[0]
    names = [t.get_text() for t in strip.get_yticklabels()]
    assert names == ["events", "mode", "tracker", "controller", "limits", "faults", ""]
    row = {name: k for k, name in enumerate(names) if name}
    bars = [(p.get_y() + p.get_height() / 2, p.get_x(), p.get_width()) for p in strip.patches]
    for kind in ("mode", "tracker", "controller", "limits"):
        made = [(x, x + w) for y, x, w in bars if abs(y - row[kind]) < 0.01]
        wanted = [(x.start, x.end) for x in story.bands(told_log(), kind)]
        np.testing.assert_allclose(made, wanted)
    broken = sorted(x for y, x, _ in bars if y >= row["faults"] - 0.01)
    assert broken == [x[1] for x in FAULTS]


def test_the_plot_says_every_event_in_words_and_numbers_it_on_the_time_axis():
    figure = plot_story(told_log())
    said = drawn(figure)
    for x in story.spoken(told_log()):
        assert x.sentence in said
    numbers = [t for t in figure.axes[0].texts if t.get_text().isdecimal()]
    assert [t.get_position()[0] for t in numbers] == [0.5, 1.5, 2.0, 2.5, 3.0, 4.0, 5.8]


def test_the_plot_draws_the_bound_that_was_crossed_and_the_heights_of_the_area():
    _, height, error, _ = plot_story(told_log()).axes
    assert [t.get_text() for t in error.texts] == ["bound 1.5 m"]
    assert [t.get_text() for t in height.texts] == ["area 0.5 m"]  # 6 m is far above what was flown
    calm = plot_story(told_log(events=EVENTS[:8]))
    assert [t.get_text() for t in calm.axes[2].texts] == []


def test_a_hundred_refusals_do_not_fill_the_page():
    many = [[0.02 * k, "refused", "Reference", f"no {k}"] for k in range(100)]
    figure = plot_story(told_log(events=EVENTS[:6] + many))
    assert figure.get_figheight() < 12
    assert "more" in drawn(figure)


@pytest.mark.parametrize("duration", [0.01, 0.7, 3.0])
def test_a_story_that_ends_early_is_drawn_up_to_there(duration):
    plot_story(told_log(duration, exit_=Exit.CRASH)).canvas.draw()


def test_a_flight_that_landed_is_not_marked_as_one_that_ended_badly():
    for draw, bad in ((picture, "crash"), (plot_path, "crash")):
        assert bad not in drawn(draw(told_log()))
        assert bad in drawn(draw(told_log(exit_=Exit.CRASH)))
    landed, crashed = (plot_flight(told_log(exit_=x)) for x in (Exit.LANDED, Exit.CRASH))
    assert len(crashed.axes[0].lines) == len(landed.axes[0].lines) + 1


# Area, zones, obstacles ------------------------------------------------------------------------------


@pytest.mark.parametrize("draw", [picture, plot_path])
def test_a_picture_names_area_zones_obstacles_and_modes(draw):
    figure = draw(told_log())
    figure.canvas.draw()
    said = drawn(figure)
    for words in ("safety area", "no-fly zone", "obstacle", "taking off", "emergency"):
        assert said.count(words) >= 1
    bare = drawn(draw(circle_log(6.0)))
    assert "area" not in bare
    assert "flown" in bare


def test_the_plan_shows_the_corners_of_the_area_where_they_are():
    top, side = plot_path(told_log()).axes
    corners = [p.get_xy() for p in top.patches if hasattr(p, "get_xy")]
    np.testing.assert_allclose(corners[0][:-1], AREA["border"])
    np.testing.assert_allclose(corners[2][:-1], AREA["no_fly"][1]["border"])
    heights = side.patches[0].get_xy()[:, 1]
    assert (heights.min(), heights.max()) == (AREA["low"], AREA["high"])


@pytest.mark.parametrize("times", [1.6, 1000.0])
def test_an_area_of_any_size_does_not_lose_the_aircraft(times):
    border = (times * np.array(AREA["border"])).tolist()
    flights = {"flown": told_log(area=AREA | {"border": border, "high": 6.0 * times})}
    flown = np.subtract(*bounds(flights)[::-1])
    framed = np.subtract(*in_view(flights)[::-1])
    assert (framed <= flown + 1.5 * flown.max() + 1e-9).all()


def test_walls_that_are_far_away_do_not_widen_the_picture():
    far = {"border": (1000 * np.array(AREA["border"])).tolist(), "low": 0.0, "high": 500.0}
    flights = {"flown": told_log(area=far, obstacles=[[900.0, 0.0, 1.0, 10.0]])}
    np.testing.assert_array_equal(in_view(flights)[1], bounds(flights)[1])
    assert frame_of(flights)[0][2] == 0.0


def test_a_small_area_is_seen_whole_and_a_log_without_one_is_framed_as_ever():
    low, high = in_view({"flown": told_log()})
    assert (low[:2] <= [-6, -7]).all()
    assert (high[:2] >= [7, 7]).all()
    bare = {"flown": circle_log(6.0)}
    np.testing.assert_array_equal(in_view(bare), bounds(bare))
    assert frame_of(bare)[1][0] < 4.0


def test_a_zone_without_an_end_does_not_make_the_picture_endless():
    endless = AREA | {"low": -np.inf, "high": None}
    for area in (AREA, endless):
        assert np.isfinite(guards_of(told_log(area=area)).extents).all()
        assert np.isfinite(frame_of({"flown": told_log(area=area)})).all()


def never_flew(log):
    """A log on whose second hypothesis nobody flew, so that estimate and reference stay as they began."""
    w = log.worlds
    still = w._replace(flies=0 * w.flies, shift_r=0 * w.shift_r, shift_heading=0 * w.shift_heading)
    return log._replace(r_e=log.r + 0.01, worlds=still)


@pytest.mark.parametrize("flew", [True, False])
def test_an_area_of_a_hypothesis_is_drawn_where_its_world_lay(flew):
    def there(x):  # the world of the map: turned by 1 rad, its origin elsewhere
        c, s = np.cos(1.0), np.sin(1.0)
        return np.asarray(x) @ np.array([[c, -s], [s, c]]).T + ELSEWHERE[:2]

    zones = [x | {"border": there(x["border"]).tolist()} for x in AREA["no_fly"]]
    area = AREA | {"border": there(AREA["border"]).tolist(), "low": 1.5, "high": 7.0}
    log = banked_log()
    log = log._replace(meta=log.meta | {"area": area | {"world": "map", "no_fly": zones}})
    top, side = plot_path(log if flew else never_flew(log)).axes
    np.testing.assert_allclose(top.patches[0].get_xy()[:-1], AREA["border"], atol=1e-6)
    np.testing.assert_allclose(top.patches[1].get_xy()[:-1], AREA["no_fly"][0]["border"], atol=1e-6)
    assert side.patches[0].get_xy()[:, 1].min() == pytest.approx(0.5)


@pytest.mark.parametrize("turn", [1, -1])
def test_the_lid_of_a_hollow_zone_covers_it_and_nothing_else(turn):
    border = np.array(AREA["no_fly"][0]["border"], dtype=float)[::turn]  # with a notch of 0.8 m²

    def area(corners):
        x, y = corners.T
        return abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) / 2

    cut = triangles(border)
    assert len(cut) == len(border) - 2
    assert sum(area(border[list(x)]) for x in cut) == pytest.approx(4.0 - 0.8)


# On the command line ---------------------------------------------------------------------------------


def test_a_flight_with_modes_is_printed_event_by_event_and_drawn_as_a_story(tmp_path, capsys):
    fly.show(told_log())
    said = capsys.readouterr().out
    assert f"    4.00 s: safety: control error: {LATE}\n" in said
    assert "    2.50 s: controller tight: refused: its f_d is nan\n" in said
    for log, written in ((told_log(0.8), True), (circle_log(0.8), False)):
        fly.write(log, tmp_path / str(written))
        assert (tmp_path / str(written) / "story.png").exists() == written
