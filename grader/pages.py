"""Feedback pages as nbgrader makes them, at a third of the time.

nbconvert reads each finished page again to add labels that nbgrader's template does not have, and colours the code of
the lab anew for every student. Neither is done here.
"""

from __future__ import annotations

import html
import re
import shutil
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from nbconvert.exporters import HTMLExporter
from nbconvert.exporters.templateexporter import TemplateExporter
from nbconvert.filters import Highlight2HTML
from nbconvert.filters.widgetsdatatypefilter import WidgetsDataTypeFilter
from nbformat import NotebookNode

_MOST, _LONGEST = 20_000, 1_000  # characters of a cell, and of a line or a gap, that are coloured
_ODD = re.compile(rf"[^\n]{{{_LONGEST}}}|\s{{{_LONGEST}}}")


@lru_cache(maxsize=2048)
def _coloured(source: str) -> str:
    if len(source) > _MOST or _ODD.search(
        source
    ):  # the lexer's time may grow with the square of these
        return f'<div class="highlight"><pre>{html.escape(source)}</pre></div>'
    return str(Highlight2HTML(pygments_lexer="ipython3")(source))


def _highlight(source: str, language: str | None = None, metadata: Any = None) -> str:
    return _coloured(source)


class FeedbackExporter(HTMLExporter):
    """nbconvert's HTML exporter without the second pass over the page."""

    def from_notebook_node(
        self, nb: NotebookNode, resources: Any = None, **kw: Any
    ) -> tuple[str, dict[str, Any]]:
        """The page of one notebook."""
        resources = self._init_resources(resources)
        widgets = WidgetsDataTypeFilter(
            notebook_metadata=self._nb_metadata, parent=self, resources=resources
        )
        self.register_filter("highlight_code", _highlight)
        self.register_filter("filter_data_type", widgets)
        return TemplateExporter.from_notebook_node(self, nb, resources, **kw)  # type: ignore[return-value]


def offer_mathjax(course: Path) -> None:
    """Put MathJax where feedback pages and formgrader look for it: ``mathjax/`` of the course, one file.

    Without the Python package that carries it, formulas are read as they were typed.
    """
    spec = find_spec("sphinx-mathjax-offline")  # not a name that `import` could take
    target = course / "mathjax" / "tex-svg-full.js"
    if spec is None or not spec.submodule_search_locations or target.exists():
        return
    source = Path(spec.submodule_search_locations[0]) / "static" / "mathjax" / target.name
    if source.is_file():
        target.parent.mkdir(exist_ok=True)
        shutil.copyfile(source, target)
