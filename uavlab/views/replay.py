"""The replay: a flight in 3D, in one small page that needs no server and no network.

The scene is made of meshcat's own messages; the page hands them to meshcat's viewer and drives its animation with a bar
of its own. The viewer's JavaScript lies once beside all replays of a folder (`meshcat.js`), or packed inside the page.
"""

from __future__ import annotations

import base64
import hashlib
import html
import json
import os
import re
import zlib
from collections.abc import Mapping, Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from uavlab.errors import BadInput
from uavlab.flight.log import Log
from uavlab.flight.metrics import heading_error, headings, tilt
from uavlab.types import Array
from uavlab.views import style
from uavlab.views.cast import cast, drawn_scale, frame_of, guards_in

Logs = Log | Sequence[Log] | Mapping[str, Log]
RATE = 25.0  # [Hz] of key frames; less on long flights
MOST_KEYS = 900
_BESIDE = '<script src="meshcat.js"></script>'


class Target(NamedTuple):
    """Something else that moves, drawn as a frame: a deck, a goal."""

    t: Array  # (N,) [s]
    r: Array  # (N, 3) [m]
    R: Array | None = None  # (N, 3, 3) target → world; upright if there is none


def replay(
    logs: Logs, path: str | os.PathLike[str] | None = None, *,
    folder: str | os.PathLike[str] = "replays",
    target: Target | None = None, thrusts: bool = True, alone: bool = False,
) -> Path:  # fmt: skip
    """Write the replay of one or several flights as a page.

    Parameters
    ----------
    logs : Log, or several, or a mapping of label to Log
        The first is solid; the others fly along as ghosts. A flight that ended early stops at its end.
    path : path-like, optional
        The page to write. ``meshcat.js`` is put beside it.
    folder : path-like
        Where ``<scenario>-<digest>.html`` is written if no `path` is given.
    target : Target, optional
        A moving frame to show.
    thrusts : bool
        Draw the thrust of each rotor.
    alone : bool
        Pack the viewer into the page (300 kB more) instead of beside it.

    Returns
    -------
    Path
        The page; open it from the disk or through any server.

    Raises
    ------
    BadInput
        There is nothing to show.
    """
    flights = cast(logs)
    if not len(next(iter(flights.values())).t):
        raise BadInput("the flight has no tick with a finite pose: there is nothing to replay.")
    block = _block(flights, target, thrusts)
    first = next(iter(flights.values()))
    page = Path(path) if path is not None else Path(folder) / f"{_stem(first, block)}.html"
    text = (files("uavlab.views") / "replay.html").read_text(encoding="utf-8")
    text = text.replace("{{title}}", html.escape(style.title(first)))
    text = text.replace("{{viewer}}", _viewer_inside() if alone else _BESIDE)
    text = text.replace("{{scene}}", base64.b64encode(block).decode("ascii"))
    page.parent.mkdir(parents=True, exist_ok=True)
    if not alone:
        _viewer_beside(page)
    _write(page, text.encode("utf-8"))
    return page


def _stem(log: Log, block: bytes) -> str:
    name = re.sub(r"[^A-Za-z0-9_-]+", "-", str(log.meta.get("scenario", "flight")))
    return f"{name}-{hashlib.sha256(block).hexdigest()[:8]}"


def _block(flights: dict[str, Log], target: Target | None, thrusts: bool) -> bytes:
    """The page's data and the scene's messages, packed."""
    from uavlab.views import ghosts, guards, props, strip
    from uavlab.views.scene import Scene

    scene = Scene()
    low, high = frame_of(flights)
    size = drawn_scale(flights)
    radius = float(np.linalg.norm(high - low)) * 0.0022
    centre = props.add_light_and_camera(scene, low, high)
    step = props.add_ground(scene, low, high)
    fences = guards.add_guards(scene, guards_in(flights), low, high, 0.5 * radius)
    page: dict[str, Any] = {"flights": [], "legend": [], "centre": centre, "story": None}
    for k, (label, log) in enumerate(flights.items()):
        if not len(log.t):
            continue
        rate = min(RATE, MOST_KEYS / max(float(log.t[-1] - log.t[0]), 1e-3))
        key = props.keys(log, rate)
        color = style.SERIES[k % len(style.SERIES)]
        node = f"uavlab/{_node(label, k)}"
        modes = strip.trail_colors(log, key) if len(flights) == 1 else None
        _add_flight(scene, node, log, key, size, radius, low[2], color, modes, ghost=k > 0)
        if k == 0:
            _add_reference(scene, log, key, size, radius)
            if thrusts:
                props.add_thrusts(scene, f"{node}/aircraft", log, key, size)
        page["flights"].append(_caption(label, log, key, color, node))
        if k == 0:
            page["flights"][0] |= ghosts.add_hypotheses(scene, node, log, key, size, 0.6 * radius)
            page["marks"] = strip.add_marks(scene, node, log, 3.2 * radius)
            page["story"] = strip.page_story(log)
    if target is not None:
        _add_target(scene, target, size * _arm(flights))
    told = strip.legend(next(iter(flights.values())), fences, alone=len(flights) == 1)
    page["legend"] = told + _legend(flights, target, thrusts, step, size)
    return scene.packed(json.dumps(page).encode("utf-8"))


def _add_flight(
    scene: Any, node: str, log: Log, key: Any, size: float, radius: float, floor: float,
    color: str, modes: list[str] | None, *, ghost: bool,
) -> None:  # fmt: skip
    from uavlab.views import props

    r = log.r[key.rows]
    props.add_aircraft(scene, f"{node}/aircraft", log, size, ghost=color if ghost else None)
    scene.move(f"{node}/aircraft", key.t, r=r, R=log.R[key.rows])
    props.add_trail(scene, f"{node}/trail", r, radius, modes or color)
    props.add_shadow(
        scene, f"{node}/shadow", log, key, floor, 0.35 * size * (log.meta.get("arm") or 0.25)
    )
    if not log.exit.good:
        from uavlab.views.scene import ball, look

        scene.add(f"{node}/end", ball(4 * radius), look(style.GHOST, 0.6))
        scene.place(f"{node}/end", r[-1])


def _add_reference(scene: Any, log: Log, key: Any, size: float, radius: float) -> None:
    """The path that was asked, and a frame that moves along it with the asked heading."""
    from uavlab.so3 import about_z
    from uavlab.views import props

    asked = np.isfinite(log.r_d[key.rows]).all(axis=1) & np.isfinite(log.heading_d[key.rows])
    if asked.sum() < 2:
        return
    rows, t = key.rows[asked], key.t[asked]
    props.add_dashes(scene, "uavlab/reference/path", log.r_d[rows], 0.7 * radius, style.REFERENCE)
    props.add_frame(scene, "uavlab/reference/frame", 1.5 * size * (log.meta.get("arm") or 0.25))
    R = np.array([about_z(eta) for eta in log.heading_d[rows]])
    scene.move("uavlab/reference/frame", t, r=log.r_d[rows], R=R)


def _add_target(scene: Any, target: Target, size: float) -> None:
    from uavlab.views import props

    t, r = np.asarray(target.t, dtype=float), np.asarray(target.r, dtype=float)
    if r.shape != (len(t), 3) or not np.isfinite(r).all():
        raise BadInput(
            f"target.r has shape {r.shape}; finite ({len(t)}, 3) is needed, one row per time."
        )
    every = max(1, len(t) // MOST_KEYS)
    props.add_frame(scene, "uavlab/target", 2 * size)
    R = None if target.R is None else np.asarray(target.R)[::every]
    scene.move("uavlab/target", t[::every] - t[0], r=r[::every], R=R)


def _arm(flights: Mapping[str, Log]) -> float:
    return float(next(iter(flights.values())).meta.get("arm") or 0.25)


def _node(label: str, k: int) -> str:
    return re.sub(r"[^A-Za-z0-9_ -]+", "", label).strip() or f"flight {k + 1}"


def _caption(label: str, log: Log, key: Any, color: str, node: str) -> dict[str, Any]:
    """What the page says of one flight, and the numbers that run along."""
    error = heading_error(log)[key.rows]
    known = 1.0 if log.meta.get("position", True) else np.nan  # a made-up height is not shown
    columns = {
        "t": key.t,
        "speed": np.linalg.norm(log.v[key.rows], axis=1),
        "height": known * log.r[key.rows, 2],
        "tilt": np.rad2deg(tilt(log)[key.rows]),
        "heading": np.rad2deg(headings(log)[key.rows]),
        "error": np.rad2deg(error),
    }
    return {
        "label": label,
        "color": color,
        "node": node,
        "title": style.title(log),
        "ending": style.ending(log),
        "bad": not log.exit.good,
        "small": [x for x in (style.provenance(log), str(log.meta.get("note", ""))) if x],
        "numbers": {name: _plain(values) for name, values in columns.items()},
    }


def _plain(values: Array) -> list[float | None]:
    """Numbers for JSON: three decimals, null for what is not finite."""
    return [round(float(x), 3) if np.isfinite(x) else None for x in values]


def _legend(
    flights: Mapping[str, Log], target: Target | None, thrusts: bool, step: float, size: float
) -> list[list[str]]:
    first = next(iter(flights.values()))
    rows = [
        ["#3B7DD8", "rotor turns counter-clockwise"],
        ["#E0902F", "clockwise"],
        ["#D0342C", "nose"],
    ]
    if style.seen(first.r_d):
        rows.append([style.REFERENCE, "asked path and frame"])
    rows += [
        [style.hypothesis(k), f"what {name} believes"] for k, name in enumerate(first.worlds.names)
    ]
    if thrusts and style.seen(first.rotors):
        rows.append(["#2CA02C", "thrust of each rotor"])
    if target is not None:
        rows.append(["#777777", "target frame"])
    rows.append(["", f"grid {step:g} m"])
    if size > 1:
        rows.append(["", f"aircraft drawn {size:g}× its size"])
    return rows


def _viewer() -> bytes:
    """JavaScript of the viewer, from the installed package meshcat."""
    return (files("meshcat") / "viewer" / "dist" / "main.min.js").read_bytes()


def _viewer_inside() -> str:
    packed = base64.b64encode(zlib.compress(_viewer(), 9)).decode("ascii")
    return f'<script id="viewer" type="text/plain">{packed}</script>'


def _viewer_beside(page: Path) -> None:
    """Put meshcat's JavaScript beside the page, unless the same is there."""
    script = page.with_name("meshcat.js")
    data = _viewer()
    if not (script.exists() and script.stat().st_size == len(data)):
        _write(script, data)


def _write(path: Path, data: bytes) -> None:
    """Write whole or not at all."""
    part = path.with_name(f"{path.name}.{os.getpid()}.part")
    part.write_bytes(data)
    part.replace(path)
