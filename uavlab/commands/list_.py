"""Say what there is: scenarios, airframes, instruments, parts, faults, labs, data sets."""

from __future__ import annotations

import argparse
import importlib
import shutil
import textwrap

from uavlab.errors import UnknownName

NAME = "list"


def add(parser: argparse.ArgumentParser) -> None:
    """The arguments."""
    parser.add_argument(
        "what", nargs="?", metavar="WHAT", help=f"one of: {', '.join(KINDS)}; all without"
    )


def run(args: argparse.Namespace) -> int:
    """Print the lists."""
    if args.what is not None and args.what not in KINDS:
        raise UnknownName("list", args.what, KINDS)
    wanted = [args.what] if args.what else list(KINDS)
    for kind in wanted:
        print(kind)
        print_rows(KINDS[kind]())
        print()
    return 0


def print_rows(rows: list[tuple[str, ...]], indent: str = "  ") -> None:
    """Columns as wide as they need to be; the last one wrapped to the terminal."""
    if not rows:
        return
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]) - 1)]
    for row in rows:
        head = indent + "".join(f"{cell:<{w}}  " for cell, w in zip(row, widths, strict=False))
        room = max(30, shutil.get_terminal_size((110, 24)).columns - len(head))
        lines = textwrap.wrap(row[-1], room) or [""]
        print((head + lines[0]).rstrip())
        for line in lines[1:]:
            print(" " * len(head) + line)


def _scenarios() -> list[tuple[str, ...]]:
    from uavlab import scenarios

    loaded = [scenarios.load(name) for name in scenarios.names()]
    return [(s.name, s.airframe, f"{s.duration:g} s", s.summary) for s in loaded]


def _airframes() -> list[tuple[str, ...]]:
    from uavlab.plant import airframe_names, load_airframe

    rows = []
    for name in airframe_names():
        a = load_airframe(name)
        ratio = a.n * float(a.thrust_max) / (9.81 * float(a.m))
        what = (
            f"{a.n} rotors, {float(a.m):g} kg, arm {float(a.arm):g} m, thrust to weight {ratio:.1f}"
        )
        rows.append((name, what))
    return rows


def _parts() -> list[tuple[str, ...]]:
    from uavlab.flight.known import listed

    return list(listed())


def _labs() -> list[tuple[str, ...]]:
    from uavlab.exercises.spec import STEMS, exercises, lab

    rows = []
    for number, stem in enumerate(STEMS, start=1):
        asked = exercises(stem)
        points = sum(x.points for x in asked)
        said = " ".join(str(lab(stem).__doc__).split("\n\n")[0].split())
        rows.append((f"{number:02d} {stem}", f"{points:g} points", f"{len(asked)} exercises", said))
    return rows


def _datasets() -> list[tuple[str, ...]]:
    from uavlab.datasets import about, names

    return [(name, about(name).licence, about(name).summary) for name in names()]


def _instruments() -> list[tuple[str, ...]]:
    from uavlab.sensors import INSTRUMENTS

    rows = []
    for name, kind in INSTRUMENTS.items():
        module = str(importlib.import_module(kind.__module__).__doc__)
        rows.append((name, kind.__name__, f"{kind().rate:g} Hz", " ".join(module.split())))
    return rows


def _kits() -> list[tuple[str, ...]]:
    from uavlab.sensors import KITS

    return [(name, f"{make.__doc__} Carries {', '.join(make())}.") for name, make in KITS.items()]


def _faults() -> list[tuple[str, ...]]:
    from uavlab.flight.injected import KINDS as kinds

    return list(kinds.items())


KINDS = {
    "scenarios": _scenarios,
    "airframes": _airframes,
    "instruments": _instruments,
    "kits": _kits,
    "parts": _parts,
    "faults": _faults,
    "labs": _labs,
    "datasets": _datasets,
}
