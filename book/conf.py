"""Sphinx settings of the book. `python -m grader.build --book` copies this to where it puts the pages together."""

from importlib.util import find_spec
from pathlib import Path

import uavlab

project = "uavlab"
author = "The uavlab authors"
project_copyright = author
version = release = uavlab.__version__

extensions = [
    "myst_nb",
    "sphinx_exercise",
    "sphinx_proof",
    "sphinxcontrib.bibtex",
]
exclude_patterns = ["jupyter_execute", ".cache", "**/.ipynb_checkpoints"]
nitpicky = True

# Markdown
myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

# Running the labs
nb_execution_mode = "cache"
nb_execution_cache_path = str(Path(__file__).parent / ".cache")
nb_execution_timeout = 180
nb_merge_streams = True
nb_render_markdown_format = "myst"
nb_execution_show_tb = True

# Formulas: MathJax from a Python package, copied into the book, so that no page asks the network for anything
MATHJAX = find_spec("sphinx-mathjax-offline")  # not a name that `import` could take
html_static_path = [
    "_static",
    f"{MATHJAX.submodule_search_locations[0]}/static/mathjax/tex-svg-full.js",
]
html_css_files = ["book.css"]
mathjax_path = "tex-svg-full.js"  # drawn as outlines: no fonts to fetch
mathjax3_config = {
    "options": {
        "processHtmlClass": "tex2jax_process|mathjax_process|math|output_area",
        "enableMenu": False,  # it would load parts that are not here
    },
}

# Looks
html_theme = "sphinx_book_theme"
html_title = "uavlab"
html_theme_options = {
    "use_download_button": False,
    "use_fullscreen_button": False,
    "home_page_in_toc": True,
    "show_navbar_depth": 1,
    "show_toc_level": 2,
    "navbar_persistent": [],
}
html_context = {"default_mode": "light"}  # the plots are
html_copy_source = False
html_show_sourcelink = False

# Sources
bibtex_bibfiles = ["references.bib"]
bibtex_default_style = "plain"
bibtex_reference_style = "author_year"
