"""One boxed worker seen from the judge's side: ask, get a checked reply in time, or end it."""

from __future__ import annotations

import contextlib
import os
import select
import signal
import subprocess
import time
from pathlib import Path
from typing import Any

from grader import protocol, sandbox
from grader.protocol import ProtocolError


class WorkerDied(Exception):
    """The student's process ended, or was ended because it broke the protocol."""


class WorkerLate(Exception):
    """The student's process did not answer in time; it has been ended."""


class Channel:
    """A worker process and the two pipes to it."""

    def __init__(self, limits: sandbox.Limits, place: int = 0) -> None:
        self._process: subprocess.Popen[bytes] = sandbox.start(limits, place)
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._into = self._process.stdin.fileno()
        self._out = self._process.stdout.fileno()
        for fd in (self._into, self._out):
            os.set_blocking(fd, False)
        self._readable, self._writable = select.poll(), select.poll()
        self._readable.register(self._out, select.POLLIN)
        self._writable.register(self._into, select.POLLOUT)
        self._buffer = b""
        self.cpu = 0.0  # [s] used by the box, known once it has ended
        try:
            self._receive("", time.monotonic() + limits.start)
        except WorkerDied:
            raise sandbox.SandboxMissing(f"the sandbox did not start: {self._said()}") from None

    def ask(self, message: dict[str, Any], seconds: float) -> dict[str, Any]:
        """Send a request and return its reply.

        Raises
        ------
        WorkerDied
            The process ended or sent something that is not the reply to this request.
        WorkerLate
            No reply within `seconds`.
        """
        deadline = time.monotonic() + seconds
        nonce = os.urandom(8).hex()
        self._send(protocol.pack({**message, "nonce": nonce}), deadline)
        return self._receive(nonce, deadline)

    def end(self) -> None:
        """Kill the process and everything in its box. Safe to call twice."""
        process = self._process
        if process.returncode is None:
            self._farewell(process)
        for stream in (process.stdin, process.stdout, process.stderr):
            if stream is not None:
                stream.close()

    def close(self, seconds: float = 0.5) -> None:
        """Let an idle worker leave by itself, so that its CPU time is counted; then make sure."""
        if self._process.returncode is None and self._process.stdin is not None:
            self.cpu = _cpu(self._process.pid)
            self._process.stdin.close()
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._process.wait(seconds)
        self.end()

    def _farewell(self, process: subprocess.Popen[bytes]) -> None:
        self.cpu = self.cpu or _cpu(process.pid)
        # bwrap dies with us (--die-with-parent), its first process with bwrap, and with that the whole PID namespace.
        process.send_signal(signal.SIGKILL)
        process.wait()

    def _said(self) -> str:
        stream = self._process.stderr
        self._process.kill()
        text = stream.read().decode(errors="replace").strip() if stream is not None else ""
        self.end()
        return text[-500:] or "it said nothing"

    def _send(self, frame: bytes, deadline: float) -> None:
        view = memoryview(frame)
        while view:
            try:
                view = view[os.write(self._into, view) :]
            except BlockingIOError:
                self._wait(self._writable, deadline)
            except OSError:
                self.end()
                raise WorkerDied("it ended") from None

    def _wait(self, poll: select.poll, deadline: float) -> None:
        left = deadline - time.monotonic()
        if left <= 0 or not poll.poll(1000 * left):
            self.end()
            raise WorkerLate

    def _receive(self, nonce: str, deadline: float) -> dict[str, Any]:
        try:
            size = protocol.length(self._exactly(4, deadline))
            reply = protocol.unpack(self._exactly(size, deadline))
            if reply.get("nonce") != nonce:
                raise ProtocolError("a reply to another request")
        except ProtocolError as error:
            self.end()
            raise WorkerDied(f"it broke the protocol: {error}") from None
        return reply

    def _exactly(self, count: int, deadline: float) -> bytes:
        parts, missing = [], count
        while missing:
            if not self._buffer:
                self._buffer = self._more(deadline)
            parts.append(self._buffer[:missing])
            self._buffer = self._buffer[missing:]
            missing -= len(parts[-1])
        return b"".join(parts)

    def _more(self, deadline: float) -> bytes:
        while True:
            self._wait(self._readable, deadline)
            try:
                data = os.read(self._out, 65536)
            except BlockingIOError:
                continue
            except OSError:
                data = b""
            if not data:
                self.end()
                raise WorkerDied("it ended")
            return data


def _cpu(pid: int) -> float:
    """CPU time [s] of a process and those below it: bwrap does not hand it on to us when it ends."""
    try:
        stat = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        below = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    except OSError:
        return 0.0
    own = (int(stat[11]) + int(stat[12])) / os.sysconf("SC_CLK_TCK")
    return own + sum(_cpu(int(child)) for child in below)
