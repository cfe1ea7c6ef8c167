"""Programs that came with our packages, found also where the environment is not activated."""

from __future__ import annotations

import os
import sys
from pathlib import Path


def offer_programs() -> None:
    """Put this environment's programs on the path: nbgrader runs ``alembic`` to make its gradebook."""
    here = str(Path(sys.executable).parent)
    if here not in os.environ.get("PATH", "").split(os.pathsep):
        os.environ["PATH"] = os.pathsep.join([here, os.environ.get("PATH", "")])
