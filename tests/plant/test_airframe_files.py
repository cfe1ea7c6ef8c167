"""Airframes are files in which every number has a unit and a source."""

import tomllib
from pathlib import Path

import numpy as np
import pytest

from uavlab.errors import BadFile, BadInput, UnknownName
from uavlab.plant import airframe_names, load_airframe
from uavlab.plant.load import DATA

F450 = (DATA / "F450.toml").read_text(encoding="utf-8")


@pytest.fixture
def changed(tmp_path: Path):
    """A copy of the F450 in which one piece of text is replaced."""

    def write(old: str, new: str) -> Path:
        assert old in F450
        path = tmp_path / "mine.toml"
        path.write_text(F450.replace(old, new), encoding="utf-8")
        return path

    return write


@pytest.mark.parametrize("name", airframe_names())
def test_every_number_has_a_value_a_unit_and_a_source(name: str):
    table = tomllib.loads((DATA / f"{name}.toml").read_text(encoding="utf-8"))
    for key, entry in table.items():
        assert set(entry) == {"value", "unit", "source"}, key
        assert len(entry["source"]) > 10, key


def test_a_file_of_ones_own_flies_under_its_own_name(changed):
    mine = load_airframe(changed("value = 1.7,", "value = 1.9,"))
    assert (mine.name, mine.m) == ("mine", 1.9)
    np.testing.assert_array_equal(mine.allocation, load_airframe("F450").allocation)


def test_names_are_found_in_lower_case():
    assert load_airframe("mk-quadro").name == "MK-Quadro"


@pytest.mark.parametrize("name", ["F45O", "f45", "T65"])
def test_a_name_with_a_slip_is_answered_with_the_name_that_was_meant(name: str):
    with pytest.raises(UnknownName, match=r"Did you mean 'F450'|Did you mean 'T650'"):
        load_airframe(name)


def test_something_that_is_no_name_is_refused():
    with pytest.raises(UnknownName, match="no airframe named None"):
        load_airframe(None)  # type: ignore[arg-type]


def test_speeds_and_coefficients_are_turned_into_radians_per_second():
    a = load_airframe("F450")
    assert a.speed_max == pytest.approx(9068 * 2 * np.pi / 60)
    assert a.thrust_max == pytest.approx(1.2216e-7 * 9068**2)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("value = 1.7,", "value = -1.7,", r"mine.toml: mass has the value -1.7; allowed .* kg"),
        ("value = 1.7,", "value = nan,", "mass has the value nan"),
        ("value = 1.7,", "value = true,", "mass has the value True"),
        ("value = 1.7,", 'value = "1.7",', "mass has the value '1.7'"),
        ("value = 1.7,", "value = [1, 2],", "mass has the value"),
        ('unit = "kg",', 'unit = "g",', "mass is in 'g'; convert it to 'kg'"),
        ("mass = ", "mess = ", r"mass is missing; write mass = \{ value"),
        ('unit = "kg", source = ', 'unit = "kg", sauce = ', "mass is .*write mass"),
        ("[315, 135, 45, 225]", "315", "angles is 315; a list of all rotors"),
        ("[315, 135, 45, 225]", "[315, 135, 45]", "spins are"),
        ("[-1, -1, 1, 1]", "[-1, -1, 1, 2]", "spins has the value 2"),
        ("[16.7, 16.7, 8.0]", "[16.7, 16.7]", r"rate_gain is \[16.7, 16.7\]; a list of 3"),
    ],
)
def test_a_wrong_number_is_named_with_its_key_value_and_bound(changed, old, new, said):
    with pytest.raises(BadInput, match=said):
        load_airframe(changed(old, new))


def test_a_file_cut_short_is_no_airframe(tmp_path: Path):
    path = tmp_path / "cut.toml"
    path.write_text(F450[:200], encoding="utf-8")
    with pytest.raises(BadFile, match="is not TOML"):
        load_airframe(path)


def test_a_file_of_other_bytes_is_no_airframe(tmp_path: Path):
    path = tmp_path / "bytes.toml"
    path.write_bytes(bytes(range(256)))
    with pytest.raises(BadFile, match="is not TOML"):
        load_airframe(path)


def test_a_file_that_is_not_there_is_named(tmp_path: Path):
    with pytest.raises(BadFile, match="cannot read the airframe"):
        load_airframe(tmp_path / "none.toml")
