"""JupyterLab as a student sees it: the released notebook, the Validate button, and nothing that distracts."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from grader.build_lab import Lab

# nbgrader's panels for teachers, and those for a class server that is not here. Validate stays.
PANELS = ("create-assignment", "formgrader", "course-list", "assignment-list", "menu")
SERVER_PARTS = ("formgrader", "course_list", "assignment_list")


def open_lab(course: Path, lab: Lab, *, student: Path | None = None) -> int:
    """Serve the student's notebook of `lab` on this computer until it is interrupted.

    Returns
    -------
    int
        JupyterLab's exit code.
    """
    home = student or course.parent / "student"
    notebook = fresh_copy(course / "release" / lab.name, home)
    print(f"build: {notebook} opens in JupyterLab; stop it here with Ctrl-C", flush=True)
    command, environment = jupyterlab(home, notebook)
    try:
        return subprocess.call(command, env={**os.environ, **environment})
    except KeyboardInterrupt:
        return 0


def fresh_copy(released: Path, home: Path) -> Path:
    """Copy a released folder below `home`, unless it is there: a student's work is never overwritten."""
    target = home / released.name
    if target.exists():
        print(
            f"build: your work in {target} is kept; delete that folder to begin again", flush=True
        )
    else:
        shutil.copytree(released, target)
    return next(target.glob("*.ipynb"))


def jupyterlab(
    home: Path, notebook: Path, *, port: int | None = None
) -> tuple[list[str], Mapping[str, str]]:
    """The command that serves `notebook`, and what to add to its environment.

    Parameters
    ----------
    home : Path
        The folder that is served.
    notebook : Path
        Below `home`; opened first.
    port : int, optional
        Else Jupyter takes a free one.
    """
    settings = home.resolve().parent / "jupyter"
    page = "/lab/tree/" + notebook.resolve().relative_to(home.resolve()).as_posix()
    _write(settings / "jupyter_server_config.json", _server(home, page, port))
    _write(settings / "labconfig" / "page_config.json", {"disabledExtensions": _disabled()})
    command = [sys.executable, "-m", "jupyterlab"]
    if not _can_show():
        command.append("--no-browser")
    return command, {"JUPYTER_CONFIG_DIR": str(settings)}


def _server(home: Path, page: str, port: int | None) -> dict[str, Any]:
    server: dict[str, Any] = {
        "ip": "127.0.0.1",  # the token stays Jupyter's own, new at each start
        "root_dir": str(home.resolve()),
        "allow_root": hasattr(os, "getuid") and os.getuid() == 0,
        "jpserver_extensions": {f"nbgrader.server_extensions.{x}": False for x in SERVER_PARTS},
    }
    if port is not None:
        server |= {"port": port, "port_retries": 0}
    return {
        "ServerApp": server,
        # No request leaves this computer: no news, no updates, no extension catalogue.
        "LabApp": {
            "default_url": page,  # also in the address that is printed for those without a screen
            "news_url": None,
            "check_for_updates_class": "jupyterlab.NeverCheckForUpdate",
            "extension_manager": "readonly",
        },
    }


def _disabled() -> dict[str, bool]:
    names = [f"@jupyter/nbgrader:{x}" for x in PANELS]
    return dict.fromkeys(["@jupyterlab/apputils-extension:announcements", *names], True)


def _can_show() -> bool:
    """Whether a browser would find a screen."""
    if sys.platform in {"darwin", "win32"}:
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _write(path: Path, settings: Mapping[str, Any]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(settings, indent=2) + "\n", encoding="utf-8")
