"""Stand-ins, in the student's process, for what draws, shows or compiles.

Nobody looks at a plot while a notebook is graded, importing pyplot costs a second, and numba half of one. A module
of these families is made up on demand; whatever is done with it does nothing.
"""

from __future__ import annotations

import importlib.machinery
import sys
import types
from collections.abc import Callable, Iterator
from typing import Any

FAMILIES = ("matplotlib", "mpl_toolkits", "meshcat", "IPython", "ipywidgets", "numba")


class Nothing:
    """Accepts everything and does nothing."""

    def __init__(self, parts: int = 2) -> None:
        self._parts = parts  # how many it falls into when it is unpacked: fig, ax = …

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return _subplots if name == "subplots" else self

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        """Whatever it is called with, it gives itself."""
        return self

    def __getitem__(self, key: Any) -> Any:
        return self

    def __setitem__(self, key: Any, value: Any) -> None:
        pass

    def __iter__(self) -> Iterator[Any]:
        return iter([Nothing() for _ in range(self._parts)])

    def __len__(self) -> int:
        return self._parts

    def __enter__(self) -> Any:
        return self

    def __exit__(self, *error: Any) -> None:
        pass


def _subplots(nrows: int = 1, ncols: int = 1, *args: Any, **kwargs: Any) -> tuple[Nothing, Nothing]:
    """A figure, and axes that unpack as pyplot's do."""
    return Nothing(), Nothing(nrows if nrows > 1 else ncols)


def _plain(*args: Any, **kwargs: Any) -> Any:
    """A decorator that compiles nothing, with and without arguments."""
    if len(args) == 1 and callable(args[0]) and not kwargs:
        return args[0]
    return lambda function: function


class StandIn(types.ModuleType):
    """A module of one of the families."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        if self.__name__.startswith("numba"):
            return range if name == "prange" else _plain
        if name == "subplots":
            return _subplots
        return Nothing() if name[0].islower() else type(name, (Nothing,), {})


class Finder:  # importlib.abc would cost a tenth of the process's start
    """Finds every module of the families, at any depth."""

    def find_spec(self, fullname: str, path: Any, target: Any = None) -> Any:
        """A made-up package for a name of the families, else None."""
        if fullname.partition(".")[0] not in FAMILIES:
            return None
        return importlib.machinery.ModuleSpec(fullname, self, is_package=True)  # type: ignore[arg-type]

    def create_module(self, spec: importlib.machinery.ModuleSpec) -> StandIn:
        """An empty stand-in."""
        return StandIn(spec.name)

    def exec_module(self, module: types.ModuleType) -> None:
        """There is nothing to execute."""


class Shell(Nothing):
    """What ``get_ipython()`` returns: magics that only wrap code run the code, the others do nothing."""

    def __init__(self, run: Callable[[str], None]) -> None:
        super().__init__()
        self._run = run

    def run_cell_magic(self, name: str, line: str, cell: str) -> None:
        """``%%time`` and its like must not swallow the answer under them."""
        if name in ("time", "timeit", "capture", "prun"):
            self._run(cell)

    def run_line_magic(self, name: str, line: str, *args: Any) -> None:
        """``%time x = f()`` runs its statement."""
        if name in ("time", "timeit", "prun"):
            self._run(line)


def install() -> None:
    """Put the stand-ins before the real modules."""
    sys.meta_path.insert(0, Finder())  # type: ignore[arg-type]


def names(namespace: dict[str, Any]) -> dict[str, Any]:
    """What a notebook's namespace has that a module's has not."""
    shell = Shell(lambda source: exec(source, namespace))
    return {"get_ipython": lambda: shell, "display": Nothing()}
