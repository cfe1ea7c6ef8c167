"""What students must not get, searched for in what they do get."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Iterable, Iterator
from pathlib import Path

from grader.canaries import ROOT, TOKEN, secret_files

# Shorter lines (``return None``, ``h = 1e-6``) say nothing about an answer.
LONG = 30


def find_leaks(files: Iterable[Path]) -> list[str]:
    """Say what of the answers, hidden checks, mutants and variants is in archives and wheels.

    Parameters
    ----------
    files : iterable of Path
        Zip files; wheels and archives inside them are opened, too.

    Returns
    -------
    list of str
        One sentence for each find: which file, and what of which secret file.
    """
    secrets = secret_lines()
    found = []
    for file in files:
        for name, data in members(file.name, file.read_bytes()):
            text = _plain(name, data.decode("utf-8", errors="replace"))
            found += [f"{name} carries {token}" for token in set(TOKEN.findall(text))]
            lines = {s.strip() for s in text.splitlines()}
            found += [f"{name} has a line of {secrets[s]}: {s}" for s in lines & secrets.keys()]
            if "uavlab/solutions" in name:
                found.append(f"{name} is a file of the solutions")
    return sorted(found)


def secret_lines() -> dict[str, str]:
    """Each telling line of a secret file → where it stands. What the public library says, too, is no secret."""
    public = {
        line.strip()
        for path in (ROOT / "uavlab").rglob("*.py")
        if "solutions" not in path.parts
        for line in path.read_text(encoding="utf-8").splitlines()
    }
    return {
        line.strip(): str(path.relative_to(ROOT))
        for path in secret_files()
        for line in path.read_text(encoding="utf-8").splitlines()
        if len(line.strip()) >= LONG and line.strip() not in public and _tells(line.strip())
    }


def members(name: str, data: bytes) -> Iterator[tuple[str, bytes]]:
    """Every file in a zip, and in the zips in it, with the path that leads there."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        for item in archive.infolist():
            path, content = f"{name}/{item.filename}", archive.read(item)
            if item.filename.endswith((".whl", ".zip")):
                yield from members(path, content)
            elif not item.is_dir():
                yield path, content


def _tells(line: str) -> bool:
    """Signatures and imports are in the stubs and in the labs, and may be."""
    return not line.startswith(("def ", "import ", "from ", "class ", "@"))


def _plain(name: str, text: str) -> str:
    """A notebook as the lines that one reads in it."""
    if not name.endswith(".ipynb"):
        return text
    cells = json.loads(text)["cells"]
    sources = ["".join(c["source"]) for c in cells]
    return "\n".join([*sources, text])  # and the raw file, for what hides in outputs and metadata
