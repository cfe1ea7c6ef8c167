"""The answer cell: the exercise's stub outside, the reference's body inside BEGIN/END SOLUTION; of a class, each body.

What the reference uses of its own module (a constant, a helper) comes along, above it; what it imports must be imported
by the lab, since a student has to be able to write the same. The answers of a lab may fill several files,
``<stem>.py`` and ``<stem>_*.py``; a notebook has one room for all of them, so no two helpers may share a name.
"""

from __future__ import annotations

import ast
import builtins
import importlib
import symtable
import textwrap
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple, TypeGuard

from grader.build_lab import Cell, Lab, plain_python
from uavlab.errors import BadFile
from uavlab.exercises import Exercise

BEGIN, END = "### BEGIN SOLUTION", "### END SOLUTION"

Definition = ast.FunctionDef | ast.ClassDef


class Room(NamedTuple):
    """One file of answers."""

    path: Path
    text: str
    tree: ast.Module


def instructor_answer(lab: Lab, exercise: Exercise) -> str:
    """The stub of `exercise` with the body of the reference answer in its marked region.

    Raises
    ------
    BadFile
        The reference is missing, or its signature is not the stub's.
    """
    rooms = _parse(lab)
    defined = {
        x.name: (room, x) for room in rooms for x in room.tree.body if isinstance(x, Definition)
    }
    if exercise.name not in defined:
        raise BadFile(f"{lab.solutions} has no {exercise.name}: write the reference answer there.")
    (path, text, _), solution = defined[exercise.name]
    stub = ast.parse(exercise.source()).body[0]
    if type(stub) is not type(solution):
        kind = "class" if exercise.is_class else "function"
        raise BadFile(f"{path}:{solution.lineno}: {exercise.name} must be a {kind}.")
    want, have = _signature(stub), _signature(solution)
    if want != have:
        raise BadFile(
            f"{path}:{solution.lineno}: {exercise.name} differs from its exercise.\n"
            f"  exercise: {want}\n  solution: {have}\nMake them the same, annotations included."
        )
    if isinstance(stub, ast.ClassDef) and isinstance(solution, ast.ClassDef):
        parts = _class(exercise.source(), stub, text, solution)
    else:
        head = exercise.source().rstrip("\n").rpartition("\n")[0]  # without its NotImplementedError
        parts = [head, f"    {BEGIN}", *_body(text, solution), f"    {END}"]
    if helpers := _helpers(lab, rooms, solution):
        parts = [BEGIN, *helpers, END, "", "", *parts]
    return "\n".join(parts)


def check_names(lab: Lab, answers: Iterable[tuple[Cell, str]]) -> None:
    """See that every name an answer uses is bound by a cell above it, so that it runs in the notebook.

    Parameters
    ----------
    lab : Lab
        For the message.
    answers : iterable of (Cell, str)
        Every code cell in order, with the source it gets.

    Raises
    ------
    BadFile
        A name that nothing above binds.
    """
    bound = set(dir(builtins))
    means = {k: v for room in _parse(lab) for k, v in _imported(room.tree).items()}
    there: dict[str, str] = {}
    for cell, source in answers:
        table = symtable.symtable(plain_python(source), cell.name or "cell", "exec")
        bound |= {s.get_name() for s in table.get_symbols() if s.is_assigned() or s.is_imported()}
        bound |= {t.get_name() for t in table.get_children()}
        there |= _imported(ast.parse(plain_python(source)))
        if cell.kind == "exercise" and (unknown := sorted(set(_globals(table)) - bound)):
            raise lab.wrong(
                cell.line,
                f"the answer to {cell.name} uses {', '.join(unknown)}, which no cell above binds. "
                "Import it in the lab's first code cell, or write the solution without it.",
            )
        if cell.kind == "exercise":
            for name in sorted(set(_globals(table)) & means.keys() & there.keys()):
                if not _same(means[name], there[name]):
                    raise lab.wrong(
                        cell.line,
                        f"the answer to {cell.name} means {means[name]} by {name}, and the lab {there[name]}: "
                        "let both mean the same.",
                    )


def _same(one: str, other: str) -> bool:
    """Whether two dotted names are one thing, perhaps handed on by another module."""
    if one == other:
        return True
    a, b = (importlib.import_module(x.rpartition(".")[0]) for x in (one, other))
    return getattr(a, one.rpartition(".")[2], a) is getattr(b, other.rpartition(".")[2], b)


def _imported(tree: ast.Module) -> dict[str, str]:
    """Name → the module that it was imported from, of everything imported by name at the top."""
    return {
        x.asname or x.name: f"{node.module}.{x.name}"
        for node in tree.body
        if isinstance(node, ast.ImportFrom)
        for x in node.names
    }


def _globals(table: symtable.SymbolTable) -> Iterator[str]:
    top = table.get_type() == "module"
    for symbol in table.get_symbols():
        if symbol.is_referenced() and (symbol.is_global() or top):
            yield symbol.get_name()
    for child in table.get_children():
        yield from _globals(child)


def _parse(lab: Lab) -> list[Room]:
    """The files of answers, in the order of their names."""
    first, rooms = lab.solutions, []
    for path in [first, *sorted(first.parent.glob(f"{first.stem}_*.py"))]:
        try:
            text = path.read_text(encoding="utf-8")
            rooms.append(Room(path, text, ast.parse(text)))
        except (OSError, SyntaxError) as error:
            raise BadFile(f"the answers of lab {lab.stem} cannot be read: {error}.") from None
    return rooms


def _owners(lab: Lab, rooms: Iterable[Room]) -> dict[str, tuple[Room, ast.stmt]]:
    """Name → the file and the statement that binds it; exercises left out."""
    owners: dict[str, tuple[Room, ast.stmt]] = {}
    for room in rooms:
        for node in room.tree.body:
            for name in _binds(node):
                if name in lab.exercises or name == "__all__":
                    continue
                was = owners.get(name)
                if was and was[0] is not room and ast.unparse(was[1]) != ast.unparse(node):
                    raise BadFile(
                        f"{room.path}:{node.lineno}: {name} is something else in {was[0].path.name}, and "
                        "a notebook has one room for all answers: rename one of them."
                    )
                owners[name] = room, node
    return owners


def _helpers(lab: Lab, rooms: list[Room], solution: Definition) -> list[str]:
    """The lines of what `solution` uses of its files and is no exercise, in the order of the files."""
    owners = _owners(lab, rooms)
    home = next(room for room in rooms if solution in room.tree.body)
    found: dict[ast.stmt, Room] = {}
    todo: list[tuple[Room, ast.stmt]] = [(home, solution)]
    while todo:
        room, node = todo.pop()
        code = textwrap.dedent("\n".join(_lines(room, node)))
        used = set(_globals(symtable.symtable(code, room.path.name, "exec")))
        new = {owners[n][1]: owners[n][0] for n in used & owners.keys()}
        todo += [(at, x) for x, at in new.items() if x not in found and x is not solution]
        found |= {x: at for x, at in new.items() if x is not solution}
    parts: list[str] = []
    for node, room in sorted(found.items(), key=lambda x: (rooms.index(x[1]), x[0].lineno)):
        gap = ["", ""] if parts and isinstance(node, Definition) else []
        parts += gap + _lines(room, node)
    return parts


def _lines(room: Room, node: ast.stmt) -> list[str]:
    return room.text.splitlines()[_first(node) - 1 : node.end_lineno]


def _binds(node: ast.stmt) -> list[str]:
    if isinstance(node, Definition):
        return [node.name]
    targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
    return [x.id for target in targets if target for x in ast.walk(target) if _is_bound(x)]


def _is_bound(x: ast.AST) -> TypeGuard[ast.Name]:
    """Whether a part of a target is a name that it binds: ``a, b = 1, 2`` binds two."""
    return isinstance(x, ast.Name) and isinstance(x.ctx, ast.Store)


def _signature(node: ast.stmt) -> str:
    """How it is called, annotations and defaults included; of a class, decorators, fields and each public method."""
    if isinstance(node, ast.ClassDef):
        decorators = [f"@{ast.unparse(x)}" for x in node.decorator_list]
        bases = ", ".join(ast.unparse(x) for x in [*node.bases, *(k.value for k in node.keywords)])
        members = [ast.unparse(x) for x in node.body if isinstance(x, ast.AnnAssign)]
        made = [x for x in node.body if isinstance(x, ast.FunctionDef) and _is_asked(x)]
        return "; ".join([*decorators, f"class({bases})", *members, *map(_signature, made)])
    assert isinstance(node, ast.FunctionDef)
    returns = f" -> {ast.unparse(node.returns)}" if node.returns else ""
    return f"{node.name}({ast.unparse(node.args)}){returns}"


def _is_asked(method: ast.FunctionDef) -> bool:
    return method.name == "__init__" or not method.name.startswith("_")


def _class(source: str, stub: ast.ClassDef, text: str, solution: ast.ClassDef) -> list[str]:
    """The stub of a class with the reference's bodies in it, and under them what else the reference has."""
    methods = {x.name: x for x in solution.body if isinstance(x, ast.FunctionDef)}
    lines, parts, at = source.splitlines(), [], 0
    for method in stub.body:
        if not isinstance(method, ast.FunctionDef) or not isinstance(method.body[-1], ast.Raise):
            continue
        last = method.body[-1]
        body = _body(text, methods.pop(method.name))
        parts += [*lines[at : last.lineno - 1], f"        {BEGIN}", *body, f"        {END}"]
        at = last.end_lineno or last.lineno
    parts += lines[at:]
    known = {ast.unparse(x) for x in stub.body}
    own = [x for x in solution.body[1:] if ast.unparse(x) not in known and not _is_method(x, stub)]
    if own:
        parts += ["", f"    {BEGIN}"]
        for n, node in enumerate(own):
            gap = [""] if n and isinstance(node, ast.FunctionDef) else []
            parts += gap + text.splitlines()[_first(node) - 1 : node.end_lineno]
        parts += [f"    {END}"]
    return parts


def _is_method(node: ast.stmt, stub: ast.ClassDef) -> bool:
    names = {x.name for x in stub.body if isinstance(x, ast.FunctionDef)}
    return isinstance(node, ast.FunctionDef) and node.name in names


def _first(node: ast.stmt) -> int:
    """The line on which a statement begins, decorators included."""
    return min([node.lineno, *(x.lineno for x in getattr(node, "decorator_list", []))])


def _body(text: str, node: Definition) -> list[str]:
    """The lines under the docstring, comments and blank lines within them included."""
    first = node.body[0]
    start = first.end_lineno if ast.get_docstring(node) is not None else first.lineno - 1
    lines = text.splitlines()[start : node.end_lineno]
    while lines and not lines[0].strip():
        lines.pop(0)
    return lines
