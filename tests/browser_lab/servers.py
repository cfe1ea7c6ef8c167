"""Jupyter servers for tests: with a home of their own, found by the note they leave, gone at the end."""

import json
import os
import signal
import subprocess
import time
from contextlib import contextmanager
from urllib.parse import urlsplit

import psutil

START = 60.0  # [s] at most until a server answers
STOP = 30.0  # [s] at most until it and its kernels are gone

# No window opens, and pictures go into the notebook.
UNSET = {"DISPLAY", "WAYLAND_DISPLAY", "MPLBACKEND"}


@contextmanager
def serve(command, folder, *, cwd, environment=None):
    """Run a command that serves Jupyter on this computer; yields its address and its token.

    Parameters
    ----------
    command : list of str
        Starts the server, itself or as a child.
    folder : Path
        Takes what Jupyter keeps in a user's home, and the server's log.
    cwd : Path
        Where it runs.
    environment : mapping, optional
        Over the test's own.
    """
    runtime, log = folder / "runtime", folder / "server.log"
    runtime.mkdir(parents=True)
    own = {k: v for k, v in os.environ.items() if k not in UNSET}
    home = {
        "JUPYTER_RUNTIME_DIR": str(runtime),
        "JUPYTER_DATA_DIR": str(folder / "data"),
        "JUPYTER_CONFIG_DIR": str(folder / "config"),
        "JUPYTERLAB_SETTINGS_DIR": str(folder / "settings"),
        "JUPYTERLAB_WORKSPACES_DIR": str(folder / "workspaces"),
        "IPYTHONDIR": str(folder / "ipython"),
    }
    with log.open("wb") as out:
        process = subprocess.Popen(
            command,
            cwd=cwd,
            env={**own, **home, **(environment or {})},
            stdin=subprocess.DEVNULL,
            stdout=out,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
    try:
        yield _found(process, runtime, log)
    finally:
        _stop(process)


def _found(process, runtime, log):
    deadline = time.monotonic() + START
    while time.monotonic() < deadline:
        if process.poll() is not None:
            raise RuntimeError(f"the server ended with {process.returncode}:\n{log.read_text()}")
        for note in runtime.glob("jpserver-*.json"):
            try:
                server = json.loads(note.read_text())
            except ValueError:  # half written
                continue
            return server["url"], server["token"]
        time.sleep(0.1)
    raise TimeoutError(f"no server after {START:.0f} s:\n{log.read_text()}")


def _stop(process):
    """End a server as its terminal does when it is closed; it must take its kernels along."""
    if process.poll() is not None:
        return
    family = psutil.Process(process.pid).children(recursive=True)
    os.killpg(process.pid, signal.SIGTERM)
    _, left = psutil.wait_procs([psutil.Process(process.pid), *family], timeout=STOP)
    for child in left:
        child.kill()
    process.wait()
    assert not left, f"the server left processes behind: {left}"


def outside(requests):
    """Those of the addresses that are not on this computer."""
    parts = map(urlsplit, requests)
    here = {"127.0.0.1", "localhost", "::1"}
    return [
        p.geturl()
        for p in parts
        if p.scheme not in {"data", "blob", "about", "file"} and p.hostname not in here
    ]


def until(true, seconds=60.0, step=0.2):
    """Wait until `true()` is, and return what it was last."""
    deadline = time.monotonic() + seconds
    while not (found := true()) and time.monotonic() < deadline:
        time.sleep(step)
    return found
