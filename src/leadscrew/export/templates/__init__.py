"""The texts around the exported controller, as Jinja templates."""

from __future__ import annotations

from pathlib import Path
from typing import Any


def render(name: str, **values: Any) -> str:
    """A template filled in; an unknown name in it is an error."""
    import jinja2

    folder = jinja2.FileSystemLoader(Path(__file__).parent)
    space = jinja2.Environment(loader=folder, undefined=jinja2.StrictUndefined, keep_trailing_newline=True)
    return space.get_template(name).render(**values)
