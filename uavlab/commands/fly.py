"""Fly a scenario: numbers on the screen; log, replay and plots in a folder.

The minds are the stand-ins that come with uavlab, or those that the scenario or the command line names. Exit code 1
means that the flight ended badly.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from uavlab.errors import BadInput

NAME = "fly"


def add(parser: argparse.ArgumentParser) -> None:
    """The arguments."""
    parser.add_argument(
        "scenario", metavar="NAME", help="a scenario of `uavlab list`, or the path of a .toml"
    )
    for flag, kind, letter, said in (
        ("--airframe", str, "A", "another airframe, or the path of a .toml"),
        ("--seed", int, "N", "of gusts and sensors (0)"),
        (
            "--wind",
            float,
            "X",
            "mean wind towards x [m/s], with the gusts of MIL-F-8785C at 5 m height",
        ),
        ("--duration", float, "T", "simulated time [s]"),
        ("--controller", str, "C", "a controller of `uavlab list parts`"),
        ("--tracker", str, "T", "a tracker of `uavlab list parts`"),
        ("--estimator", str, "E", "an estimator of `uavlab list parts`"),
        ("--mission", str, "M", "a mission of `uavlab list parts`, in place of the scenario's"),
        ("--gains", str, "G", "of the GeometricController: supersoft, soft or tight"),
        ("--out", Path, "DIR", "where to write (flights/NAME-AIRFRAME-seedN)"),
    ):
        parser.add_argument(flag, type=kind, metavar=letter, help=said)
    parser.set_defaults(seed=0)


def run(args: argparse.Namespace) -> int:
    """Fly, print, write."""
    scenario = asked(args)
    mind = named(args, scenario)
    out = (
        args.out
        or Path("flights") / f"{scenario.name}-{Path(scenario.airframe).stem}-seed{args.seed}"
    )
    log = _flown(scenario, mind, args.seed)
    show(log)
    write(log, out)
    return 0 if log.exit.good else 1


def _stem(args: argparse.Namespace, scenario: Any) -> str:
    """A folder's name that tells this flight from others."""
    wind = "" if args.wind is None else f"-wind{args.wind:g}"
    return f"{scenario.name}-{Path(scenario.airframe).stem}{wind}-seed{args.seed}"


def asked(args: argparse.Namespace) -> Any:
    """The scenario that the arguments describe, checked before anything flies."""
    import numpy as np

    from uavlab import scenarios
    from uavlab.flight.scenario import checked
    from uavlab.plant import load_airframe

    scenario = scenarios.load(args.scenario)
    if args.seed < 0:
        raise BadInput(f"--seed is {args.seed}; it must be 0 or more.")
    if args.airframe is not None:
        scenario = scenario._replace(airframe=args.airframe)
    load_airframe(scenario.airframe)
    if args.duration is not None:
        scenario = scenario._replace(duration=args.duration)
    if getattr(args, "mission", None) is not None:
        from uavlab.flight.fill import fill

        _belongs(args.mission, "mission")
        scenario = scenario._replace(mission=fill(args.mission).part)
    if args.wind is not None:
        if not abs(args.wind) <= 30.0:
            raise BadInput(f"--wind is {args.wind} m/s; it must lie between −30 and 30.")
        from uavlab.plant.wind import low_altitude

        scenario = scenario._replace(wind=low_altitude(np.array([args.wind, 0.0, 0.0]), 5.0))
    return checked(scenario)


def named(args: argparse.Namespace, scenario: Any) -> Any:
    """What the scenario flies, with the parts that the arguments name in their slots; None if they name nothing.

    Parts that the scenario swaps in later share a slot with those that fly first.
    """
    from uavlab.flight.fill import exchanged, fill, slowed, stack, told
    from uavlab.flight.slot import with_slots
    from uavlab.gains import gains_for
    from uavlab.plant import load_airframe

    if args.gains is not None and args.controller != "GeometricController":
        raise BadInput("--gains needs --controller GeometricController: no other has such groups.")
    airframe, mind = load_airframe(scenario.airframe), None
    for slot in ("controller", "tracker", "estimator"):
        name = getattr(args, slot, None)
        if name is None:
            continue
        _belongs(name, slot)
        mind = mind or (scenario.mind or stack)(scenario.airframe)
        given = told(name, airframe)
        if slot == "controller" and args.gains is not None:
            given["gains"] = gains_for(airframe.name, args.gains)
        mind = exchanged(mind, slot, fill(name, **given))
    if args.tracker == "MpcTracker":
        mind = slowed(mind)
    if scenario.swaps:
        mind = with_slots(scenario, mind or (scenario.mind or stack)(scenario.airframe))
    return mind


def _belongs(name: str, slot: str) -> None:
    """Refuse a part by name that belongs into another slot, or that nobody has."""
    from uavlab.flight.known import slot_of

    has = slot_of(name)
    if has != slot:
        raise BadInput(
            f"{name} is {'an' if has[0] == 'e' else 'a'} {has}; give it as --{has} {name}."
        )


def _flown(scenario: Any, mind: Any, seed: int) -> Any:
    """The flight, with a bar on a terminal."""
    from tqdm import tqdm

    from uavlab.flight.fly import fly

    shape = "{l_bar}{bar}| {n:.0f}/{total:.0f} s [{elapsed}<{remaining}]"
    with tqdm(total=scenario.duration, desc=scenario.name, disable=None, bar_format=shape) as bar:

        def advance(t: float, _end: float) -> None:
            bar.update(t - bar.n)

        return fly(scenario, mind, seed=seed, progress=advance)


def show(log: Any) -> None:
    """Print how it ended, its numbers, and who flew."""
    from uavlab.commands.list_ import print_rows
    from uavlab.flight.fill import ASKED, STAND_IN
    from uavlab.flight.metrics import summary
    from uavlab.flight.worlds import flown_by
    from uavlab.views.story import moments
    from uavlab.views.style import ending, provenance, title

    print(title(log))
    print(ending(log))
    print_rows([(name, f"{value:10.3f}") for name, value in summary(log).items()])
    print(f"flown by {provenance(log)}")
    for name in log.meta["provenance"]:
        part, _, missing = name.rpartition(".")[2].partition(" without ")  # of a slot: "name.part"
        if missing or (part in ASKED and log.meta["provenance"][name] == STAND_IN):
            print(
                f"{part} was flown by its stand-in: {missing or 'it was'} not found. Install the answers "
                "with `pip install uavlab-solutions`, or fly your own from a notebook."
            )
    for event in moments(log):
        print(f"  {event.t:6.2f} s: {event.sentence}")
    for start, end, who in flown_by(log) if log.worlds.names else []:
        print(f"  {start:6.2f} to {end:6.2f} s on {who or 'what it was given at the start'}")


def write(log: Any, out: Path) -> None:
    """Write log, plots and replay into a folder, and say where they are."""
    from uavlab import views
    from uavlab.commands import outputs

    with outputs.folder(out) as part:
        log.save(part / "log.npz")
        views.save(views.plot_flight(log), part / "flight.png")
        views.save(views.plot_path(log), part / "path.png")
        if len(log.t) and log.worlds.names:
            views.save(views.plot_bank(log), part / "bank.png")
        if views.has_modes(log):
            views.save(views.plot_story(log), part / "story.png")
        if len(log.t):
            views.save(views.picture(log), part / "replay.png")
            views.replay(log, part / "replay.html")
        written = sorted(file.name for file in part.iterdir())
    for name in written:
        if name != "meshcat.js":
            print(out / name)
