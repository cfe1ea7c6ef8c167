"""The command line: ``uavlab list | fly | replay | reproduce | campaign | doctor``.

Exit codes: 0, it is done; 1, it is done and the answer is no (a flight that ended badly, something missing);
2, the input is at fault, said in one line.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from typing import NoReturn

from uavlab import __version__
from uavlab.commands import campaign, doctor, fly, list_, replay, reproduce
from uavlab.errors import BadInput, UavlabError, UnknownName

COMMANDS = {command.NAME: command for command in (list_, fly, replay, reproduce, campaign, doctor)}


class _Parser(argparse.ArgumentParser):
    """An argument parser whose errors are ours: one line, exit code 2."""

    def error(self, message: str) -> NoReturn:
        raise BadInput(f"{message}. Try: {self.prog} --help")


def build_parser() -> argparse.ArgumentParser:
    """The parser of all commands."""
    parser = _Parser(
        prog="uavlab",
        description="Fly, look at flights, and see what is there.",
        epilog="For example: uavlab fly circle --airframe T650 --wind 4 --seed 1",
    )
    parser.add_argument("--version", action="version", version=f"uavlab {__version__}")
    words = parser.add_subparsers(dest="command", metavar="COMMAND", parser_class=_Parser)
    for name, command in COMMANDS.items():
        about = str(command.__doc__).strip()
        add = words.add_parser(name, help=about.splitlines()[0], description=about)
        add.formatter_class = argparse.RawDescriptionHelpFormatter
        command.add(add)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code."""
    words = list(sys.argv[1:] if argv is None else argv)
    try:
        if words and not words[0].startswith("-") and words[0] not in COMMANDS:
            raise UnknownName("command", words[0], COMMANDS)
        parser = build_parser()
        args = parser.parse_args(words)
        if args.command is None:
            parser.print_help()
            return 0
        return COMMANDS[args.command].run(args)
    except UavlabError as error:
        print(f"uavlab: {' '.join(str(error).split())}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("uavlab: stopped.", file=sys.stderr)
        return 130
    except BrokenPipeError:  # `uavlab list | head`
        sys.stderr.close()
        return 0


if __name__ == "__main__":
    sys.exit(main())
