"""The one place that knows numba: `kernel` compiles a function, or leaves it as plain Python where numba is missing.

Only the compiled rooms import this module, and only when a plant is made: importing numba takes a second.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

F = TypeVar("F", bound=Callable[..., Any])

numba: Any
try:
    import numba
except ImportError:  # the same functions fly as plain Python, a hundred times slower
    numba = None


def kernel(function: F) -> F:
    """`function` for use inside `entry`. Not to be called from Python: its wrapper is left out, a third of the time."""
    if numba is None:
        return function
    return numba.njit(function, error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True)


def entry(function: F) -> F:
    """`function` compiled, with the machine code kept on disk when there is a folder to write to."""
    if numba is None or numba.config.DISABLE_JIT:
        return function
    before = numba.config.CACHE_DIR
    try:
        numba.config.CACHE_DIR = str(_cache_folder())
        return numba.njit(function, error_model="numpy", cache=True)
    except (OSError, RuntimeError):  # nowhere to write: compile anew in each process
        return numba.njit(function, error_model="numpy")
    finally:
        numba.config.CACHE_DIR = before


def _cache_folder() -> Path:
    """A folder that can be written, named after the sources: numba does not notice when a called function changes."""
    leaf = Path("uavlab") / f"kernels-{_digest()}"
    places = [
        os.environ.get("NUMBA_CACHE_DIR"),
        os.environ.get("XDG_CACHE_HOME"),
        os.environ.get("LOCALAPPDATA"),
        os.path.expanduser("~/.cache"),
        tempfile.gettempdir(),
    ]
    for place in filter(None, places):
        folder = Path(place) / leaf
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError:
            continue
        if os.access(folder, os.W_OK):
            return folder
    raise OSError("no folder for compiled code")


def _digest() -> str:
    """Fingerprint of everything that is compiled."""
    here = Path(__file__).parent
    mixed = hashlib.sha256()
    for path in [*sorted(here.glob("*.py")), here.parent / "so3.py"]:
        mixed.update(path.read_bytes())
    return mixed.hexdigest()[:16]
