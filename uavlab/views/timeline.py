"""The story of a flight over time: modes, parts, faults, what happened, and height and control error below."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import numpy as np

from uavlab.errors import BadInput
from uavlab.flight.log import Log
from uavlab.flight.worlds import told
from uavlab.types import Array
from uavlab.views import guards, story, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST = 26  # lines of events that are written out
_PALE = ("#DCE6EE", "#C3D3E0")  # bands of parts, in turn


def plot_story(log: Log) -> Figure:
    """Who flew, in which mode, what broke, and what was said and done about it.

    Parameters
    ----------
    log : Log
        A flight that tells of modes, swaps, refusals or faults (``log.meta["events"]``, ``log.meta["faults"]``).

    Returns
    -------
    Figure
        Bands of mode, tracker, controller, estimator, limits and gains, as far as the log tells of them; faults;
        numbered events; height [m] and control error [m] over t [s], with the bounds that were crossed; the events
        in words.

    Raises
    ------
    BadInput
        There is nothing to tell.
    """
    log = told(guards.settled(style.whole(log)))
    if not (len(log.t) and story.eventful(log)):
        raise BadInput("this log tells of no modes, swaps, refusals or faults; see plot_flight.")
    rows, broken = story.rows(log), story.faults(log)
    groups = _grouped(story.spoken(log), float(log.t[-1] - log.t[0]))
    lines = [_words(n, x) for n, (_, members) in enumerate(groups, 1) for x in members]
    if len(lines) > _MOST:
        lines = [*lines[: _MOST - 1], (f"… and {len(lines) - _MOST + 1} more", "#777777")]
    bands = max(1, len(rows) + len(_lanes(broken)) + bool(groups))
    heights = (0.27 * bands + 0.25, 1.5, 1.5)
    text = 0.175 * max(len(lines), 2)
    with style.styled() as plt:
        figure = plt.figure(figsize=(9, sum(heights) + text + 1.2), layout="constrained")
        axes = figure.subplots(4, 1, height_ratios=(*heights, text))
        _strip(axes[0], log, rows, broken, groups)
        _height(axes[1], log)
        _control_error(axes[2], log)
        for at in axes[:3]:
            at.set_xlim(log.t[0], max(log.t[-1], log.t[0] + 1e-3))
            _mark(at, groups)
        for at in axes[:2]:
            at.tick_params(labelbottom=False)
        axes[2].set_xlabel("time [s]")
        _listed(axes[3], lines)
        style.stamp(figure, style.small_print(log))
    return figure


Group = tuple[float, list[story.Moment]]


def _grouped(events: list[story.Moment], span: float) -> list[Group]:
    """Events by number: those that could not be told apart on the page share one."""
    groups: list[Group] = []
    for x in events:
        if groups and x.t - groups[-1][0] < 0.014 * span:
            groups[-1][1].append(x)
        else:
            groups.append((x.t, [x]))
    return groups


def _words(n: int, x: story.Moment) -> tuple[str, str]:
    """A line of the list, and its colour."""
    said = f"{n:>2}  {x.t:7.2f} s   {x.sentence}"
    return (said if len(said) <= 132 else said[:131] + "…"), x.color


def _gravest(members: list[story.Moment]) -> story.Moment:
    return next((x for x in members if x.kind == "safety"), members[0])


def _lanes(broken: list[story.Band]) -> list[list[story.Band]]:
    """Faults in rows in which none covers another."""
    lanes: list[list[story.Band]] = []
    for x in broken:
        lane = next((y for y in lanes if y[-1].end <= x.start), None)
        if lane is None:
            lanes.append([x])
        else:
            lane.append(x)
    return lanes


def _strip(
    at: Axes, log: Log, rows: dict[str, list[story.Band]], broken: list[story.Band],
    groups: list[Group],
) -> None:  # fmt: skip
    """All bands, one row each, from above: events, modes, slots, faults."""
    names = [*(["events"] if groups else []), *rows]
    for k, (kind, bands) in enumerate(rows.items(), int(bool(groups))):
        for n, x in enumerate(bands):
            color = style.mode(x.name) if kind == "mode" else _PALE[n % 2]
            _band(at, log, k, x, color, style.ink(color))
    for lane in _lanes(broken):
        for x in lane:
            _band(at, log, len(names), x, "#F3D3BB", "#5A2A08", hatch="////")
        names.append("faults" if "faults" not in names else "")
    for n, (t, members) in enumerate(groups, 1):
        at.text(
            t, 0, str(n), fontsize=6.5, ha="center", va="center", color="white", zorder=5,
            bbox={"boxstyle": "round,pad=0.25", "fc": _gravest(members).color, "ec": "white", "lw": 0.6},
        )  # fmt: skip
    at.set_yticks(range(len(names)), names)
    at.set_ylim(len(names) - 0.4, -0.6)
    at.grid(visible=False)
    at.tick_params(length=0)
    for side in at.spines.values():
        side.set_visible(False)


def _band(
    at: Axes, log: Log, row: int, x: story.Band, color: str, ink: str, hatch: str | None = None
) -> None:
    """One band, and its name where there is room for it."""
    at.barh(
        row, max(x.end - x.start, 0.0), left=x.start, height=0.74, color=color,
        ec="#D9A887" if hatch else "white", lw=0.6, hatch=hatch,
    )  # fmt: skip
    span = max(float(log.t[-1] - log.t[0]), 1e-9)
    most = int((x.end - x.start) / span * 118)  # characters of this size across the whole
    name = x.name if len(x.name) <= most else (x.name[: most - 1] + "…" if most > 4 else "")
    box = {"fc": color, "ec": "none", "pad": 0.6} if hatch else None
    text = at.text(
        (x.start + x.end) / 2, row, name, fontsize=7, ha="center", va="center", color=ink, bbox=box
    )
    text.set_visible(bool(name))


def _mark(at: Axes, groups: list[Group]) -> None:
    """A thin line at each number."""
    for t, members in groups:
        worst = _gravest(members)
        at.axvline(
            t, color=worst.color, lw=1.0 if worst.kind == "safety" else 0.6, alpha=0.7, zorder=0.5
        )


def _height(at: Axes, log: Log) -> None:
    """Height asked and flown, in the colours of the modes, and between which heights the area lies."""
    at.set_title("height [m]")
    if style.seen(log.r_d):
        at.plot(log.t, log.r_d[:, 2], "--", color=style.REFERENCE, lw=1, label="asked")
    _coloured(at, log, log.r[:, 2], "flown")
    area = guards.guards_of(log).area
    top = at.get_ylim()[1]
    for height in (area.low, area.high) if area else ():
        if np.isfinite(height) and height < 1.6 * top:
            at.axhline(height, color=style.AREA, lw=0.9, ls="-.")
            _side_note(at, height, f"area {height:g} m", style.AREA)
    low, high = at.get_ylim()
    at.set_ylim(low, high + 0.24 * (high - low))  # room for the legend
    at.legend(loc="upper right", ncols=2)


def _control_error(at: Axes, log: Log) -> None:
    """Distance from the estimate to the reference, and the bounds that it crossed, as the pilot said them."""
    at.set_title("control error: reference to estimate [m]")
    error = np.linalg.norm(log.r_d - log.r_e, axis=1)
    if not style.seen(error):
        return style.nothing_to_draw(at)
    _coloured(at, log, error, "")
    for bound in sorted(_crossed(log)):
        at.axhline(bound, color=style.MARKS["safety"], lw=0.9, ls="-.")
        _side_note(at, bound, f"bound {bound:g} m", style.MARKS["safety"])
    at.set_ylim(bottom=0.0)


def _crossed(log: Log) -> set[float]:
    """The bounds of the control error of which a safety event speaks [m]."""
    said = [
        x.said
        for x in story.moments(log)
        if x.kind == "safety" and x.name in {"control error", "lost"}
    ]
    found = [re.search(r"bound (\d+(?:\.\d+)?) m", x) for x in said]
    return {float(x.group(1)) for x in found if x}


def _side_note(at: Axes, y: float, text: str, color: str) -> None:
    at.annotate(
        text, (0.0, y), xycoords=("axes fraction", "data"), xytext=(3, 2), fontsize=7, color=color,
        textcoords="offset points",
    )  # fmt: skip


def _coloured(at: Axes, log: Log, values: Array, label: str) -> None:
    """A curve in the colours of the modes."""
    for rows, color, _ in list(story.pieces(log)) or [(slice(None), style.FLOWN, "")]:
        at.plot(log.t[rows], values[rows], color=color, label=label or "_")
        label = ""


def _listed(at: Axes, lines: list[tuple[str, str]]) -> None:
    """The events in words."""
    at.set_axis_off()
    n = max(len(lines), 2)
    for k, (text, color) in enumerate(lines):
        how: dict[str, Any] = {
            "fontsize": 7,
            "family": "monospace",
            "va": "top",
            "in_layout": False,
        }
        at.text(0.0, 1.0 - k / n, text, transform=at.transAxes, color=_dark(color), **how)


def _dark(color: str) -> str:
    """A colour that can be read on white."""
    return "#333333" if style.ink(color) == "#111111" else color
