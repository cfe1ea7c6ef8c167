"""What the student's process keeps for the judge: objects and memories, named by numbers of the judge's own.

No number comes from the student. A process that starts again has forgotten everything; a number of the one before
is known by its epoch, and asked for in vain.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any, Protocol

from grader import protocol
from uavlab.exercises.classes import Method

MAX_HELD = 10_000  # at once; a check that holds more is wrong


class Lost(Exception):
    """The process that held this memory has ended."""


class Handle:
    """One thing that the student's process keeps; all that is known of it here is its number."""

    def __init__(self, ledger: Ledger) -> None:
        self.number = 0
        self.ledger, self.epoch = ledger, ledger.epoch
        self.number = ledger.new()

    def __del__(self) -> None:
        if self.number:
            self.ledger.drop(self.number)


class Ledger:
    """The numbers that are in use."""

    def __init__(self) -> None:
        self.epoch = self._last = self._held = 0
        self._dropped: list[int] = []

    def new(self) -> int:
        """A number that was never used."""
        if self._held >= MAX_HELD:
            raise RuntimeError(f"a check holds {self._held} memories at once: let go of some")
        self._held += 1
        self._last += 1
        return self._last

    def drop(self, number: int) -> None:
        """Nobody here needs this one any more."""
        self._held -= 1
        self._dropped.append(number)

    def dropped(self) -> list[int]:
        """What the process may forget, said once."""
        said, self._dropped = self._dropped, []
        return said

    def restart(self) -> None:
        """A new process holds nothing."""
        self.epoch += 1
        self._dropped = []

    def number(self, handle: Handle) -> int:
        """The number of something that is still there.

        Raises
        ------
        Lost
            It went with its process.
        """
        if handle.epoch != self.epoch:
            raise Lost("the process that held this memory has ended")
        return handle.number


class Request:
    """One call of a function, a class, or a method of an object that is kept."""

    def __init__(self, name: str, args: tuple[Any, ...], kwargs: dict[str, Any]) -> None:
        self.name, self.args, self.kwargs = name, args, kwargs
        self.thing: Handle | None = None
        self.method: Method | None = None  # how its result falls apart

    def message(self, arrays: list[Any], ledger: Ledger, kept: list[Handle]) -> dict[str, Any]:
        """As it crosses. Handles stay behind, their numbers go along; `kept` gets those of the result."""
        places = [*enumerate(self.args), *self.kwargs.items()]
        held = [[k, ledger.number(x)] for k, x in places if isinstance(x, Handle)]
        plain = [None if isinstance(x, Handle) else x for x in self.args]
        named = {k: v for k, v in self.kwargs.items() if not isinstance(v, Handle)}
        arguments = [
            [protocol.encode(x, arrays) for x in plain],
            {k: protocol.encode(v, arrays) for k, v in named.items()},
        ]
        message: dict[str, Any] = {"op": "call", "function": self.name, "arguments": arguments}
        if held:
            message["held"] = held
        if self.thing is not None:
            message["thing"] = ledger.number(self.thing)
        if self.method is not None and self.method.gives_memory:
            kept += [Handle(ledger) for _ in self.method.places or (0,)]
            numbers = [x.number for x in kept]
            message["store"] = [self.method.size, list(self.method.places), numbers]
        if forget := ledger.dropped():
            message["forget"] = forget
        return message

    def result(self, rest: Any, kept: list[Handle]) -> Any:
        """What the call gave: `rest` is what crossed."""
        if self.method is None or not self.method.gives_memory or isinstance(rest, protocol.Odd):
            return rest
        if not self.method.whole:
            expected = self.method.size - len(kept)
            if not isinstance(rest, tuple) or len(rest) != expected:
                raise protocol.ProtocolError("a result of another form than was asked for")
        return self.method.together(kept, rest)


class Asks(Protocol):
    """Whoever passes a request on to the student's process."""

    def ask(self, request: Request) -> Any:
        """The result of a request."""
        ...


MAKE = Method("", 0, (), whole=True)  # of an object, nothing crosses


class Part:
    """A student's object. Calling one of its methods calls it in the student's process."""

    def __init__(self, answer: Asks, made: Handle, methods: Mapping[str, Method]) -> None:
        self._answer, self._made = answer, made
        for name, method in methods.items():
            setattr(self, name, partial(self._call, method))

    def _call(self, method: Method, *args: Any, **kwargs: Any) -> Any:
        request = Request(method.name, args, kwargs)
        request.thing, request.method = self._made, method
        return self._answer.ask(request)
