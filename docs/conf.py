"""Sphinx configuration. The study pages are written by their own runs, before Sphinx reads its sources."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import leadscrew

project = "Leadscrew"
author = "The Leadscrew authors"
copyright = "2026, The Leadscrew authors"
version = release = leadscrew.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode"]
source_suffix = {".md": "markdown"}
exclude_patterns = ["_build", "**.ipynb_checkpoints"]
myst_enable_extensions = ["colon_fence"]
myst_heading_anchors = 3

html_theme = "furo"
html_static_path = ["_static"]
html_css_files = ["wide.css"]
html_title = f"Leadscrew {version}"
html_copy_source = False

add_module_names = False
autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
napoleon_numpy_docstring = False
nitpicky = False
suppress_warnings = ["myst.header", "ref.python"]


def plain_bars(app, what, name, obj, options, lines):
    """Bars are magnitudes in our docstrings, not marks of reStructuredText; inside ``code`` they need no help."""
    for at, line in enumerate(lines):
        parts = line.split("``")
        parts[::2] = [part.replace("|", r"\|") for part in parts[::2]]
        lines[at] = "``".join(parts)


TREES = {}
"""The tree of pages as those of source code at one depth show it; resolving it for each took half of the time."""


def one_tree(app, pagename, templatename, context, doctree):
    """Pages of source code stand nowhere in the tree: it differs by the ``../`` of its links alone."""
    if pagename.startswith("_modules/") and "toctree" in context:
        resolved, depth = context["toctree"], pagename.count("/")

        def toctree(**how):
            asked = (depth, *sorted(how.items()))
            if asked not in TREES:
                TREES[asked] = resolved(**how)
            return TREES[asked]

        context["toctree"] = toctree


def setup(app):
    """Writes what is generated: a page for each study, the pages of blocks."""
    import generate

    app.connect("autodoc-process-docstring", plain_bars)
    app.connect("html-page-context", one_tree, priority=400)  # before the theme's
    app.connect("builder-inited", lambda app: generate.everything(Path(app.srcdir)))
