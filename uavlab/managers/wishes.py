"""Wishes: which parts, gains and limits are asked for, and whether they may fly (MRS Sec. 7)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from uavlab.errors import UnknownName
from uavlab.gains import GROUPS as GAINS
from uavlab.limits import GROUPS as LIMITS
from uavlab.managers.goals import BUSY
from uavlab.managers.groups import fallback, groups_of, split, why_not
from uavlab.managers.memory import Piloting, noted, refused
from uavlab.managers.modes import EMERGENCY, EVADING, FREE, LANDING, MANUAL
from uavlab.managers.takeover import reserved, tuned
from uavlab.orders import Use
from uavlab.parts.slot import FIRST, TAKEN
from uavlab.types import Estimate

if TYPE_CHECKING:
    from uavlab.managers.pilot import SafePilot

KINDS = {"tracker": "limits", "controller": "gains"}  # and which groups go with them
GROUPS = {
    "limits": tuple(LIMITS),
    "gains": tuple(dict.fromkeys(x for each in GAINS.values() for x in each)),
}
_DEAF = {LANDING, EMERGENCY, MANUAL, EVADING}


def aboard(pilot: SafePilot, kind: str) -> tuple[str, ...]:
    """The groups of "limits" or "gains" of which the pilot has parts."""
    slot = pilot.trackers if kind == "limits" else pilot.controllers
    return groups_of(slot.parts, GROUPS[kind])


def asked_use(pilot: SafePilot, m: Piloting, estimate: Estimate, order: Use) -> Piloting:
    """Another part, other gains or other limits."""
    if order.slot not in {*KINDS, *GROUPS}:
        return refused(m, order, str(UnknownName("slot", order.slot, (*KINDS, *GROUPS))))
    why = BUSY[m.mode] if m.mode in _DEAF else ""
    m, why = (m, why) if why else _wished(pilot, m, estimate, order)
    if why:
        return noted(m, order.slot, order.name, f"refused: {why}")
    if order.slot in GROUPS:
        m = noted(m, order.slot, order.name, TAKEN)
    return tuned(pilot, m, estimate) if m.mode in FREE else m


def _wished(pilot: SafePilot, m: Piloting, estimate: Estimate, order: Use) -> tuple[Piloting, str]:
    """The new wishes, or why they are not granted."""
    kind = order.slot
    if kind in GROUPS:
        why = why_not(pilot.allowed, estimate.world, kind, order.name, aboard(pilot, kind))
        return (m, why) if why else (m._replace(wants=m.wants._replace(**{kind: order.name})), "")
    parts = (pilot.trackers if kind == "tracker" else pilot.controllers).parts
    groups = KINDS[kind]
    names = {split(x, GROUPS[groups])[0] for x in parts if not reserved(x)}
    base, group = split(order.name, GROUPS[groups])
    if base not in names:
        return m, str(UnknownName(kind, order.name, names))
    change = {kind: base}
    if group:
        why = why_not(pilot.allowed, estimate.world, groups, group, aboard(pilot, groups))
        if why:
            return m, why
        change[groups] = group
    return m._replace(wants=m.wants._replace(**change)), ""


def in_world(pilot: SafePilot, m: Piloting, estimate: Estimate, first: bool = False) -> Piloting:
    """Groups that are not allowed in the world of the estimate give way to its default ones."""
    for kind in GROUPS:
        group = getattr(m.wants, kind)
        now = fallback(pilot.allowed, estimate.world, kind, group, aboard(pilot, kind))
        if now != group:
            m = noted(m, kind, now, TAKEN)._replace(wants=m.wants._replace(**{kind: now}))
        elif first:
            m = noted(m, kind, group, FIRST)
    if first:
        return m
    m = m._replace(switched=True)
    return tuned(pilot, m, estimate) if m.mode in FREE else m
