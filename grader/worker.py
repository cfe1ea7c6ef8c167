"""The untrusted side: runs a student's cells and calls their functions, inside the sandbox.

Nothing here decides anything. A student who takes over this process can change what their own functions
return, or end it. Started as ``python -c "from grader.worker import main; main()" SETTINGS`` by `grader.sandbox`.
"""

from __future__ import annotations

import base64
import ctypes
import json
import os
import resource
import sys
import types
from typing import Any

from grader import protocol, standins

_PR_SET_SECCOMP, _PR_SET_NO_NEW_PRIVS, _SECCOMP_MODE_FILTER = 22, 38, 2

# An exception crosses as one of these names: a name of the student's own choice could carry a hidden input out.
_NAMES = (
    "ArithmeticError AssertionError AttributeError BadFile BadInput CheckFailed EOFError FloatingPointError "
    "ImportError IndentationError IndexError KeyError KeyboardInterrupt LinAlgError LookupError MemoryError "
    "ModuleNotFoundError NameError NotImplementedError OSError OverflowError PermissionError RecursionError "
    "RuntimeError StopIteration SyntaxError SystemExit TabError TimeoutError TypeError UnboundLocalError "
    "UnicodeError UnknownName ValueError ZeroDivisionError"
)
NAMES = _NAMES.split()


class Namespace:
    """The student's notebook: one module that the cells share, and the answers kept from it."""

    def __init__(self) -> None:
        self.module = types.ModuleType("__main__")
        sys.modules["__main__"] = self.module
        self.kept: dict[str, Any] = {}
        self.held: dict[int, Any] = {}  # objects and memories, by the judge's numbers
        self.module.__dict__.update(standins.names(self.module.__dict__))

    def run(self, cell: int, source: str) -> None:
        """Execute one cell."""
        exec(compile(source, f"<cell {cell}>", "exec", dont_inherit=True), self.module.__dict__)

    def keep(self, name: str) -> bool:
        """Remember what `name` means now; later cells may use the name for something else."""
        found = self.module.__dict__.get(name)
        self.kept[name] = found
        return callable(found)

    def call(self, message: dict[str, Any]) -> dict[str, Any]:
        """Call an answer; say what it returned, and which of its array arguments it changed.

        The judge gives numbers to what stays here (``store``) and names it by them later (``thing``, ``held``).
        """
        for number in message.get("forget", ()):
            self.held.pop(number, None)
        decoder = protocol.Decoder(widen=False)
        args = [decoder.value(x) for x in message["arguments"][0]]
        kwargs = {k: decoder.value(v) for k, v in message["arguments"][1].items()}
        for place, number in message.get("held", ()):
            (args if isinstance(place, int) else kwargs)[place] = self.held[number]
        if "thing" in message:
            function = getattr(self.held[message["thing"]], message["function"])
        else:
            function = self.kept[message["function"]]
        result = function(*args, **kwargs)
        reply: dict[str, Any] = {}
        try:
            reply["value"] = protocol.encode(self._store(result, message.get("store")), [])
        except TypeError:
            reply["odd"] = True
        changed = [
            [i, protocol.encode(a, [])]
            for i, (a, raw) in enumerate(decoder.arrays)
            if a.tobytes() != raw
        ]
        if changed:
            reply["changed"] = changed
        return reply

    def _store(self, result: Any, store: list[Any] | None) -> Any:
        """Keep the memories of a result under their numbers; what is left of it crosses."""
        if store is None:
            return result
        size, places, numbers = store
        if size == 0:
            self.held[numbers[0]] = result
            return None
        if not isinstance(result, tuple | list) or len(result) != size:
            raise TypeError("a tuple of another length")
        self.held.update(zip(numbers, (result[i] for i in places), strict=True))
        return tuple(x for i, x in enumerate(result) if i not in places)


def _answer(namespace: Namespace, message: dict[str, Any]) -> dict[str, Any]:
    op = message["op"]
    if op == "run":
        namespace.run(message["cell"], message["source"])
        return {}
    if op == "keep":
        return {"value": namespace.keep(message["function"])}
    return namespace.call(message)


def _raised(error: BaseException) -> dict[str, Any]:
    """The error's class, by the nearest name that may cross, and the cell's line."""
    names = [kind.__name__ for kind in type(error).__mro__]
    name = next((n for n in names if n in NAMES), "Exception")
    line = getattr(error, "lineno", None) if isinstance(error, SyntaxError) else None
    trace = error.__traceback__
    while trace is not None:
        if trace.tb_frame.f_code.co_filename.startswith("<cell "):
            line = trace.tb_lineno
        trace = trace.tb_next
    return {"raised": name, "line": line if isinstance(line, int) else 0}


def _read(fd: int, count: int) -> bytes:
    data = b""
    while len(data) < count:
        more = os.read(fd, count - len(data))
        if not more:
            os._exit(0)  # the judge has gone; no handler of the student's runs
        data += more
    return data


def _write(fd: int, data: bytes) -> None:
    view = memoryview(data)
    while view:
        view = view[os.write(fd, view) :]


def _serve(into: int, out: int) -> None:
    namespace = Namespace()
    _write(out, protocol.pack({"nonce": "", "value": "ready"}))
    while True:
        message = json.loads(_read(into, protocol.length(_read(into, 4))))
        try:
            reply = _answer(namespace, message)
        except BaseException as error:  # SystemExit and KeyboardInterrupt too
            reply = _raised(error)
        reply["nonce"] = message["nonce"]
        try:
            frame = protocol.pack(reply)
        except protocol.ProtocolError:  # an answer larger than may cross
            frame = protocol.pack({"nonce": message["nonce"], "odd": True})
        _write(out, frame)


# What is given up before the first cell runs ----------------------------------------------------------


def _limit(settings: dict[str, Any]) -> None:
    for name, most in settings["limits"].items():
        resource.setrlimit(getattr(resource, name), (most, most))


def _become(uid: int | None) -> None:
    if uid is not None:
        os.setgroups([])
        os.setresgid(uid, uid, uid)
        os.setresuid(uid, uid, uid)


class _Program(ctypes.Structure):
    """struct sock_fprog: how many instructions of 8 bytes, and where."""

    _fields_ = (("length", ctypes.c_ushort), ("filter", ctypes.c_void_p))


def _filter(program: bytes) -> None:
    """Forbid the system calls of the filter, for good."""
    libc = ctypes.CDLL(None, use_errno=True)
    memory = ctypes.create_string_buffer(program, len(program))
    fprog = _Program(len(program) // 8, ctypes.cast(memory, ctypes.c_void_p).value)
    for arguments in (
        (_PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0),
        (_PR_SET_SECCOMP, _SECCOMP_MODE_FILTER, ctypes.byref(fprog), 0, 0),
    ):
        if libc.prctl(*arguments) != 0:
            raise OSError(ctypes.get_errno(), "prctl refused")


def main() -> None:
    """Give up every right that is not needed, say that we are ready, and serve."""
    settings = json.loads(sys.argv[1])
    into, out = os.dup(0), os.dup(1)
    _become(settings["uid"])
    _limit(settings)
    standins.install()
    protocol.records()  # imports what labs import, while that is still allowed
    _filter(base64.b64decode(settings["filter"]))
    null = os.open("/dev/null", os.O_RDWR)
    for fd in (0, 1, 2):  # what a student prints goes nowhere near the judge
        os.dup2(null, fd)
    sys.argv[:] = [""]
    _serve(into, out)
