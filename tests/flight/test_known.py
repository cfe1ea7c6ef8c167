"""Parts that go by a name: a lab's, uavlab's own, and those of packages that uavlab knows nothing of."""

import importlib
import os
import subprocess
import sys
from types import SimpleNamespace

import pytest

import uavlab
from uavlab.__main__ import main
from uavlab.errors import BadInput, UnknownName
from uavlab.flight import known
from uavlab.flight.fill import fill, stack
from uavlab.flight.scenario import Swap
from uavlab.flight.slot import with_slots
from uavlab.parts.controllers import TiltAxis
from uavlab.parts.failsafe import Failsafe
from uavlab.plant import load_airframe

MODULE = '''
"""Somebody's parts."""
from uavlab.parts.controllers import TiltAxis
from uavlab.parts.estimators import AlphaBetaGamma
from uavlab.parts.missions import Waypoints
from uavlab.parts.trackers import CommandFilter


class Quick(TiltAxis):
    """A law of theirs."""


class Smooth(CommandFilter):
    """A tracker of theirs."""


class Seen(AlphaBetaGamma):
    """An estimator of theirs."""


class Up(Waypoints):
    """A mission of theirs."""

    def __init__(self):
        super().__init__(((0.0, (0.0, 0.0, 3.0), 0.0),))


class Greedy(TiltAxis):
    def __init__(self, mass, colour):
        super().__init__(mass)


class Moody(CommandFilter):
    def __init__(self):
        raise OSError("not today")


class Slotless:
    pass


class Half:
    slot = "tracker"

    def init(self, estimate, last):
        return None


number = 3
'''


@pytest.fixture
def package(tmp_path, monkeypatch):
    """Put a package where Python finds it: a module, and the folder that pip leaves beside it."""
    modules = set(sys.modules)

    def installed(name, version="1.0", module=MODULE, **points):
        stem = name.replace("-", "_")
        (tmp_path / f"{stem}.py").write_text(module)
        info = tmp_path / f"{stem}-{version}.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n")
        lines = [f"{key} = {stem}:{value}" for key, value in points.items()]
        (info / "entry_points.txt").write_text("\n".join(["[uavlab.parts]", *lines]) + "\n")
        importlib.invalidate_caches()
        return tmp_path

    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.chdir(tmp_path)
    yield installed
    for name in set(sys.modules) - modules:
        if str(getattr(sys.modules[name], "__file__", "")).startswith(str(tmp_path)):
            del sys.modules[name]


def hover(*swaps):
    return uavlab.scenarios.load("hover")._replace(duration=0.3, swaps=swaps)


# What comes with uavlab -------------------------------------------------------------------------------


@pytest.mark.parametrize("name", known.BUILT_IN)
def test_every_part_that_comes_with_uavlab_goes_by_its_name_and_is_told_what_it_asks_for(name):
    slot = known.slot_of(name)
    mind = stack("T650", name)
    part = getattr(mind, slot)
    assert type(part).__name__ == name
    assert getattr(part, "mass", 3.5) == 3.5
    log = uavlab.fly(hover()._replace(airframe="T650", duration=0.05), mind)
    assert log.exit.name == "DONE"


def test_a_part_that_asks_for_the_thrust_curve_gets_that_of_the_airframe():
    part = stack("F450", "Failsafe").controller
    airframe = load_airframe("F450")
    assert isinstance(part, Failsafe)
    assert tuple(part.curve) == (airframe.a_t, airframe.b_t)


def test_where_a_part_by_name_comes_from_is_kept():
    assert fill("LineTracker").provenance == {"LineTracker": "uavlab"}
    assert set(fill("HeadingController", mass=1.0).provenance.values()) == {"reference"}


def test_a_class_of_a_notebook_goes_by_its_name_and_before_all_others():
    class Own(TiltAxis):
        pass

    made = stack("F450", "Own", mine={"Own": Own})
    assert isinstance(made.controller, Own)
    assert made.controller.mass == 1.7
    assert isinstance(fill("TiltAxis", {"TiltAxis": Own}, mass=1.0).part, Own)


@pytest.mark.parametrize(
    "words", [("--tracker", "LineTracker"), ("--tracker", "SpeedTracker"),
              ("--controller", "TiltAxis"), ("--estimator", "BankEstimator")],
)  # fmt: skip
def test_the_command_line_flies_parts_of_uavlab_by_name(words, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("uavlab.commands.fly.write", lambda log, out: None)
    assert main(["fly", "step", *words, "--duration", "1.2", "--out", str(tmp_path / "x")]) == 0
    assert "DONE" in capsys.readouterr().out


def test_the_bank_by_its_name_flies_where_there_are_only_cameras():
    scenario = uavlab.scenarios.load("step")._replace(duration=4.0)
    log = uavlab.fly(scenario, stack(scenario.airframe, "BankEstimator"))
    assert log.worlds.names[log.worlds.flies[-1]] == "mocap"
    assert abs(log.r_e - log.r).max() < 0.2


def test_a_part_in_the_wrong_place_is_told_where_it_belongs(capsys):
    assert main(["fly", "hover", "--controller", "LineTracker"]) == 2
    assert "LineTracker is a tracker; give it as --tracker LineTracker" in capsys.readouterr().err
    assert main(["fly", "hover", "--tracker", "BankEstimator"]) == 2
    assert "is an estimator; give it as --estimator" in capsys.readouterr().err


# What other packages bring ----------------------------------------------------------------------------


def test_a_part_of_another_package_flies_by_its_name_and_the_log_says_whose_it_is(package):
    package("their-parts", Quick="Quick", Smooth="Smooth", Seen="Seen")
    mind = stack("F450", "Quick", "Smooth", "Seen")
    assert mind.controller.mass == 1.7
    assert mind.provenance == dict.fromkeys(("Quick", "Smooth", "Seen"), "their-parts 1.0")
    assert uavlab.fly(hover(), mind).exit.name == "DONE"


def test_parts_of_another_package_take_over_in_mid_flight(package):
    package("their-parts", Quick="Quick", Smooth="Smooth", Seen="Seen")
    scenario = hover(
        Swap(0.1, "controller", "Quick"), Swap(0.15, "tracker", "Smooth"), Swap(0.2, "estimator", "Seen")
    )  # fmt: skip
    log = uavlab.fly(scenario, with_slots(scenario, stack("F450")))
    told = {x[2]: x[3] for x in log.meta["swaps"][3:]}
    assert told == dict.fromkeys(("Quick", "Smooth", "Seen"), "taken over")
    assert log.meta["provenance"]["Quick.Quick"] == "their-parts 1.0"


def test_nothing_of_another_package_is_imported_before_it_is_asked_for(package):
    package("their-parts", module="raise RuntimeError('imported')", Quick="Quick")
    assert "Quick" in known.names()
    assert stack("F450", "LineTracker").tracker is not None
    assert "their_parts" not in sys.modules


def test_the_command_line_knows_the_parts_of_another_package(package):
    folder = package("their-parts", Quick="Quick", Smooth="Smooth", Seen="Seen", Up="Up")

    def command(*words):
        return subprocess.run(
            [sys.executable, "-m", "uavlab", *words], capture_output=True, text=True, timeout=120,
            check=False, env={**os.environ, "PYTHONPATH": str(folder), "COLUMNS": "200"},
        )  # fmt: skip

    listed = command("list", "parts").stdout
    assert "Quick" in listed
    assert "their-parts 1.0 A law of theirs." in " ".join(listed.split())
    words = [
        "--controller",
        "Quick",
        "--tracker",
        "Smooth",
        "--estimator",
        "Seen",
        "--mission",
        "Up",
    ]
    flown = command("fly", "hover", *words, "--duration", "0.3", "--out", "theirs")
    assert flown.returncode == 0, flown.stderr
    assert "Quick=their-parts 1.0" in flown.stdout
    assert uavlab.load_log("theirs/log.npz").r_d[-1, 2] > 2.001  # the mission goes up


# What is broken ---------------------------------------------------------------------------------------

BROKEN = [
    ("Slotless", "has slot None; write slot = .* one of estimator, tracker, controller, mission"),
    ("number", "is 3, no class; let it name the class itself"),
    ("Missing", "cannot be loaded: AttributeError: .*Missing.* Mend that package, or uninstall it"),
    ("Half", "has no step and no reframe; see uavlab.interfaces for what a tracker does"),
]


@pytest.mark.parametrize(("value", "said"), BROKEN)
def test_a_broken_entry_point_is_told_by_package_and_name_with_cause_and_cure(package, value, said):
    package("their-parts", Broken=value)
    where = f"entry point Broken = their_parts:{value} of package their-parts 1.0 "
    with pytest.raises(BadInput, match=where + said):
        fill("Broken")
    with pytest.raises(BadInput, match=said):
        stack("F450", "Broken")


@pytest.mark.parametrize(
    ("module", "said"),
    [
        ("import nowhere_to_be_found", "ModuleNotFoundError: No module named 'nowhere_to_be_found'"),
        ("1/0", "ZeroDivisionError"),
        ("def (", "SyntaxError"),
        ("raise SystemExit(3)", "SystemExit: 3"),
    ],
)  # fmt: skip
def test_a_package_that_cannot_be_imported_is_told_why_and_the_command_line_ends_in_one_line(
    package, capsys, module, said
):
    package("their-parts", module=module, Quick="Quick")
    assert main(["fly", "hover", "--controller", "Quick"]) == 2
    told = capsys.readouterr().err
    assert "of package their-parts 1.0 cannot be loaded: " in told
    assert said in told
    assert told.count("\n") == 1


def test_a_name_that_is_taken_is_refused_whoever_has_it(package):
    package("their-parts", Quick="Quick", TiltAxis="Quick", MpcTracker="Smooth")
    package("other-parts", Quick="Quick")
    for name in ("TiltAxis", "MpcTracker"):
        with pytest.raises(BadInput, match=rf"{name} = .* belongs to uavlab itself, too. Give the"):
            fill(name, mass=1.0)
    both = "entry point Quick = their_parts:Quick of package their-parts 1.0.*belongs to other-parts 1.0"
    with pytest.raises(BadInput, match=both):
        fill("Quick", mass=1.0)


def test_a_part_that_cannot_be_made_is_told_with_its_package(package):
    package("their-parts", Greedy="Greedy", Moody="Moody")
    with pytest.raises(BadInput, match=r"Greedy, from their-parts 1.0: Greedy takes mass, colour;"):
        stack("F450", "Greedy")
    with pytest.raises(
        BadInput, match=r"Moody, from their-parts 1.0, cannot be made: OSError: not"
    ):
        stack("F450", "Moody")


def test_a_broken_package_does_not_break_flights_that_do_not_use_it(package, capsys):
    folder = package("their-parts", module="1/0", Quick="Quick", TiltAxis="Quick")
    nobody = folder / "nobody-1.dist-info"
    nobody.mkdir()
    (nobody / "entry_points.txt").write_text("[uavlab.parts]\nno equals sign here\n")
    importlib.invalidate_caches()
    assert uavlab.fly(hover(), stack("F450", "LineTracker", "MpcController")).exit.name == "DONE"
    assert main(["list", "parts"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "broken their-parts 1.0" in said
    assert "ZeroDivisionError" in said
    assert "belongs to uavlab itself" in said


def test_a_swap_to_a_broken_part_does_not_take_off(package):
    package("their-parts", module="1/0", Quick="Quick")
    scenario = hover(Swap(0.1, "controller", "Quick"))
    with pytest.raises(
        BadInput, match=r"scenario 'hover', swaps of the controller: entry point Quick"
    ):
        with_slots(scenario, stack("F450"))


def test_a_name_that_nobody_has_is_answered_with_the_near_one_of_another_package(package):
    package("their-parts", QuickController="Quick")
    with pytest.raises(UnknownName, match="Did you mean 'QuickController'"):
        fill("QuickControler")


def test_a_package_that_says_nothing_of_itself_still_has_a_name():
    assert known.package(SimpleNamespace(dist=None)) == "a package without a name"
