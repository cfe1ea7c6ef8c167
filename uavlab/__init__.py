"""uavlab: multirotor flight, estimation and control, to fly with and to learn from.

Fly a named scenario and look at it::

    import uavlab
    log = uavlab.fly(uavlab.scenarios.load("circle"))
    uavlab.views.show(log)
"""

from uavlab import scenarios
from uavlab.exercises import check
from uavlab.flight.fill import fill, stack
from uavlab.flight.fly import fly
from uavlab.flight.log import Log, load_log
from uavlab.flight.metrics import summary
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
    "scenarios",
    "stack",
    "standing",
    "summary",
    "wrap",
]
