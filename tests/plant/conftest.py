"""Aircraft for the tests of the world, compiled and as plain Python."""

import sys
from collections.abc import Callable

import pytest

from uavlab.plant import Airframe, CompiledPlant

COMPILED = ("jit", "vectors", "constants", "dynamics", "autopilot", "kernel")


@pytest.fixture
def plain(monkeypatch: pytest.MonkeyPatch) -> None:
    """The compiled rooms as plain Python, for one test."""
    import numba

    import uavlab.plant.kernel  # so that the compiled ones are there to be put back

    monkeypatch.setattr(numba.config, "DISABLE_JIT", 1)
    for name in COMPILED:
        monkeypatch.delitem(sys.modules, f"uavlab.plant.{name}")
        monkeypatch.delattr(uavlab.plant, name)


@pytest.fixture(params=["compiled", "plain"])
def make_plant(request: pytest.FixtureRequest) -> Callable[[Airframe], CompiledPlant]:
    """`CompiledPlant`, with the compiler on and off."""
    if request.param == "plain":
        request.getfixturevalue("plain")
    return CompiledPlant
