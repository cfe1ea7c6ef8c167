"""Recordings as logs, so that views and metrics take them. What was not recorded is NaN."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from uavlab.datasets.catalogue import DATASETS
from uavlab.datasets.phantom import DOT_COLUMNS, RTK_COLUMNS, RtkTrack, columns_of, read_rtk
from uavlab.datasets.px4 import PX4Log, read_px4
from uavlab.datasets.store import fetch
from uavlab.errors import BadFile, UnknownName
from uavlab.flight.log import Log, load_log
from uavlab.types import Array, Exit


def as_log(recorded: PX4Log | RtkTrack, **meta: Any) -> Log:
    """A recording as a `Log`.

    A PX4 log gives attitude and rates; its position is drawn at rest one metre above the origin, and the log says so.
    An RTK track gives position, attitude, and the velocity as differences of positions.

    Parameters
    ----------
    recorded : PX4Log or RtkTrack
        From `read_px4` or `read_rtk`.
    **meta
        Added to ``log.meta``, e.g. `licence` and `citation`.
    """
    if isinstance(recorded, PX4Log):
        n = len(recorded.t)
        return _log(
            recorded.t,
            np.tile([0.0, 0.0, 1.0], (n, 1)),
            recorded.R,
            omega=recorded.omega,
            meta={
                "scenario": recorded.meta["source"],
                "airframe": recorded.meta["hardware"],
                "position": False,
                "note": "A real log: attitude by EKF2. Its position is not known; it is drawn at (0, 0, 1) m.",
                **meta,
            },
        )
    return _log(
        recorded.t,
        recorded.r,
        recorded.R,
        v=np.gradient(recorded.r, recorded.t, axis=0) if len(recorded.t) > 1 else None,
        meta={
            "scenario": recorded.meta["source"],
            "airframe": "DJI Phantom 4 RTK",
            "arm": 0.175,
            "note": "A real flight: position by RTK, attitude by the aircraft; velocity from differences.",
            **meta,
        },
    )


def _log(
    t: Array, r: Array, R: Array, *, meta: dict[str, Any],
    v: Array | None = None, omega: Array | None = None,
) -> Log:  # fmt: skip
    n = len(t)
    unknown, scalar = np.full((n, 3), np.nan), np.full(n, np.nan)
    return Log(
        t=t, r=r, v=unknown if v is None else v, a=unknown, R=R,
        omega=unknown if omega is None else omega, rotors=np.zeros((n, 0)), wind=unknown,
        r_e=unknown, v_e=unknown, R_e=np.full((n, 3, 3), np.nan), r_d=unknown, v_d=unknown,
        a_d=unknown, heading_d=scalar, heading_rate_d=scalar, f_d=scalar, omega_d=unknown,
        solve=scalar, exit=Exit.DONE, reason="the recording ran to its end", meta=meta,
    )  # fmt: skip


def read_flight(source: str | os.PathLike[str]) -> Log:
    """Any flight as a `Log`: a .npz of uavlab, a PX4 .ulg, a GT.csv, or the name of a dataset.

    Raises
    ------
    BadFile
        Missing, damaged, or of no kind that is known.
    UnknownName
        Neither a file nor a dataset.
    """
    name = os.fspath(source)
    if name in DATASETS:
        data = DATASETS[name]
        return _read(fetch(name), citation=data.citation, licence=data.licence)
    path = Path(name)
    if not path.exists() and not path.suffix:
        raise UnknownName("file or dataset", name, DATASETS)
    return _read(path)


def _read(path: Path, **meta: str) -> Log:
    if not path.is_file():
        raise BadFile(f"no file at {path}." if not path.exists() else f"{path} is not a file.")
    kind = path.suffix.lower()
    if kind == ".npz":
        return load_log(path)
    if kind == ".ulg":
        return as_log(read_px4(path), **meta)
    if kind == ".csv":
        columns = columns_of(path)
        if columns == DOT_COLUMNS:
            raise BadFile(
                f"{path} is an inertial unit alone: it has no position and no heading in the world. "
                "Replay the GT.csv beside it."
            )
        if columns == RTK_COLUMNS or not columns:
            return as_log(read_rtk(path), **meta)
    raise BadFile(
        f"{path} is of no kind that can be replayed: a .npz of uavlab, a PX4 .ulg, or a GT.csv."
    )
