"""The record of a flight: what was true, believed, wanted and asked, tick by tick; saved and loaded as one .npz."""

from __future__ import annotations

import json
import os
import zipfile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from uavlab.errors import BadFile
from uavlab.flight.worlds import NO_WORLDS, Worlds
from uavlab.flight.worlds import UNITS as WORLDS_UNITS
from uavlab.types import Array, Exit

VERSION = 2  # 1 had no worlds; it is still read

# Unit and frame of every field: printed by plots, written into the file.
UNITS = {
    "t": "s",
    "r": "m, world", "v": "m/s, world", "a": "m/s², world", "R": "body → world",
    "omega": "rad/s, body", "rotors": "N, thrust of each rotor", "wind": "m/s, world",
    "r_e": "m, world (estimate)", "v_e": "m/s, world (estimate)", "R_e": "body → world (estimate)",
    "r_d": "m, world (reference)", "v_d": "m/s, world (reference)", "a_d": "m/s², world (reference)",
    "heading_d": "rad (reference)", "heading_rate_d": "rad/s (reference)",
    "f_d": "N (command)", "omega_d": "rad/s, body (command)",
    "solve": "s, wall time of the minds in this tick",
}  # fmt: skip


class Log(NamedTuple):
    """One flight of N ticks. Stacks put time first: ``log.r`` is (N, 3), ``log.R`` is (N, 3, 3)."""

    t: Array  # (N,) [s]
    r: Array  # (N, 3) [m] true position, world
    v: Array  # (N, 3) [m/s]
    a: Array  # (N, 3) [m/s²]
    R: Array  # (N, 3, 3) body → world
    omega: Array  # (N, 3) [rad/s] body
    rotors: Array  # (N, n) [N] thrust of each rotor
    wind: Array  # (N, 3) [m/s] world
    r_e: Array  # (N, 3) estimate
    v_e: Array  # (N, 3)
    R_e: Array  # (N, 3, 3)
    r_d: Array  # (N, 3) reference
    v_d: Array  # (N, 3)
    a_d: Array  # (N, 3)
    heading_d: Array  # (N,) [rad]
    heading_rate_d: Array  # (N,) [rad/s]
    f_d: Array  # (N,) [N] command
    omega_d: Array  # (N, 3) [rad/s] command
    solve: Array  # (N,) [s] wall time of the minds; the one field that is not the same twice
    exit: Exit  # how it ended
    reason: str  # where and why, in a sentence
    meta: dict[str, Any]  # scenario, airframe, seed, provenance, rates, arm lengths for the views
    worlds: Worlds = NO_WORLDS  # which hypothesis flew, and what each believed

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write everything to one .npz, units included. A log that exists is replaced whole or not at all."""
        path = Path(path)
        if path.suffix != ".npz":
            path = path.with_name(path.name + ".npz")
        arrays = {k: getattr(self, k) for k in UNITS}
        arrays |= {f"worlds.{k}": getattr(self.worlds, k) for k in WORLDS_UNITS}
        head = {
            "version": VERSION,
            "units": UNITS | {f"worlds.{k}": unit for k, unit in WORLDS_UNITS.items()},
            "worlds": self.worlds.names,
            "exit": self.exit.name,
            "reason": self.reason,
            "meta": self.meta,
        }
        path.parent.mkdir(parents=True, exist_ok=True)
        part = path.with_name(path.name + ".part")
        with open(part, "wb") as file:
            np.savez_compressed(file, head=np.array(json.dumps(head)), **arrays)
        part.replace(path)
        return path


def load_log(path: str | os.PathLike[str]) -> Log:
    """Read a log that `Log.save` wrote.

    Raises
    ------
    BadFile
        The file is missing, cut short, or not such a log.
    """
    path = Path(path)
    try:
        with open(path, "rb") as file, np.load(file, allow_pickle=False) as data:
            if "head" not in data:
                raise BadFile(f"{path} is not a uavlab log: it has no head. Log.save writes one.")
            head = json.loads(str(data["head"]))
            if head["version"] not in {1, VERSION}:
                raise BadFile(
                    f"{path} is a log of version {head['version']}; this uavlab reads versions 1 to {VERSION}."
                )
            arrays = {k: data[k] for k in UNITS}
            worlds = NO_WORLDS
            if head["version"] > 1:
                beliefs = {k: data[f"worlds.{k}"] for k in WORLDS_UNITS}
                worlds = Worlds(tuple(head["worlds"]), **beliefs)
    except FileNotFoundError:
        raise BadFile(f"no log at {path}.") from None
    except (KeyError, ValueError, EOFError, TypeError, zipfile.BadZipFile):
        raise BadFile(
            f"{path} is not a whole uavlab log; it may be cut short or something else. "
            "Fly and save it again."
        ) from None
    return Log(
        **arrays, exit=Exit[head["exit"]], reason=head["reason"], meta=head["meta"], worlds=worlds
    )
