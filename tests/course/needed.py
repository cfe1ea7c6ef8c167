"""Which cells of a notebook some others need: they make the names that those read, or the names that these need."""

import ast
import symtable


def names(source):
    """The names that a cell makes, and those that it reads and does not make."""
    top = symtable.symtable(source, "cell", "exec")
    made = {s.get_name() for s in top.get_symbols() if s.is_assigned() or s.is_imported()}
    read = {s.get_name() for s in top.get_symbols() if s.is_referenced()}
    inner = top.get_children()
    while inner:
        table = inner.pop()
        read |= {s.get_name() for s in table.get_symbols() if s.is_global() and s.is_referenced()}
        inner += table.get_children()
    return made, read - made


def stores(nodes):
    """The names that are assigned to anywhere in some nodes."""
    inside = (x for node in nodes for x in ast.walk(node))
    return {x.id for x in inside if isinstance(x, ast.Name) and isinstance(x.ctx, ast.Store)}


def catches(node):
    """Whether a node is where a BadFile is caught."""
    return isinstance(node, ast.ExceptHandler) and "BadFile" in ast.unparse(node.type or node)


def without_a_file(source, known):
    """The names that live without a file: made where a BadFile is caught, or functions that catch it or read such."""
    tree = ast.parse(source)
    found = stores([y for x in ast.walk(tree) if catches(x) for y in x.body])
    for f in (x for x in tree.body if isinstance(x, ast.FunctionDef)):
        inside = list(ast.walk(f))
        if any(map(catches, inside)) or known & {x.id for x in inside if isinstance(x, ast.Name)}:
            found.add(f.name)
    return found


def for_files(sources):
    """Of some cells in order, which ask for files that may be missing, live with it, or are needed by these."""
    empty = set()
    for source in sources:
        empty |= without_a_file(source, empty)
    kept, wanted = [], set()
    for source in reversed(sources):
        made, read = names(source)
        keep = "except BadFile" in source or bool(empty & read) or bool(made & wanted)
        wanted = (wanted - made) | read if keep else wanted
        kept.append(keep)
    return kept[::-1]
