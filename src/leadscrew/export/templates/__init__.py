"""The texts around the exported controller, as Jinja templates."""

from __future__ import annotations

from pathlib import Path
from typing import Any


def render(name: str, **values: Any) -> str:
    """A template filled in; an unknown name in it is an error."""
    import jinja2

    from leadscrew import escape

    folder = jinja2.FileSystemLoader(Path(__file__).parent)
    space = jinja2.Environment(loader=folder, undefined=jinja2.StrictUndefined, keep_trailing_newline=True)
    space.filters |= {f.__name__: f for f in (
        escape.one_line, escape.c_comment, escape.c_string, escape.c_format, escape.hal_string, escape.markdown,
        escape.markdown_code, escape.markdown_doc,
    )}  # fmt: skip
    return space.get_template(name).render(**values)
