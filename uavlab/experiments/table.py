"""How rows are told, on a terminal and in the book: numbers to the digits that their band deserves, and a verdict."""

from __future__ import annotations

from math import inf, isfinite

from uavlab.experiments.spec import Band, Row

HEAD = ("quantity", "paper", "ours", "band", "verdict")


def cells(row: Row) -> tuple[str, str, str, str, str]:
    """The five cells of a row, as in `HEAD`."""
    ours = number(row.ours)
    if row.spread is not None:
        ours += f" ± {number(row.spread)}"
    return row.quantity, row.paper or "—", ours, band(row.band), verdict(row)


def verdict(row: Row) -> str:
    """One word on a row."""
    return {True: "met", False: "NOT MET", None: "told"}[row.met]


def band(x: Band | None) -> str:
    """A band as one reads it."""
    if x is None:
        return "—"
    low, high = x
    if low == -inf:
        return f"≤ {number(high)}"
    if high == inf:
        return f"≥ {number(low)}"
    return f"{number(low)} to {number(high)}"


def number(x: float) -> str:
    """A number to four digits, without a power of ten where none is needed."""
    if not isfinite(x):
        return str(x)
    if x == 0.0 or 1e-3 <= abs(x) < 1e5:
        return f"{x:.4g}"
    return f"{x:.2e}"
