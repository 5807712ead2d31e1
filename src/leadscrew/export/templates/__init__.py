"""The texts around the exported controller, as Jinja templates; their filters are the escapes of each language."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from leadscrew.util import escape

if TYPE_CHECKING:
    import jinja2


def render(name: str, **values: Any) -> str:
    """A template filled in; an unknown name in it is an error."""
    return _space().get_template(name).render(**values)


@lru_cache(maxsize=1)
def _space() -> jinja2.Environment:
    import jinja2

    folder = jinja2.FileSystemLoader(Path(__file__).parent)
    space = jinja2.Environment(loader=folder, undefined=jinja2.StrictUndefined, keep_trailing_newline=True)
    filters = (escape.one_line, escape.c_comment, escape.c_string, escape.hal_string, escape.markdown,
               escape.markdown_code, escape.markdown_doc)  # fmt: skip
    space.filters |= {filter.__name__: filter for filter in filters}
    return space
