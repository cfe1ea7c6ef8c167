"""Sliders beside a picture: move one, let go, and the flight is flown again.

They need ipywidgets and a notebook that somebody looks at. Everywhere else (scripts, the book, tests) the picture is
drawn once, with the values that the sliders would start from.
"""

from __future__ import annotations

import base64
import importlib.util
import io
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from uavlab.errors import BadInput

STEPS = 50  # between the ends of a slider that names no step of its own


class Drawn(NamedTuple):
    """A figure that a notebook shows once and pyplot forgets, or words in its place."""

    value: Any  # the figure itself
    png: bytes = b""
    said: str = "a figure"  # in words

    def __repr__(self) -> str:
        return self.said

    def _repr_mimebundle_(self, **_: Any) -> dict[str, str]:
        picture = {"image/png": base64.b64encode(self.png).decode("ascii")} if self.png else {}
        return {"text/plain": self.said, **picture}


class Control(NamedTuple):
    """One thing that can be changed."""

    name: str
    start: Any
    low: float | None = None  # of a slider; None: it is a choice
    high: float | None = None
    step: float | None = None
    choices: tuple[Any, ...] = ()


def sliders(draw: Callable[..., Any], **controls: Any) -> Any:
    """Draw with values that can be changed by hand. Make it the last line of a cell.

    Parameters
    ----------
    draw : callable
        Takes the controls by name, and returns a figure or anything else that a notebook shows. It is called again
        each time a slider is let go.
    **controls : tuple, list or bool
        ``(low, high, start)`` or ``(low, high, start, step)``: a slider, of whole numbers if all are whole; a list: a
        choice, the first of it at the start; True or False: a box to tick.

    Returns
    -------
    box, Drawn or object
        The sliders, below the picture. Where nobody could move them, what was drawn: a figure as the `value` of a
        `Drawn`, anything else as it is.

    Raises
    ------
    BadInput
        A control that is none of these, or whose start lies outside its ends.
    """
    known = tuple(_control(name, given) for name, given in controls.items())
    start = {x.name: x.start for x in known}
    if known and _watched():
        return _live(draw, known)
    said = ", ".join(f"{name} = {value}" for name, value in start.items())
    print(
        f"Drawn once, with {said or 'nothing to change'}: sliders need ipywidgets and JupyterLab."
    )
    return _drawn(draw, start)


def _control(name: str, given: Any) -> Control:
    """What was asked for by this name."""
    if isinstance(given, bool):
        return Control(name, given)
    if isinstance(given, list) and given:
        return Control(name, given[0], choices=tuple(given))
    if isinstance(given, tuple) and len(given) in {3, 4} and all(_number(x) for x in given):
        return _slider(name, *given)
    raise BadInput(
        f"control {name} is {given!r}; give (low, high, start) or (low, high, start, step), a list of choices, "
        "or True or False."
    )


def _number(x: Any) -> bool:
    return isinstance(x, int | float) and not isinstance(x, bool) and abs(x) < float("inf")


def _slider(name: str, low: float, high: float, start: float, step: float | None = None) -> Control:
    if not (low < high and low <= start <= high):
        raise BadInput(f"control {name}: low {low}, start {start} and high {high} must grow.")
    if step is not None and step <= 0:
        raise BadInput(f"control {name}: its step is {step}; it must be > 0.")
    whole = all(isinstance(x, int) for x in (low, high, start, 1 if step is None else step))
    return Control(name, start, low, high, step or (1 if whole else (high - low) / STEPS))


def _watched() -> bool:
    """Whether somebody can move a slider: a notebook in a browser, and ipywidgets.

    JupyterLab says with each request which cell it runs; what runs notebooks for the book or for a test does not.
    """
    if (
        importlib.util.find_spec("ipywidgets") is None
        or importlib.util.find_spec("IPython") is None
    ):
        return False
    from IPython import get_ipython

    kernel = getattr(get_ipython(), "kernel", None)
    if kernel is None:
        return False
    return "cellId" in (kernel.get_parent().get("metadata") or {})


def _live(draw: Callable[..., Any], controls: Sequence[Control]) -> Any:
    """The picture, then the sliders below it."""
    import ipywidgets
    from IPython.display import display

    widgets = {x.name: _widget(ipywidgets, x) for x in controls}

    def now() -> dict[str, Any]:
        return {name: widget.value for name, widget in widgets.items()}

    shown: Any = display(_drawn(draw, now()), display_id=True)

    def again(_: Any) -> None:
        shown.update(_safely(draw, now()))

    for widget in widgets.values():
        widget.observe(again, names="value")
    return ipywidgets.VBox(list(widgets.values()))


def _widget(ipywidgets: Any, control: Control) -> Any:
    look = {"description": control.name, "style": {"description_width": "initial"}}
    if control.choices:
        return ipywidgets.Dropdown(options=control.choices, value=control.start, **look)
    if control.low is None:
        return ipywidgets.Checkbox(value=control.start, **look)
    whole = all(isinstance(x, int) for x in control[1:5])
    kind = ipywidgets.IntSlider if whole else ipywidgets.FloatSlider
    return kind(
        value=control.start, min=control.low, max=control.high, step=control.step,
        continuous_update=False, readout_format="d" if whole else ".3g",
        layout={"width": "28em"}, **look,
    )  # fmt: skip


def _drawn(draw: Callable[..., Any], values: Mapping[str, Any]) -> Any:
    """What `draw` gives; of a figure its picture, so that no notebook shows it twice."""
    value = draw(**values)
    if not hasattr(value, "savefig"):
        return value
    import matplotlib.pyplot as plt

    buffer = io.BytesIO()
    value.savefig(buffer, format="png", dpi=90)
    plt.close(value)
    return Drawn(value, buffer.getvalue())


def _safely(draw: Callable[..., Any], values: Mapping[str, Any]) -> Any:
    """The same, or what went wrong in words: an error after the cell has run would be seen by nobody."""
    try:
        return _drawn(draw, values)
    except Exception as error:
        return Drawn(None, said=f"{type(error).__name__}: {error}")
