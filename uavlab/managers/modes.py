"""The modes of a safe pilot: what it is about (MRS Sec. 7)."""

from __future__ import annotations

GROUND = "ground"  # it stands, the motors are off, and nothing was flown yet
TAKING_OFF = "taking off"
FLYING = "flying"
GOING_HOME = "going home"  # on the way to where it will land
LANDING = "landing"
LANDED = "landed"  # the motors are off
EMERGENCY = "emergency"  # it lands, with what can still be trusted
FAILSAFE = "failsafe"  # it comes down without knowing where
MANUAL = "manual"  # somebody at a remote control flies
EVADING = "evading"  # the bumper flies

MODES = (
    GROUND, TAKING_OFF, FLYING, GOING_HOME, LANDING, LANDED, EMERGENCY, FAILSAFE, MANUAL, EVADING,
)  # fmt: skip
FREE = frozenset({FLYING, GOING_HOME, MANUAL, EVADING})  # in which the parts fly that are wanted
IN_AIR = FREE | {TAKING_OFF, LANDING, EMERGENCY}  # in which the watch looks
