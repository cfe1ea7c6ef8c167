"""The answers that experiments fly: the references, by name, through the one door to them."""

from __future__ import annotations

from typing import Any

from uavlab.errors import BadInput
from uavlab.flight.fill import reference


def answer(stem: str, name: str) -> Any:
    """The reference answer `name` of lab `stem`.

    Raises
    ------
    BadInput
        The answers are not installed.
    """
    found = reference(stem, name)
    if found is None:
        raise BadInput(
            f"{name} of lab {stem} is not installed; experiments fly the reference answers. "
            "Install them with: pip install uavlab-solutions"
        )
    return found
