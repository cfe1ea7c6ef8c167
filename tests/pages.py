"""A page of the book as a program: its code cells, run one after the other as the book does."""

import re
from pathlib import Path

BOOK = Path(__file__).parents[1] / "book"


def cells(page):
    """The text of every code cell, without its options."""
    text = (BOOK / page).read_text("utf-8")
    found = re.findall(r"^```\{code-cell\} ipython3\n(.*?)^```$", text, re.S | re.M)
    return [re.sub(r"\A(?::.*\n)+", "", cell) for cell in found]


def run(page):
    """Run the cells in the working directory; the names that they leave behind."""
    space = {"__name__": "__page__"}
    for number, cell in enumerate(cells(page)):
        written = re.match(r"%%writefile (-a )?(\S+)\n", cell)
        if written:
            with open(written[2], "a" if written[1] else "w", encoding="utf-8") as file:
                file.write(cell[written.end() :])
        else:
            exec(compile(cell, f"{page}, cell {number}", "exec"), space)
    return space
