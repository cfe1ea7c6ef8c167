"""Damaged, doubled, renamed, deleted and retyped cells; tampered points and metadata; what is no notebook."""

import json
import random

from grader.attacks import Target, attack, filled, lies, own, submit


def _text(notebook: dict) -> bytes:
    return json.dumps(notebook).encode()


@attack("damaging", deserves=True)
def checks_deleted(target: Target) -> bytes:
    """Right answers; every check cell is gone."""
    notebook = filled(target, target.right)
    notebook["cells"] = [c for c in notebook["cells"] if not c["id"].startswith("check-")]
    return _text(notebook)


@attack("damaging", deserves=True)
def ids_stripped(target: Target) -> bytes:
    """Right answers; a tool has thrown all cell ids and metadata away."""
    notebook = filled(target, target.right)
    for cell in notebook["cells"]:
        del cell["id"]
        cell["metadata"] = {}
    return _text(notebook | {"nbformat_minor": 4})


@attack("damaging", deserves=True)
def points_raised(target: Target) -> bytes:
    """Right answers; a thousand points each, and scores already filled in."""
    notebook = filled(target, target.right)
    for cell in notebook["cells"]:
        cell["metadata"]["nbgrader"] = cell["metadata"].get("nbgrader", {}) | {
            "points": 1000,
            "score": 1000,
        }
    return _text(notebook)


@attack("damaging", deserves=True)
def shuffled_and_doubled(target: Target) -> bytes:
    """Right answers; all cells in another order, and each twice."""
    notebook = filled(target, target.right)
    notebook["cells"] = notebook["cells"] + [dict(c) for c in notebook["cells"]]
    random.Random(1).shuffle(notebook["cells"])
    return _text(notebook)


@attack("damaging", deserves=True)
def answers_retyped(target: Target) -> bytes:
    """Right answers; in markdown cells, with types, outputs and attachments that do not fit."""
    notebook = filled(target, target.right)
    for cell in notebook["cells"]:
        if cell["id"].startswith("answer-"):
            cell.update(cell_type="markdown", outputs="none", execution_count=-1, attachments=[1])
    return _text(notebook)


@attack("damaging", deserves=True)
def answers_moved(target: Target) -> bytes:
    """Right answers; written in cells of one's own, the answer cells are deleted."""
    notebook = filled(target, target.right)
    for i, cell in enumerate(notebook["cells"]):
        if cell["id"].startswith("answer-"):
            notebook["cells"][i] = own(cell["source"])
    return _text(notebook)


@attack("damaging")
def checks_replaced(target: Target) -> bytes:
    """The check cells hold a pass, and outputs with full marks."""
    notebook = filled(target, lies(target))
    full = {
        "output_type": "execute_result",
        "execution_count": 1,
        "metadata": {},
        "data": {"text/plain": "5"},
    }
    for cell in notebook["cells"]:
        if cell["id"].startswith("check-"):
            cell.update(source="pass", outputs=[full])
            cell["metadata"]["nbgrader"].update(locked=False, solution=True)
    return _text(notebook)


@attack("damaging")
def checks_impersonated(target: Target) -> bytes:
    """Cells of one's own carry the grade ids of checks, and answers those of other cells."""
    notebook = filled(target, lies(target))
    for cell in list(notebook["cells"]):
        if cell["id"].startswith("check-"):
            notebook["cells"].append({
                **own("1000"),
                "id": cell["id"],
                "metadata": cell["metadata"],
            })
        if cell["id"].startswith("answer-"):
            cell["metadata"]["nbgrader"]["grade_id"] = "check-" + cell["id"].removeprefix("answer-")
    return _text(notebook)


@attack("damaging")
def wild_metadata(target: Target) -> bytes:
    """Every field has a type that it must not have."""
    notebook = filled(target, lies(target))
    values = [None, 1, [], {}, "x", [1], {"grade_id": {}}, float("nan"), True]
    for i, cell in enumerate(notebook["cells"]):
        cell["metadata"] = {
            "nbgrader": values[i % len(values)],
            "tags": values[(i + 1) % len(values)],
        }
        if i % 3 == 0:
            cell["source"] = values[i % len(values)]
        if i % 5 == 0:
            cell["id"] = values[i % len(values)]
    notebook["cells"] += values
    return _text(
        notebook
        | {
            "metadata": {
                "uavlab_graft": {"readable": True, "notes": 7},
                "kernelspec": {"name": "bash"},
            }
        }
    )


@attack("damaging")
def huge_cells(target: Target) -> bytes:
    """An answer of five megabytes, and five thousand cells of one's own."""
    answers = lies(target)
    answers[next(iter(answers))] = "#" * 5_000_000
    notebook = filled(target, answers)
    notebook["cells"] += [own("x = 1") for _ in range(5_000)]
    return _text(notebook)


@attack("damaging")
def cut_in_half(target: Target) -> bytes:
    """An upload that lost its second half."""
    whole = submit(target, target.right)
    return whole[: len(whole) // 2]


@attack("damaging")
def not_json(target: Target) -> bytes:
    """A picture under the notebook's name."""
    return b"\x89PNG\r\n\x1a\n" + bytes(range(256)) * 40


@attack("damaging")
def nested_json(target: Target) -> bytes:
    """Two million brackets."""
    return b"[" * 1_000_000 + b"]" * 1_000_000


@attack("damaging")
def old_format(target: Target) -> bytes:
    """A notebook of format 3."""
    return _text({
        "nbformat": 3,
        "nbformat_minor": 0,
        "metadata": {},
        "worksheets": [{"cells": []}],
    })
