"""The box around a student's process: bubblewrap, an own user, limits, and a system-call filter.

Inside there is the interpreter, its packages, the library without its solutions, and an empty folder /tmp that
forgets. There is no network, no other process, no /proc, no home, no course. Where any of it is missing nothing is
graded: see `available`.
"""

from __future__ import annotations

import base64
import importlib.util
import json
import os
import shutil
import subprocess
import sys
import sysconfig
from functools import cache
from pathlib import Path
from typing import NamedTuple

from grader import seccomp

FIRST_UID = 61_000  # workers of a grader that is root; no account of Debian's has these numbers
INSTALL = "Install it with: sudo apt-get install bubblewrap libseccomp2"
_BOX = "/box"
_INSIDE = ("__init__.py", "protocol.py", "worker.py", "standins.py")
_ROOM = Path(__file__).resolve().parent


class Limits(NamedTuple):
    """What one submission may use."""

    call: float = 2.0  # [s] of one call of an answer
    cell: float = 5.0  # [s] of one cell
    submission: float = 30.0  # [s] of everything that a submission runs, restarts included
    start: float = 20.0  # [s] for a process to come up; not the student's time
    memory: int = 2 * 2**30  # bytes of address space
    disk: int = 16 * 2**20  # bytes in /tmp


class SandboxMissing(RuntimeError):
    """Student code cannot be isolated on this machine; the message says what to install."""


# The view from inside -------------------------------------------------------------------------------


def _library() -> Path:
    """The folder of the library, found without importing it."""
    spec = importlib.util.find_spec("uavlab")
    if spec is None or spec.origin is None:
        raise SandboxMissing("uavlab is not installed: run make setup.")
    return Path(spec.origin).resolve().parent


def _interpreter() -> list[Path]:
    """What the interpreter itself needs from the disk."""
    base = Path(sys.base_prefix).resolve()
    executable = Path(sys.executable).resolve()
    system = [Path(p) for p in ("/usr/lib", "/usr/lib64", "/usr/local/lib", "/etc/ld.so.cache")]
    own = [base] if base not in (Path("/usr"), Path("/usr/local")) else [executable]
    return [p for p in [*system, *own] if p.exists()]


def _packages() -> list[Path]:
    """Where installed packages are."""
    paths = {Path(sysconfig.get_path(name)).resolve() for name in ("purelib", "platlib")}
    distribution = Path("/usr/lib/python3/dist-packages")
    return sorted(p for p in paths if p.exists() and p != distribution)


def _links() -> list[str]:
    """/lib and its like: links on a merged system, folders on an older one."""
    arguments: list[str] = []
    for path in (Path("/lib"), Path("/lib64")):
        if path.is_symlink():
            arguments += ["--symlink", os.readlink(path), str(path)]
        elif path.exists():
            arguments += ["--ro-bind", str(path), str(path)]
    return arguments


def _bind(source: Path, target: str, made: set[str]) -> list[str]:
    """Show `source` at `target`, read-only, below folders that another user may pass."""
    arguments: list[str] = []
    for parent in [str(p) for p in reversed(Path(target).parents)][1:]:
        if parent not in made:
            arguments += ["--perms", "0755", "--dir", parent]
            made.add(parent)
    return [*arguments, "--ro-bind", str(source), target]


def _installed(shown: Path) -> list[Path]:
    """Other installations of the course below a folder that is shown: their solutions, their hidden checks."""
    found = [shown / name for name in ("uavlab", "grader")]
    for below in ("*-packages", "python3*/*-packages", "*/python3*/*-packages"):
        for name in ("uavlab", "grader"):
            found += shown.glob(f"{below}/{name}")
    return [p for p in found if p.is_dir() and shown.resolve() in p.resolve().parents]


def _mask() -> list[str]:
    """Cover what must not be read although a folder around it is shown."""
    library = _library()
    hidden: list[str] = []
    if (library / "solutions").exists():
        hidden.append(f"{_BOX}/uavlab/solutions")
    for shown in [*_packages(), *_interpreter()]:
        for secret in (library / "solutions", _ROOM):
            if secret.exists() and shown in secret.parents:
                hidden.append(str(secret))
        hidden += map(str, _installed(shown))
    return [x for path in sorted(set(hidden)) for x in ("--size", "4096", "--tmpfs", path)]


def _view(limits: Limits) -> list[str]:
    # First /tmp, then what is shown: the checkout itself may lie below /tmp.
    arguments = ["--size", str(limits.disk), "--perms", "1777", "--tmpfs", "/tmp"]
    made = {"/tmp"}
    shown: set[Path] = set()
    for path in [*_interpreter(), *_packages()]:
        if not any(p == path or p in path.parents for p in shown):
            arguments += _bind(path, str(path), made)
            shown.add(path)
    arguments += _bind(_library(), f"{_BOX}/uavlab", made)
    for name in _INSIDE:
        arguments += _bind(_ROOM / name, f"{_BOX}/grader/{name}", made)
    arguments += [*_links(), *_mask(), "--perms", "0755", "--dir", "/dev"]
    for device in ("null", "zero", "urandom", "random"):
        arguments += ["--dev-bind", f"/dev/{device}", f"/dev/{device}"]
    return [*arguments, "--remount-ro", "/", "--chdir", "/tmp"]


# The command ----------------------------------------------------------------------------------------


def _rights(root: bool) -> list[str]:
    """A root grader keeps two capabilities until the worker has changed its user; others get a user namespace."""
    common = "--unshare-ipc --unshare-pid --unshare-net --unshare-uts --unshare-cgroup-try"
    arguments = [*common.split(), "--die-with-parent", "--new-session", "--clearenv"]
    arguments += ["--hostname", "box", "--cap-drop", "ALL"]
    if root:
        return [*arguments, "--cap-add", "CAP_SETUID", "--cap-add", "CAP_SETGID"]
    return [*arguments, "--unshare-user", "--uid", "65534", "--gid", "65534"]


_ENVIRONMENT = {
    "HOME": "/tmp",
    "LANG": "C.UTF-8",
    "PATH": "/nonexistent",
    "PYTHONDONTWRITEBYTECODE": "1",
    "PYTHONHASHSEED": "0",
    "OPENBLAS_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
}


def _settings(limits: Limits, place: int, root: bool) -> str:
    seconds = int(limits.submission + limits.start) + 1
    rlimits = {
        "RLIMIT_CORE": 0,
        "RLIMIT_CPU": seconds,
        "RLIMIT_AS": limits.memory,
        "RLIMIT_FSIZE": limits.disk,
        "RLIMIT_NOFILE": 64,
        "RLIMIT_NPROC": 16,
        "RLIMIT_MEMLOCK": 0,
        "RLIMIT_MSGQUEUE": 0,
    }
    uid = FIRST_UID + place if root else None
    code = base64.b64encode(seccomp.program()).decode()
    return json.dumps({"uid": uid, "limits": rlimits, "filter": code})


def command(limits: Limits, place: int) -> list[str]:
    """The command line of one boxed worker; `place` numbers those that run at the same time."""
    root = os.geteuid() == 0
    environment = [x for pair in _ENVIRONMENT.items() for x in ("--setenv", *pair)]
    path = [_BOX, *(str(p) for p in _packages())]
    python = [str(Path(sys.executable).resolve()), "-S", "-s", "-P", "-c"]
    code = f"import sys; sys.path[:0] = {path!r}; from grader.worker import main; main()"
    bwrap = shutil.which("bwrap")
    if bwrap is None:
        raise SandboxMissing(f"bubblewrap (bwrap) is not installed. {INSTALL}")
    view = [bwrap, *_rights(root), *environment, *_view(limits)]
    return [*view, *python, code, _settings(limits, place, root)]


def start(limits: Limits, place: int = 0) -> subprocess.Popen[bytes]:
    """A boxed worker, with pipes to its protocol."""
    pipe = subprocess.PIPE
    return subprocess.Popen(
        command(limits, place), stdin=pipe, stdout=pipe, stderr=pipe, env={}, cwd="/", bufsize=0
    )


# Is it there? ---------------------------------------------------------------------------------------


def _cure(said: str) -> str:
    if "ModuleNotFoundError" in said:
        return "A package that the worker needs cannot be seen from the box: run make setup again."
    if "uid map" in said or "namespace" in said.lower() or "Permission denied" in said:
        return (
            "This machine does not let bubblewrap make namespaces. On Ubuntu 24.04 AppArmor forbids it to programs "
            "without a profile: install one for /usr/bin/bwrap with `sudo apt-get install apparmor-profiles` and "
            "`sudo ln -s /usr/share/apparmor/extra-profiles/bwrap-userns-restrict /etc/apparmor.d/`, then "
            "`sudo systemctl reload apparmor`; in a container, allow user namespaces (CAP_SYS_ADMIN)."
        )
    return INSTALL


@cache
def available() -> str | None:
    """None if student code can be isolated here; else what is missing and what to do.

    Tries the real thing once: a boxed worker must come up.
    """
    if not sys.platform.startswith("linux"):
        return f"Grading needs Linux (bubblewrap); this is {sys.platform}. Use a virtual machine or WSL 2."
    if shutil.which("bwrap") is None:
        return f"bubblewrap (bwrap) is not installed. {INSTALL}"
    try:
        seccomp.program()
    except RuntimeError as error:
        return f"{error}. {INSTALL}, and the packages of requirements.lock."
    process = start(Limits())
    try:
        out, errors = process.communicate(timeout=60)
        said = errors.decode(errors="replace").strip()
    except subprocess.TimeoutExpired:
        process.kill()
        out, said = b"", "it did not answer within 60 s"
    if b"ready" in out:
        return None
    return f"The sandbox does not start: {said[-500:]}. {_cure(said)}"


def demand() -> None:
    """Go on only if student code can be isolated.

    Raises
    ------
    SandboxMissing
        It cannot; the message is `available`'s.
    """
    missing = available()
    if missing:
        raise SandboxMissing(missing)
