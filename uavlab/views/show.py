"""A replay inside a notebook: a frame that points at a page beside the notebook, and a still picture under it."""

from __future__ import annotations

import base64
import html
import io
import os
from pathlib import Path
from typing import Any, NamedTuple

from uavlab.views import style
from uavlab.views.cast import cast
from uavlab.views.picture import picture
from uavlab.views.replay import Logs, replay


class Shown(NamedTuple):
    """What a notebook displays: the replay's page in a frame, by its relative path, and the picture below."""

    page: Path  # as seen from the notebook
    png: bytes  # the still picture
    title: str
    height: int  # [px] of the frame

    def _repr_html_(self) -> str:
        name = html.escape(self.title, quote=True)
        data = base64.b64encode(self.png).decode("ascii")
        address = html.escape(self.page.as_posix(), quote=True)
        return (
            f'<iframe src="{address}" title="replay: {name}" width="100%" height="{self.height}" loading="lazy" '
            'style="border: 1px solid #ccc; border-radius: 6px" allowfullscreen></iframe>'
            f'<div><a href="{address}" target="_blank">open the replay in a window of its own</a></div>'
            f'<img alt="picture: {name}" src="data:image/png;base64,{data}" style="max-width: 100%">'
        )

    def _repr_png_(self) -> bytes:
        return self.png


def show(
    logs: Logs, *, folder: str | os.PathLike[str] = "replays", height: int = 460, **options: Any
) -> Shown:
    """Replay flights in a notebook. Make it the last line of a cell.

    Parameters
    ----------
    logs : Log, or several, or a mapping of label to Log
        As in `replay`.
    folder : path-like
        Where page and picture are written, seen from the notebook.
    height : int
        Of the frame [px].
    **options
        As in `replay`: `target`, `thrusts`.
    """
    import matplotlib.pyplot as plt

    flights = cast(logs)
    figure = picture(flights)
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=80)
    plt.close(figure)
    # Jupyter serves files into a sandbox that gets no cookies: a page there can load nothing from beside it.
    page = replay(flights, folder=folder, alone=True, **options)
    page.with_suffix(".png").write_bytes(buffer.getvalue())  # for browsers without WebGL
    return Shown(page, buffer.getvalue(), style.title(next(iter(flights.values()))), height)
