"""Exercises that are classes: their public methods, and which values of these are the student's own memory.

The rule: what a stub's methods return under the annotation ``Memory`` is the student's own. It is any object at all;
checks hold it and hand it back, and never look into it; in the grader it never leaves the student's process.
Everything else that a class takes or gives is plain data: numbers, texts, arrays, lists, tuples, dicts with texts
for keys, and the records of `uavlab.types`.
"""

from __future__ import annotations

import ast
import inspect
from typing import Any, NamedTuple

MEMORY = "Memory"


class Method(NamedTuple):
    """One public method of a class that a student writes, and where memory is in what it returns."""

    name: str
    size: int  # values in the tuple that it returns; 0 for a result that is no tuple with memory in it
    places: tuple[int, ...]  # which of them are memory
    whole: bool  # the result itself is memory

    @property
    def gives_memory(self) -> bool:
        """Whether there is memory in what it returns."""
        return self.whole or bool(self.places)

    @property
    def asked(self) -> str:
        """What it must return, as far as memory goes."""
        return f"{self.name} must return the tuple that its signature says."

    def apart(self, result: Any) -> tuple[list[Any], Any] | None:
        """A result as its memories, and the rest of it in the same shape; None if it has another form."""
        if self.whole:
            return [result], None
        if not self.places:
            return [], result
        if not isinstance(result, tuple | list) or len(result) != self.size:
            return None
        rest = tuple(x for i, x in enumerate(result) if i not in self.places)
        return [result[i] for i in self.places], rest

    def together(self, memories: list[Any], rest: Any) -> Any:
        """What `apart` took apart."""
        if self.whole:
            return memories[0]
        if not self.places:
            return rest
        kept, plain = iter(memories), iter(rest)
        return tuple(next(kept if i in self.places else plain) for i in range(self.size))


def methods_of(stub: type) -> dict[str, Method]:
    """The public methods of a stub, by name, in the order in which they are written down.

    Raises
    ------
    TypeError
        A method is not one that can be called from another process: no plain method, or one without annotations.
    """
    found = {}
    for name, value in vars(stub).items():
        if name.startswith("_") or not callable(value):
            continue
        if not inspect.isfunction(value) or "return" not in value.__annotations__:
            raise TypeError(
                f"{stub.__name__}.{name} must be a method with a full signature: annotate its result"
            )
        found[name] = _method(name, value.__annotations__["return"])
    return found


def class_source(stub: type, message: str) -> str:
    """A stub as the student sees it: each body ``...`` says `message` instead."""
    text = inspect.getsource(stub)
    lines = text.splitlines()
    indent = len(lines[0]) - len(lines[0].lstrip())
    lines = [s[indent:] for s in lines]
    node = ast.parse("\n".join(lines)).body[0]
    assert isinstance(node, ast.ClassDef)
    for method in node.body:
        last = method.body[-1] if isinstance(method, ast.FunctionDef) else None
        if isinstance(last, ast.Expr) and _is_dots(last.value):
            blank = " " * last.col_offset
            lines[last.lineno - 1] = f'{blank}raise NotImplementedError("{message}")'
    kept = [x for x in node.decorator_list if not _is_exercise(x)]
    start = min([node.lineno, *(x.lineno for x in kept)])
    gone = {n for x in node.decorator_list if _is_exercise(x) for n in _span(x)}
    return "\n".join(s for n, s in enumerate(lines, 1) if n >= start and n not in gone) + "\n"


def _method(name: str, result: Any) -> Method:
    """How a method's annotated result falls into memory and plain data."""
    node = ast.parse(result if isinstance(result, str) else MEMORY, mode="eval").body
    if _is_memory(node):
        return Method(name, 0, (), whole=True)
    is_tuple = isinstance(node, ast.Subscript) and ast.unparse(node.value) == "tuple"
    parts = node.slice.elts if is_tuple and isinstance(node.slice, ast.Tuple) else []  # type: ignore[union-attr]
    places = tuple(i for i, x in enumerate(parts) if _is_memory(x))
    return Method(name, len(parts) if places else 0, places, whole=False)


def _is_memory(node: ast.expr) -> bool:
    return ast.unparse(node).rpartition(".")[2] == MEMORY


def _is_dots(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and node.value is ...


def _is_exercise(node: ast.expr) -> bool:
    return isinstance(node, ast.Call) and ast.unparse(node.func).endswith("exercise")


def _span(node: ast.expr) -> range:
    return range(node.lineno, (node.end_lineno or node.lineno) + 1)
