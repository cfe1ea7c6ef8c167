"""A submission's cells, run in a box, and its answers as callables that a judge can call.

A hang, a crash or a broken protocol costs the cell or the call that it happened in: the worker is started again and
the cells are replayed without the one that ended it. A budget of time bounds all of it.
"""

from __future__ import annotations

import builtins
import time
from collections.abc import Mapping
from types import TracebackType
from typing import Any, NamedTuple

import numpy as np

from grader import protocol, sandbox
from grader.channel import Channel, WorkerDied, WorkerLate
from grader.handles import MAKE, Handle, Ledger, Part, Request
from grader.protocol import ProtocolError
from grader.sandbox import Limits
from grader.worker import NAMES
from uavlab.exercises.classes import Method

MAX_FAULTS = 2  # hangs or crashes of one answer; then it is not called again


class Step(NamedTuple):
    """One thing to do in order: run a cell, or keep the answer that its check cell asks for."""

    cell: int
    source: str = ""
    keep: str = ""
    ours: bool = False  # the lab's own, before anything of the student's has run: no time of theirs


class Raised(Exception):
    """The student's function raised something that is not one of the usual errors."""


class ProcessEnded(Exception):
    """The student's process ended during the call (exit, crash, out of memory)."""


class TookTooLong(TimeoutError):
    """We stopped waiting. A type of our own: a student's function may raise TimeoutError itself."""


def _error(name: str) -> Exception:
    """The exception of this name, without the student's text."""
    import uavlab.errors

    if name not in NAMES:
        return Raised("an error of its own kind")
    if name == "LinAlgError":
        return np.linalg.LinAlgError("")
    if name == "CheckFailed":
        return Raised(name)  # it would speak for the judge
    if name == "UnknownName":
        return LookupError()  # which it is; its own text is not wanted
    kind = getattr(uavlab.errors, name, None) or getattr(builtins, name)
    if not issubclass(kind, Exception) or issubclass(kind, StopIteration):
        return Raised(name)  # SystemExit in the student's process is no exit of ours
    return kind()


class Answer:
    """A student's function or class. Calling it calls the student's process; only plain data crosses."""

    def __init__(self, remote: Remote, name: str, methods: Mapping[str, Method]) -> None:
        self._remote, self.__name__, self._methods = remote, name, methods
        self.faults: list[TookTooLong | ProcessEnded] = []

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        """Call it; raises what `Remote.call` does. A class gives an object with the methods that were asked for."""
        request = Request(self.__name__, args, kwargs)
        if not self._methods:
            return self.ask(request)
        request.method = MAKE
        return Part(self, self.ask(request), self._methods)

    def ask(self, request: Request) -> Any:
        """Pass a call on, as long as it is worth while."""
        if len(self.faults) >= MAX_FAULTS:
            raise type(self.faults[-1])("it is not called again")
        try:
            return self._remote.call(request)
        except (TookTooLong, ProcessEnded) as error:
            self.faults.append(error)
            raise


class Remote:
    """The student's side of one submission: cells that have run, answers that can be called.

    Parameters
    ----------
    steps : list of Step
        The code cells in order, and where an answer is kept.
    limits : Limits
        What the submission may use.
    place : int
        A number of its own among submissions graded at the same time.
    """

    def __init__(self, steps: list[Step], limits: Limits, place: int = 0) -> None:
        self._steps, self._limits, self._place = steps, limits, place
        self._channel: Channel | None = None
        self._ledger = Ledger()
        self._spent = 0.0  # [s] of the student's time
        self._began = (
            False  # whether a process has come up; what it takes again is the student's time
        )
        self.cpu = 0.0  # [s] used by the boxes that have ended
        self._skipped: set[int] = set()
        self.faults: dict[int, str] = {}  # cell → why it did not run through

    def __enter__(self) -> Remote:
        sandbox.demand()
        self._start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._channel is not None:
            self._channel.close()
            self.cpu += self._channel.cpu

    @property
    def left(self) -> float:
        """What is left of the submission's time [s]."""
        return max(0.0, self._limits.submission - self._spent)

    def answer(self, name: str, methods: Mapping[str, Method] | None = None) -> Answer:
        """The student's function of this name, or their class with these methods, to be judged."""
        return Answer(self, name, methods or {})

    def call(self, request: Request) -> Any:
        """Make one call.

        Raises
        ------
        TookTooLong
            No answer in time.
        ProcessEnded
            It ended its process, or broke the protocol.
        Lost
            It is given a memory that went with a process.
        Exception
            What the student's function raised, by class, without text.
        """
        arrays: list[np.ndarray] = []
        kept: list[Handle] = []
        try:
            channel = self._ready()
            message = request.message(arrays, self._ledger, kept)
            reply = self._timed(channel, message, self._limits.call)
            return request.result(_result(reply, arrays), kept)
        except WorkerLate:
            raise TookTooLong(self._late(self._limits.call)) from None
        except (WorkerDied, ProtocolError):
            self._drop()
            raise ProcessEnded(
                "the process that ran it ended (an exit, a crash, or out of memory)"
            ) from None

    # Running the cells -------------------------------------------------------------------------------

    def _ready(self) -> Channel:
        if self.left <= 0:
            raise WorkerLate
        if self._channel is None:
            self._start()
        if self._channel is None:
            raise WorkerLate
        return self._channel

    def _start(self) -> None:
        """Bring a worker up and replay the cells; a cell that ends it is left out the next time."""
        while self._channel is None and self.left > 0:
            channel = Channel(self._limits, self._place)
            for step in self._steps:
                spent = self._spent
                if not self._play(channel, step):
                    break
                if step.ours and not self._began:  # a busy machine imports slowly: nobody's fault
                    self._spent = spent
            else:
                self._channel = channel
                self._ledger.restart()
            self._began = True

    def _play(self, channel: Channel, step: Step) -> bool:
        if step.cell in self._skipped:
            return True
        if step.keep:
            message = {"op": "keep", "function": step.keep}
        else:
            message = {"op": "run", "cell": step.cell, "source": step.source}
        seconds = self._limits.start if step.ours else self._limits.cell
        try:
            reply = self._timed(channel, message, seconds)
        except WorkerLate:
            self.faults[step.cell] = self._late(seconds)
        except WorkerDied as error:
            self.faults[step.cell] = f"ended the process that ran it ({error})"
        else:
            if "raised" in reply:
                self.faults[step.cell] = _stopped(reply)
            return True
        self._skipped.add(step.cell)
        return False

    def _timed(self, channel: Channel, message: dict[str, Any], seconds: float) -> dict[str, Any]:
        began = time.monotonic()
        try:
            return channel.ask(message, min(seconds, self.left))
        except (WorkerLate, WorkerDied):
            self._channel = None
            self.cpu += channel.cpu
            raise
        finally:
            self._spent += time.monotonic() - began

    def _drop(self) -> None:
        if self._channel is not None:
            self._channel.end()
            self.cpu += self._channel.cpu
            self._channel = None

    def _late(self, seconds: float) -> str:
        if self.left <= 0:
            return f"the {self._limits.submission:g} s that a submission may take are used up"
        return f"no answer within {seconds:g} s"


def _stopped(reply: dict[str, Any]) -> str:
    name, line = reply["raised"], reply.get("line")
    where = f" in line {line}" if type(line) is int and 0 < line < 10_000 else ""
    return f"stopped with {name if name in NAMES else 'an error'}{where}"


def _result(reply: dict[str, Any], arrays: list[np.ndarray]) -> Any:
    """The value of a reply, after the changes that the call made to its arguments."""
    changed = reply.get("changed", [])
    if not isinstance(changed, list) or len(changed) > len(arrays):
        raise ProtocolError("changes of no known kind")
    for change in changed:
        _write_back(change, arrays)
    if "raised" in reply:
        raise _error(reply["raised"] if isinstance(reply["raised"], str) else "")
    if "odd" in reply:
        return protocol.Odd()
    return protocol.Decoder(widen=True).value(reply.get("value"))


def _write_back(change: Any, arrays: list[np.ndarray]) -> None:
    if not (isinstance(change, list) and len(change) == 2 and type(change[0]) is int):
        raise ProtocolError("a change of no known kind")
    index, data = change
    if not 0 <= index < len(arrays):
        raise ProtocolError("a change of an argument that is not there")
    value = protocol.Decoder(widen=True).value(data)
    target = arrays[index]
    if not isinstance(value, np.ndarray) or value.shape != target.shape:
        raise ProtocolError("a change of an argument's shape")
    if not target.flags.writeable:
        raise ValueError  # as it would be in one process
    target[...] = value
