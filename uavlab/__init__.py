"""uavlab: multirotor flight, estimation and control, to fly with and to learn from.

Fly a named scenario and look at it::

    import uavlab
    log = uavlab.fly(uavlab.scenarios.load("circle"))
    uavlab.views.show(log)

The names below are imported when they are first used, so that ``import uavlab`` is quick.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from uavlab import scenarios, views
    from uavlab.exercises import check
    from uavlab.flight.fill import fill, stack
    from uavlab.flight.fly import fly
    from uavlab.flight.log import Log, load_log
    from uavlab.flight.metrics import summary
    from uavlab.flight.piloted import piloted
    from uavlab.flight.scenario import Scenario, standing
    from uavlab.frames import Shift, heading, moved, wrap
    from uavlab.interfaces import Stack
    from uavlab.types import Command, Estimate, Exit, Reference, State, StateRate

__version__ = "0.1.0"

__all__ = [
    "Command",
    "Estimate",
    "Exit",
    "Log",
    "Reference",
    "Scenario",
    "Shift",
    "Stack",
    "State",
    "StateRate",
    "check",
    "fill",
    "fly",
    "heading",
    "load_log",
    "moved",
    "piloted",
    "scenarios",
    "stack",
    "standing",
    "summary",
    "views",
    "wrap",
]

_HOMES = {
    "check": "exercises",
    "fill": "flight.fill",
    "stack": "flight.fill",
    "fly": "flight.fly",
    "Log": "flight.log",
    "load_log": "flight.log",
    "summary": "flight.metrics",
    "piloted": "flight.piloted",
    "Scenario": "flight.scenario",
    "standing": "flight.scenario",
    "Stack": "interfaces",
    **dict.fromkeys(("Shift", "heading", "moved", "wrap"), "frames"),
    **dict.fromkeys(("Command", "Estimate", "Exit", "Reference", "State", "StateRate"), "types"),
}


def __getattr__(name: str) -> Any:
    """Import a name of `__all__` from its home."""
    if name in _HOMES:
        return getattr(importlib.import_module(f"uavlab.{_HOMES[name]}"), name)
    if name in __all__:
        return importlib.import_module(f"uavlab.{name}")
    raise AttributeError(f"module 'uavlab' has no attribute {name!r}")


def __dir__() -> list[str]:
    """The public names."""
    return __all__
