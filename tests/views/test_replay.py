"""The replay, seen: in a real browser, by its colours, its clock and what it asks the network for."""

import http.server
import re
import threading
from contextlib import contextmanager
from functools import partial

import numpy as np
import pytest
from browser import colours, open_browser, screenshot, watch
from made_flights import EVENTS, LATE, circle_log, told_log

from uavlab.errors import BadInput
from uavlab.flight.log import Log
from uavlab.types import Exit
from uavlab.views import Target, replay, show

GOOD_FRAME = 900  # colours below the captions; about 1,600 in a good frame, 540 in an empty room


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """Pages by name, and the browser that opens them."""
    folder = tmp_path_factory.mktemp("replays")
    whole = circle_log()
    short = circle_log(2.0, exit_=Exit.CRASH, reason="hit the ground at 4.2 m/s at t = 2.00 s")
    deck = Target(whole.t, np.stack([0.5 * whole.t, 0 * whole.t, 0 * whole.t + 0.3], axis=1))
    addresses = {
        "whole": replay(whole, folder / "whole.html"),
        "crash": replay({"mine": short, "reference": whole}, folder / "crash.html"),
        "told": replay(told_log(), folder / "told.html"),
        "bare": replay(unrecorded(whole), folder / "bare.html", target=deck),
    }
    with open_browser() as browser:

        @contextmanager
        def opened(name, at="", server=None, offline=True):
            context = browser.new_context(
                viewport={"width": 760, "height": 430}, offline=offline and server is None
            )
            page = context.new_page()
            watch(page)
            page.goto((f"{server}/{name}.html" if server else addresses[name].as_uri()) + at)
            page.wait_for_function("window.replay && window.replay.animator.actions.length > 0")
            page.wait_for_timeout(300)
            yield page
            context.close()

        opened.folder, opened.browser = folder, browser
        yield opened


def scene(page):
    """What is seen below the captions and above the bar."""
    return screenshot(page)[120:390]


def unrecorded(log: Log) -> Log:
    """A flight of which only the true pose is known, as from a real log."""
    unknown = {
        name: np.full_like(getattr(log, name), np.nan)
        for name in ("r_e", "v_e", "R_e", "r_d", "v_d", "a_d", "heading_d", "wind", "f_d", "omega")
    }
    return log._replace(
        **unknown, rotors=np.zeros((len(log.t), 0)), meta={"scenario": "a real one"}
    )


@contextmanager
def served(folder):
    """A plain web server on loopback."""
    handler = partial(http.server.SimpleHTTPRequestHandler, directory=str(folder))
    handler.log_message = lambda *_: None
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.02,), daemon=True)
        thread.start()
        yield f"http://127.0.0.1:{server.server_address[1]}"
        server.shutdown()
        thread.join()


@pytest.mark.lab
@pytest.mark.parametrize("name", ["whole", "crash", "bare"])
def test_a_replay_is_never_blank_and_moves(pages, name):
    with pages(name, "#t=0.4") as page:
        early = scene(page)
        page.evaluate("replay.seek(1.6)")
        page.wait_for_timeout(300)
        late = scene(page)
    assert colours(early) > GOOD_FRAME
    assert colours(late) > GOOD_FRAME
    assert (early != late).any(axis=2).sum() > 500


@pytest.mark.lab
def test_a_room_without_its_scene_counts_as_blank(pages):
    with pages("whole", "#t=0.4") as page:
        page.evaluate(
            "replay.viewer.scene_tree.find(['uavlab']).object.visible = false; replay.seek(0.4)"
        )
        page.wait_for_timeout(300)
        assert colours(scene(page)) < GOOD_FRAME


@pytest.mark.lab
def test_it_plays_by_itself_pauses_on_a_click_and_obeys_the_speed(pages):
    with pages("whole") as page:
        assert advance(page) > 0.2
        page.click("#play")
        assert advance(page) == 0.0
        assert page.inner_text("#play") == "Play"
        page.select_option("#speed", "0.25")
        page.evaluate("replay.seek(0)")
        page.click("#play")
        slow = advance(page)
        page.select_option("#speed", "4")
        page.evaluate("replay.seek(0)")
        fast = advance(page)
    assert slow < 0.4
    assert fast > 6 * slow


def advance(page) -> float:
    """How far the replay's time goes in half a second [s]."""
    before = page.evaluate("replay.t")
    page.wait_for_timeout(500)
    return page.evaluate("replay.t") - before


@pytest.mark.lab
def test_the_slider_brings_the_aircraft_to_where_it_was(pages):
    log = circle_log()
    with pages("whole", "#t=0") as page:
        page.eval_on_selector(
            "#time", "s => { s.value = 4.0; s.dispatchEvent(new Event('input')); }"
        )
        got = page.evaluate("replay.object('uavlab/flown/aircraft').position.toArray()")
        turn = page.evaluate("replay.object('uavlab/flown/aircraft').quaternion.toArray()")
    from scipy.spatial.transform import Rotation

    k = int(np.searchsorted(log.t, 4.0 - 1e-9))
    np.testing.assert_allclose(got, log.r[k], atol=5e-3)
    np.testing.assert_allclose(Rotation.from_quat(turn).as_matrix(), log.R[k], atol=5e-3)


@pytest.mark.lab
def test_a_flight_that_crashed_stays_where_it_ended_and_says_why(pages):
    with pages("crash", "#t=5.5") as page:
        got = page.evaluate("replay.object('uavlab/mine/aircraft').position.toArray()")
        said = page.inner_text("#captions .bad")
    np.testing.assert_allclose(got, circle_log(2.0).r[-1], atol=1e-3)
    assert "CRASH: hit the ground at 4.2 m/s" in said


@pytest.mark.lab
@pytest.mark.parametrize("over", ["file", "http"])
def test_it_opens_from_the_disk_and_over_http_and_asks_nobody_else(pages, over):
    if over == "file":
        with pages("whole", "#t=1") as page:
            asked, errors = page.requests, page.errors
        here = pages.folder.as_uri()
    else:
        with served(pages.folder) as here, pages("whole", "#t=1", server=here) as page:
            asked, errors = page.requests, page.errors
    assert asked == [f"{here}/whole.html#t=1", f"{here}/meshcat.js"] or asked == [
        f"{here}/whole.html",
        f"{here}/meshcat.js",
    ]
    assert errors == []


@pytest.mark.lab
def test_without_its_viewer_the_page_says_what_is_missing(pages, tmp_path):
    address = replay(circle_log(1.0), tmp_path / "alone.html").as_uri()
    (tmp_path / "meshcat.js").unlink()
    with pages.browser.new_page() as page:
        page.goto(address)
        page.wait_for_selector("#trouble p")
        assert "meshcat.js" in page.inner_text("#trouble")


@pytest.mark.lab
def test_a_page_that_stands_alone_runs_in_the_sandbox_of_a_notebook_server(pages, tmp_path):
    replay(circle_log(1.0), tmp_path / "alone.html", alone=True)
    (tmp_path / "notebook.html").write_text(
        '<iframe src="alone.html" width="700" height="400" sandbox="allow-scripts"></iframe>'
    )
    with served(tmp_path) as here, pages.browser.new_page() as page:
        watch(page)
        page.goto(f"{here}/notebook.html")
        page.frames[1].wait_for_function("window.replay")
        page.wait_for_timeout(500)
        assert colours(screenshot(page)[120:360]) > GOOD_FRAME
        assert not [r for r in page.requests if "meshcat" in r]


@pytest.mark.lab
def test_follow_keeps_the_aircraft_in_the_middle_and_the_eye_at_its_distance(pages):
    with pages("whole", "#t=1") as page:
        gap = "replay.viewer.camera.position.distanceTo(replay.viewer.controls.target)"
        before = page.evaluate(gap)
        page.check("#follow")
        page.evaluate("replay.seek(3)")
        x, y, z = page.evaluate("replay.object('uavlab/flown/aircraft').position.toArray()")
        np.testing.assert_allclose(
            page.evaluate("replay.viewer.controls.target.toArray()"), [x, z, -y], atol=1e-6
        )
        assert page.evaluate(gap) == pytest.approx(before, rel=1e-6)


@pytest.mark.lab
def test_a_name_with_markup_is_shown_as_text_and_never_run(pages, tmp_path):
    evil = "<img src=x onerror=window.hit=1></script><script>window.hit=1</script>"
    log = circle_log(1.0, scenario=evil, provenance={evil: evil}, note=evil)
    with pages.browser.new_page() as page:
        page.goto(replay(log, tmp_path / "evil.html").as_uri())
        page.wait_for_function("window.replay")
        assert page.evaluate("window.hit") is None
        assert evil in page.inner_text("#captions")


# A flight with a story ---------------------------------------------------------------------------------


@pytest.mark.lab
def test_the_caption_says_who_flies_and_what_happened_last_and_the_end_says_why(pages):
    with pages("told", "#t=2.2") as page:
        said = page.inner_text("#story")
        for words in ("flying", "SpeedTracker", "GeometricController", "slow"):
            assert words in said
        assert "2.0 s controller GeometricController: taken over" in " ".join(said.split())
        assert page.is_hidden("#ending")
        page.evaluate("replay.seek(4.2)")
        said = page.inner_text("#story")
        assert "emergency" in said
        assert "lost gnss; motor 2 0.55" in said
        assert f"4.0 s safety: control error: {LATE}" in said
        page.evaluate("replay.seek(5.99)")
        assert "LANDED" in page.inner_text("#ending")
        assert LATE in page.inner_text("#ending")
        assert page.errors == []


@pytest.mark.lab
def test_the_strip_has_the_bands_of_the_modes_and_a_click_on_a_tick_jumps_to_its_event(pages):
    with pages("told", "#t=0") as page:
        slider = page.locator("#strip").bounding_box()
        bands = page.eval_on_selector_all(
            "#strip .band", "all => all.map((x) => [x.offsetLeft, Number(x.dataset.t)])"
        )
        wanted = [t for t, kind, *_ in EVENTS if kind == "mode"]
        assert [t for _, t in bands] == wanted
        scale = slider["width"] / told_log().t[-1]
        np.testing.assert_allclose([x for x, _ in bands], scale * np.array(wanted), atol=1.0)
        tick = page.locator("#strip .tick[data-t='4']")
        tick.hover()
        assert LATE in page.inner_text("#tip")
        tick.click()
        assert page.evaluate("replay.t") == 4.0
        assert not page.evaluate("replay.playing")
        page.locator("#strip .fault").first.click(position={"x": 2, "y": 2})
        assert page.evaluate("replay.t") == pytest.approx(3.2)


@pytest.mark.lab
def test_a_mark_stands_where_safety_stepped_in_from_then_on(pages):
    mark = "replay.object(replay.page.marks.at(-2)[1])"  # then the tracker took over
    with pages("told", "#t=3.9") as page:
        assert not page.evaluate(f"{mark}.visible")
        page.evaluate("replay.seek(4.0)")
        assert page.evaluate(f"{mark}.visible")
        at = page.evaluate(f"{mark}.position.toArray()")
    np.testing.assert_allclose(at, told_log().r[400], atol=1e-3)


@pytest.mark.lab
def test_a_flight_without_a_story_has_no_strip_and_no_caption_of_it(pages):
    with pages("whole", "#t=5.99") as page:
        for part in ("#strip", "#ending", "#story", "#tip"):
            assert page.is_hidden(part)


# Without a browser -----------------------------------------------------------------------------------


def test_the_same_flight_gives_the_same_page(tmp_path):
    a, b = (replay(circle_log(1.0), tmp_path / f"{k}.html").read_bytes() for k in "ab")
    assert a == b


def test_a_page_is_small_and_shares_one_viewer(tmp_path):
    pages = [replay(circle_log(20.0), tmp_path / f"{k}.html") for k in range(2)]
    assert all(page.stat().st_size < 200_000 for page in pages)
    assert [p.name for p in tmp_path.iterdir() if p.suffix == ".js"] == ["meshcat.js"]


def test_a_flight_cut_by_nan_is_replayed_up_to_there(tmp_path):
    log = circle_log(2.0, exit_=Exit.NAN)
    log.r[120:] = np.nan
    assert replay(log, tmp_path / "nan.html").exists()


def test_a_flight_without_one_finite_pose_is_refused(tmp_path):
    log = circle_log(1.0)
    log.r[:] = np.nan
    with pytest.raises(BadInput, match="nothing to replay"):
        replay(log, tmp_path / "none.html")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("nothing", [[], {}])
def test_no_flight_at_all_is_refused(nothing, tmp_path):
    with pytest.raises(BadInput, match="no flight"):
        replay(nothing, tmp_path / "none.html")


def test_what_is_not_a_log_is_named(tmp_path):
    with pytest.raises(BadInput, match="'flight 2' is a int"):
        replay([circle_log(1.0), 3], tmp_path / "none.html")


def test_a_target_of_the_wrong_shape_is_refused(tmp_path):
    with pytest.raises(BadInput, match="target"):
        replay(
            circle_log(1.0), tmp_path / "x.html", target=Target(np.arange(3.0), np.zeros((2, 3)))
        )


def test_a_notebook_gets_a_frame_by_relative_path_and_a_picture(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shown = show(circle_log(1.0, exit_=Exit.TILT))
    text = shown._repr_html_()
    address = re.search(r'<iframe src="([^"]+)"', text).group(1)
    assert address.startswith("replays/circle-")
    assert (tmp_path / address).exists()
    assert (tmp_path / address).with_suffix(".png").read_bytes() == shown.png
    assert [p.suffix for p in (tmp_path / "replays").iterdir() if p.suffix == ".js"] == []
    assert text.index("<iframe") < text.index("data:image/png;base64,")
