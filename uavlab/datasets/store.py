"""Real flights, by name: from a folder, else from the cache, else over the network; always checked by hash."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

from uavlab.datasets.catalogue import Dataset, about
from uavlab.errors import BadFile

FOLDER = "UAVLAB_DATA"  # environment variable: a folder with the files


def fetch(name: str) -> Path:
    """Path of a dataset's file, whole and unchanged.

    With the environment variable ``UAVLAB_DATA`` the file is taken from that folder; without, from the user's
    cache, into which it is fetched once.

    Parameters
    ----------
    name : str
        One of `uavlab.datasets.names`.

    Raises
    ------
    UnknownName
        There is no such dataset.
    BadFile
        It cannot be had, or is not the file that it should be.
    """
    data = about(name)
    folder = os.environ.get(FOLDER)
    if folder:
        return _from_folder(data, Path(folder))
    return _from_network(data, cache())


def cache() -> Path:
    """The user's cache folder."""
    import pooch

    return Path(pooch.os_cache("uavlab"))


def _from_folder(data: Dataset, folder: Path) -> Path:
    path = folder / data.path
    if not path.is_file():
        raise BadFile(
            f"{data.name}: no file {data.path} in {FOLDER}={folder}. "
            f"Put it there (from {data.url}), or unset {FOLDER} to fetch it."
        )
    content = path.read_bytes()
    if hashlib.sha256(content).hexdigest() != data.sha256:
        raise BadFile(_differs(data, path, len(content)))
    return path


def _differs(data: Dataset, path: Path, size: int) -> str:
    """Why a file is not the one that was asked for."""
    how = (
        f"it is cut short: {size} of {data.size} bytes"
        if size < data.size
        else f"its sha256 is not {data.sha256[:12]}…"
    )
    return f"{data.name}: {path} is not the file it should be; {how}. Delete it and fetch it again."


def _from_network(data: Dataset, folder: Path) -> Path:
    import logging

    import pooch

    pooch.get_logger().setLevel(logging.WARNING)
    path = folder / data.path
    try:
        pooch.retrieve(data.url, f"sha256:{data.sha256}", path.name, path.parent)
    except ValueError:  # pooch's word for a hash that does not match; it leaves nothing behind
        raise BadFile(
            f"{data.name}: what {data.url} sent is not the file it should be "
            f"(sha256 {data.sha256[:12]}…). Try again, or put the right file into a folder and set {FOLDER}."
        ) from None
    except OSError as error:
        raise BadFile(
            f"{data.name} cannot be fetched from {data.url} ({type(error).__name__}). "
            f"Go online once, or put {data.path} into a folder and set {FOLDER} to that folder."
        ) from None
    return path
