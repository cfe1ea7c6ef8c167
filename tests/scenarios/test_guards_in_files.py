"""Safety area, no-fly zones, obstacles and faults in a scenario's file: what is said there, and what may not be."""

from math import inf

import numpy as np
import pytest

from uavlab.errors import BadInput
from uavlab.flight.fault import Fault
from uavlab.plant.obstacles import Obstacle
from uavlab.scenarios.files import load_file

LEAST = 'airframe = "F450"\nduration = 1.0\n[mission]\nkind = "waypoints"\nstops = [{ t = 0.0, r = [0, 0, 2] }]\n'
START = "[start]\nr = [0, 0, 2]\n"
AREA = "[area]\nborder = [[-9, -9], [9, -9], [9, 9], [-9, 9]]\nlow = 1\nhigh = 20.0\nmargin = 0.5\n"
ZONE = '[[no_fly]]\nname = "tower"\nborder = [[3, 3], [5, 3], [5, 5]]\nlow = 0\nhigh = 12\n'
POLE = "[[obstacle]]\nx = 2\ny = 1.5\nradius = 0.3\nheight = 5\n"
FAULT = '[[fault]]\nkind = "jump"\nt = 0.5\nuntil = 0.8\nwhat = "mocap"\nvalue = [1, 0, 0]\n'
WHOLE = LEAST + START + AREA + ZONE + POLE + FAULT


def loaded(tmp_path, text: str):
    path = tmp_path / "mine.toml"
    path.write_text(text, encoding="utf-8")
    return load_file(path)


def test_what_a_file_says_of_places_is_what_flies(tmp_path):
    scenario = loaded(tmp_path, WHOLE)
    area = scenario.area
    assert area is not None
    assert (area.low, area.high, area.margin, area.world) == (1.0, 20.0, 0.5, "")
    np.testing.assert_array_equal(area.border, [[-9, -9], [9, -9], [9, 9], [-9, 9]])
    (zone,) = area.no_fly
    assert (zone.name, zone.low, zone.high) == ("tower", 0.0, 12.0)
    assert scenario.obstacles == (Obstacle(2.0, 1.5, 0.3, 5.0),)


def test_what_a_file_leaves_out_is_not_there(tmp_path):
    scenario = loaded(tmp_path, LEAST)
    assert (scenario.area, scenario.obstacles, scenario.faults) == (None, (), ())
    (zone,) = loaded(tmp_path, LEAST + START + AREA + ZONE.split("low")[0]).area.no_fly
    assert (zone.low, zone.high) == (-inf, inf)


def test_every_kind_of_fault_can_be_written(tmp_path):
    text = LEAST + FAULT + (
        '[[fault]]\nkind = "lost"\nt = 1\nwhat = "imu"\n'
        '[[fault]]\nkind = "motor"\nt = 1\nwhat = 2\nvalue = 0.5\n'
        '[[fault]]\nkind = "part"\nt = 1\nwhat = "controller"\nvalue = "nan"\n'
        '[[fault]]\nkind = "link"\nt = 1\nuntil = 2\n'
    )  # fmt: skip
    jump, *others = loaded(tmp_path, text).faults
    assert jump[:4] == ("jump", 0.5, 0.8, "mocap")
    np.testing.assert_array_equal(jump.value, (1, 0, 0))
    assert others == [
        Fault("lost", 1.0, inf, "imu"),
        Fault("motor", 1.0, inf, "2", 0.5),
        Fault("part", 1.0, inf, "controller", "nan"),
        Fault("link", 1.0, 2.0),
    ]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("[area]", "[[area]]"), r"area is \[\{.*; write a table \[area\]"),
        (("margin =", "marginn ="), r"no key of area named 'marginn'. Did you mean 'margin'"),
        (("low = 1\n", ""), r"area.low is missing; add it"),
        (("low = 1\n", "low = 30\n"), r"area.low is 30 m and high is 20 m; low must be below high"),
        (("high = 20.0", 'high = "sky"'), r"area.high is 'sky'; it must be a finite number"),
        (("margin = 0.5", "margin = -1"), r"area.margin is -1 m; it must be ≥ 0"),
        (("margin = 0.5", "margin = 9"), r"area.margin is 9 m, which leaves nothing of it"),
        (("margin = 0.5", "world = 3"), r"area.world is 3; write a text in quotes"),
        (("[9, 9], [-9, 9]]", "[-9, 9], [9, 9]]"), r"area.border crosses or touches itself \(Self-inter.*in their"),
        (("[9, 9], [-9, 9]]", "[9, 9, 1]]"), r"area.border\[2\] is \[9, 9, 1\]; it must be a corner \[x, y\] in m"),
        (("[9, 9], [-9, 9]]", '[9, "a"]]'), r"area.border\[2\] is 'a'; it must be a finite number"),
        ((", [9, 9], [-9, 9]]", "]"), r"area.border has shape \(2, 2\); it must be \(K, 2\) with K ≥ 3"),
        ((AREA, ""), r"no_fly is there but no area; add a table \[area\]"),
        (("[[no_fly]]", "[no_fly]"), r"no_fly is \{.*; it must be tables \[\[no_fly\]\] with name, border, low, high"),
        (('"tower"', '""'), r"no_fly\[0\]: the name of a no-fly zone is ''; give it one"),
        (("name =", "namee ="), r"no key of no_fly\[0\] named 'namee'. Did you mean 'name'"),
        (("high = 12", "high = -1"), r"no_fly\[0\]: no-fly zone 'tower': low is 0 m and high is -1 m"),
        ((", [5, 5]]", "]"), r"no_fly\[0\]: no-fly zone 'tower': border has shape \(2, 2\)"),
        ((ZONE, ZONE + ZONE), r"no_fly has two zones named 'tower'; rename one"),
        ((START, "[start]\nr = [10, 0, 2]\n"), r"where it starts: the place, \(10.0, 0.0, 2.0\) m, lies 1.5 m outside"),
        (("radius = 0.3\n", ""), r"obstacle\[0\]: radius is missing"),
        (("radius = 0.3", "radius = 0"), r"obstacle\[0\]: radius is 0.0 m; it must be > 0"),
        (("height = 5", "heightt = 5"), r"no key of obstacle\[0\] named 'heightt'. Did you mean 'height'"),
        (("x = 2\ny = 1.5", "x = 0\ny = 0.2"), r"less than the arm of 0.2.* from the obstacle at \(0, 0.2\) m"),
        (('kind = "jump"', 'kind = "jmup"'), r"fault\[0\] \('jmup'\): no kind .* named .jmup.. Did you mean .jump."),
        (("t = 0.5", "t = -1"), r"fault\[0\] \('jump'\): t is -1.0; it must be a time ≥ 0"),
        (("until = 0.8", "until = 0.3"), r"fault\[0\] \('jump'\): until is 0.3 s; it must be later than t = 0.5 s"),
        (('"mocap"', '"gnss"'), r"fault\[0\] \('jump'\): no instrument aboard named 'gnss'.*Known: imu, mocap"),
        (('what = "mocap"', "what = 1.5"), r"fault\[0\].what is 1.5; write a text in quotes"),
        (("value = [1, 0, 0]", "value = [1, 0]"), r"fault\[0\] \('jump'\): value is .*; it must be a number, or 3"),
        (("value = [1, 0, 0]", "value = nan"), r"fault\[0\].value is nan; it must be a finite number"),
        (("until = 0.8", "untl = 0.8"), r"no key of fault\[0\] named 'untl'. Did you mean 'until'"),
        (("[[fault]]", "[fault]"), r"fault is \{.*; it must be tables \[\[fault\]\] with kind, t, until, what, value"),
    ],
)  # fmt: skip
def test_what_a_file_may_not_say_is_refused_by_file_and_key(tmp_path, change, said):
    assert change[0] in WHOLE
    with pytest.raises(BadInput, match=said) as refused:
        loaded(tmp_path, WHOLE.replace(*change))
    assert str(refused.value).startswith("mine.toml: ")
