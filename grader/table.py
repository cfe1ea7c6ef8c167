"""The class as a table of text."""

from __future__ import annotations

from collections.abc import Sequence

from grader.shell import Row


def class_table(rows: Sequence[Row]) -> str:
    """Students down, exercises across, then the total and a note; the exercises are numbered below.

    ``·`` stands for points that a person has still to give.
    """
    names = list(dict.fromkeys(name for row in rows for name in row.scores))
    head = ["student", *(str(i) for i in range(1, len(names) + 1)), "total", "note"]
    body = [_line(row, names) for row in rows]
    widths = [max(len(line[i]) for line in [head, *body]) for i in range(len(head) - 1)]
    lines = [_join(line, widths) for line in [head, *body]]
    lines.insert(1, "-" * max(map(len, lines)))
    return "\n".join([*lines, "", *_legend(rows, names)])


def _line(row: Row, names: Sequence[str]) -> list[str]:
    cells = [_points(row.scores.get(name, (None, 0.0))[0]) for name in names]
    waiting = f" +{row.waiting:g}·" if row.waiting else ""
    return [row.student, *cells, f"{row.total:g}/{row.most:g}{waiting}", row.note]


def _points(score: float | None) -> str:
    return "·" if score is None else f"{score:g}"


def _join(cells: Sequence[str], widths: Sequence[int]) -> str:
    first = cells[0].ljust(widths[0])
    middle = [x.rjust(w) for x, w in zip(cells[1:-1], widths[1:], strict=True)]
    return "  ".join([first, *middle, cells[-1]]).rstrip()


def _legend(rows: Sequence[Row], names: Sequence[str]) -> list[str]:
    points = {name: most for row in rows for name, (_, most) in row.scores.items()}
    return [f"{i:>3} {name} ({points[name]:g})" for i, name in enumerate(names, 1)]
