"""Numba is optional, late, and keeps its code where it can."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
from aircraft import command, state

import uavlab.plant
from uavlab.plant import CompiledPlant, jit, load_airframe


def run(code: str, **env: str) -> str:
    """What a fresh interpreter prints."""
    root = Path(uavlab.__file__).parents[1]
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        cwd=root,
        env=os.environ | env,
    )
    return done.stdout.strip()


def test_importing_the_plant_does_not_import_numba():
    code = "import sys, uavlab.plant, uavlab.sensors; print('numba' in sys.modules)"
    assert run(code) == "False"


def test_where_numba_is_missing_the_same_world_flies(monkeypatch, plain):
    compiled = CompiledPlant  # imported before: the class itself needs no numba
    monkeypatch.setitem(sys.modules, "numba", None)
    plant = compiled(load_airframe("F450"))
    from uavlab.plant import kernel

    assert kernel.advance.__code__.co_name == "advance"  # a function, not a dispatcher
    world = plant.advance(plant.init(state()), command(20.0))
    assert world.v[2] > 0.0


def test_machine_code_is_kept_in_the_first_folder_that_can_be_written(monkeypatch, tmp_path: Path):
    no_folder = tmp_path / "file"
    no_folder.write_text("")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(no_folder))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "second"))
    folder = jit._cache_folder()
    assert folder.is_dir()
    assert tmp_path / "second" in folder.parents


def test_where_nothing_can_be_written_functions_are_compiled_anew(monkeypatch):
    def nowhere() -> Path:
        raise OSError("read-only")

    monkeypatch.setattr(jit, "_cache_folder", nowhere)
    twice = jit.entry(lambda x: 2 * x)
    assert twice(4) == 8
    assert type(twice).__name__ == "CPUDispatcher"


def test_choosing_a_folder_does_not_change_numbas_own(monkeypatch, tmp_path: Path):
    import numba

    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    before = numba.config.CACHE_DIR
    jit.entry(lambda x: x)
    assert before == numba.config.CACHE_DIR


def test_a_change_of_any_source_is_a_change_of_folder(monkeypatch, tmp_path: Path):
    package = tmp_path / "uavlab" / "plant"
    package.mkdir(parents=True)
    (package / "jit.py").write_text("a")
    (package.parent / "so3.py").write_text("b")
    monkeypatch.setattr(jit, "__file__", str(package / "jit.py"))
    first = jit._digest()
    (package.parent / "so3.py").write_text("c")
    assert jit._digest() != first


def test_many_worlds_need_one_compilation():
    """Read-only, strided or integer arrays must not start the compiler again: it takes seconds."""
    plant = CompiledPlant(load_airframe("F450"))
    hexa = CompiledPlant(load_airframe("F550"))
    plant.advance(plant.init(state()), command(1.0))
    count = len(plant._advance.signatures)  # type: ignore[attr-defined]
    wind = np.zeros(6)[::2]
    wind.setflags(write=False)
    world = plant.advance(plant.init(state((0, 0, 0))), command(1, (1, 2, 3)), wind, 1, 3)
    plant.advance(world, command(1.0), [0, 0, 0], np.float64(0.01))  # type: ignore[arg-type]
    hexa.advance(hexa.init(state()), command(1.0))
    assert len(plant._advance.signatures) == count  # type: ignore[attr-defined]
