"""Flights with a safe pilot, and what their logs tell."""

import numpy as np

import uavlab
from uavlab.experiments.control_flights import KNOWS, Believes, Knows
from uavlab.flight.scenario import Scenario, standing
from uavlab.parts.errands import Errand

AIRFRAME = "T650"


def errand(*steps, start=(0.0, 0.0, 0.0), seconds=40.0, airframe=AIRFRAME, **more):
    """A flight of these steps by an aircraft that knows its state."""
    mission = Errand(steps) if steps else None
    given = {"mission": mission, **more}
    scenario = Scenario(
        "errand", "", airframe, given.pop("mission"), standing(start), seconds, {KNOWS: Knows()}
    )
    return scenario._replace(**given)


def flown(scenario, *parts, seed=0, plant=None, **pilot):
    mind = uavlab.piloted(scenario, *(parts or (Believes(),)), **pilot)
    return uavlab.fly(scenario, mind, seed=seed, plant=plant)


def events(log, *kinds):
    return [tuple(x[1:]) for x in log.meta["events"] if not kinds or x[1] in kinds]


def modes(log):
    return [name for kind, name, _ in events(log, "mode")]


def at(log, kind, name):
    """When it was [s]."""
    return next(t for t, k, n, _ in log.meta["events"] if (k, n) == (kind, name))


def finite(log):
    return all(np.isfinite(getattr(log, k)).all() for k in ("r_d", "v_d", "a_d", "f_d", "omega_d"))
