"""The fault campaign: whatever breaks, a flight ends in a state that can be named, and nobody is hurt (MRS Sec. 7.2).

A random aircraft flies a random errand in a random area and wind, on cameras or on a bank of filters, under the safe
pilot, while one to three random things break: `uavlab.campaigns.drawn` and `.breaks` say from what is drawn. What a
flight must keep to is in `uavlab.campaigns.judge`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np

from uavlab.campaigns.breaks import SIZES, label
from uavlab.campaigns.drawn import RANGES, Drawn, drawn
from uavlab.campaigns.judge import ON_ITS_WAY, modes, touch_down, violations
from uavlab.campaigns.page import Shown
from uavlab.campaigns.spec import Campaign
from uavlab.campaigns.summary import Summary, counted
from uavlab.campaigns.table import Row
from uavlab.flight.fault import KINDS
from uavlab.flight.fill import fill
from uavlab.flight.fly import fly as flown
from uavlab.flight.log import Log
from uavlab.flight.piloted import piloted
from uavlab.parts.bank import BankEstimator, chosen
from uavlab.parts.estimator_slot import EstimatorSlot
from uavlab.parts.estimators import AlphaBetaGamma
from uavlab.parts.priority import FixedPriority
from uavlab.parts.vetted import Vetted
from uavlab.types import Exit

NAME = "faults"
HARD = 10  # flights with the hardest touch-downs are shown


def log(seed: int) -> Log:
    """The flight of a seed."""
    flight = drawn(seed)
    scenario, mind = flight.scenario, piloted(flight.scenario, _estimator(flight))
    log = flown(scenario, mind, seed=seed)
    if log.exit is Exit.DONE and modes(log)[-1][1] in ON_ITS_WAY:  # the same again, to its end
        longer = scenario._replace(duration=scenario.duration + RANGES.after)
        log = flown(longer, mind, seed=seed)
    return log


def _estimator(flight: Drawn) -> EstimatorSlot:
    """A bank of filters, or an observer; alone, or with a spare one that is kept warm."""
    parts: dict[str, Any] = {"observer": AlphaBetaGamma()}
    if flight.members:
        first = ((0.0, flight.members[0]),)
        bank = fill(BankEstimator, setup=chosen(*flight.members), requests=first)
        parts = {"bank": bank.part}
    if flight.spare:
        parts["spare"] = FixedPriority()
    return EstimatorSlot({name: Vetted(part) for name, part in parts.items()})


def fly(seed: int) -> Row:
    """The row of a seed."""
    return row(log(seed), seed)


def row(log: Log, seed: int) -> Row:
    """What is kept of a flight."""
    flight, events = drawn(seed), log.meta.get("events", [])
    hardest = touch_down(log)
    broken = list(violations(log))
    return {
        "airframe": log.meta["airframe"],
        "on": "+".join(flight.members) or "cameras",
        "errand": list(flight.kinds),
        "wind": round(float(np.linalg.norm(flight.scenario.wind.mean)), 2),
        "faults": [_plain(x) for x in log.meta.get("faults", [])],
        "exit": log.exit.name,
        "reason": log.reason,
        "bad": bool(broken),
        "touchdown": None if hardest is None else round(hardest, 3),
        "modes": [name for _, name in modes(log)],
        "safety": [name for _, kind, name, _ in events if kind == "safety"],
        "refused": sum(kind == "refused" for _, kind, _, _ in events),
        "violations": broken,
        "flown": round(float(log.t[-1]), 2) if len(log.t) else 0.0,
    }


def _plain(told: list[Any]) -> list[Any]:
    """A fault with numbers of three digits."""
    return [np.round(x, 3).tolist() if isinstance(x, float | list) else x for x in told]


def summed(rows: list[Row]) -> Summary:
    """By the faults that were in a flight."""
    summary = counted(rows, "fault", _groups, _ending)
    hard = sorted(
        (x for x in rows if x.get("touchdown") is not None), key=lambda x: -x["touchdown"]
    )
    worth = {
        "Flights that did not end as they should": [x for x in rows if x["bad"]],
        "The hardest touch-downs": hard[:HARD],
    }
    return summary._replace(said=tuple(_said(rows, hard)), worth=worth)


def _groups(row: Row) -> list[str]:
    return [label(x) for x in row.get("faults", [])]


def _ending(row: Row) -> str:
    """How it ended; what ended well is told by the mode before."""
    return row["exit"]


def _said(rows: list[Row], hard: list[Row]) -> Iterator[str]:
    if hard:
        speeds = [x["touchdown"] for x in hard]
        q = np.percentile(speeds, (50, 95, 99))
        yield (
            f"Touch-downs: {len(speeds)}, at {q[0]:.2f} m/s in the median, {q[1]:.2f} in 95 and {q[2]:.2f} in 99 of a "
            f"hundred, {speeds[0]:.2f} at the hardest."
        )
    seen = Counter(x for row in rows for x in dict.fromkeys(row.get("safety", ())))
    yield "Safety spoke up for: " + ", ".join(f"{k} ({n})" for k, n in seen.most_common()) + "."
    refused = sum(row.get("refused", 0) > 0 for row in rows)
    yield f"In {refused} flights the pilot refused something that was asked, and flew on."


def shown(row: Row) -> Shown:
    """One flight."""
    if "faults" not in row:
        return Shown(f"seed {row['seed']} · {row['exit']}", {"why": row["reason"]}, _again(row))
    said = "; ".join(row["violations"])
    speed = "" if row["touchdown"] is None else f" · down at {row['touchdown']:.2f} m/s"
    broke = ", ".join(dict.fromkeys(map(label, row["faults"])))
    return Shown(
        f"seed {row['seed']} · {row['airframe']} on {row['on']} · {broke} · {row['exit']}{speed}",
        {
            "what is wrong": said,
            "how it ended": row["reason"],
            "faults": "; ".join(_sentence(x) for x in row["faults"]),
            "modes": " → ".join(row["modes"]),
            "safety": ", ".join(row["safety"]),
            "errand": ", ".join(row["errand"]),
            "wind": f"{row['wind']:g} m/s",
        },
        _again(row),
    )


def _sentence(told: list[Any]) -> str:
    kind, t, until, what, value = told
    size = "" if kind in {"lost", "frozen", "nan", "solver", "link"} else f" {value}"
    return f"{kind} {what}{size} from {t:g} to {until:g} s".replace("  ", " ")


def _again(row: Row) -> str:
    return f"uavlab campaign {NAME} --fly {row['seed']}"


CAMPAIGN = Campaign(
    NAME, "Random flights with random faults", fly,
    {"flights": RANGES._asdict(), "faults": SIZES._asdict(), "kinds": sorted(KINDS)},
    log, summed, shown,
)  # fmt: skip
