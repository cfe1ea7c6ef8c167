"""Start the course: make an environment beside this file, once, and open JupyterLab."""

import json
import os
import subprocess
import sys
import venv
from pathlib import Path

HERE = Path(__file__).resolve().parent
HOME = HERE / ".venv"
PYTHON = HOME / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
READY = HOME / "ready"


def install() -> None:
    """Make the environment, and install the wheel and JupyterLab into it."""
    print("Making the environment. This takes a few minutes, the first time only.", flush=True)
    venv.create(HOME, with_pip=True, clear=True)
    wheel = next(HERE.glob("uavlab-*.whl"))
    pip = [str(PYTHON), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*pip, f"{wheel}[lab]", "-c", str(HERE / "constraints.txt")], check=True)
    settings = HOME / "etc" / "jupyter" / "labconfig" / "page_config.json"
    settings.parent.mkdir(parents=True, exist_ok=True)
    off = {"@jupyterlab/apputils-extension:announcements": True}
    settings.write_text(json.dumps({"disabledExtensions": off}))
    READY.touch()


def main() -> int:
    """Install what is missing, then serve this folder on this computer only."""
    if sys.version_info < (3, 11):  # noqa: UP036 (this file runs before the right Python is found)
        print(f"Python 3.11 or newer is needed; this is {sys.version.split()[0]}.")
        return 2
    if not READY.exists():
        install()
    jupyterlab = [str(PYTHON), "-m", "jupyterlab", "--ip=127.0.0.1", str(HERE)]
    try:
        return subprocess.call([*jupyterlab, *sys.argv[1:]])
    except KeyboardInterrupt:
        return 0


if __name__ == "__main__":
    sys.exit(main())
