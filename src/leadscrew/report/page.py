"""A result as one HTML page that opens anywhere, offline: its parts, with style and figures inside."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING

from leadscrew.report.html import embedded
from leadscrew.util.escape import html as escape

if TYPE_CHECKING:
    from leadscrew.figures.figure import Figure
    from leadscrew.report.report import TextTable


def page(title: str, parts: Sequence[str], style: str = "") -> str:
    """The page: its title, then the parts (HTML; empty ones are left out); ``style`` is added to the common one."""
    from importlib.resources import files

    common = files("leadscrew.report").joinpath("templates", "style.css.j2").read_text(encoding="utf-8")
    below = "\n".join([f"<h1>{escape(title)}</h1>", *(p for p in parts if p)])
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>'
        f"<style>{common}{style}</style></head>\n<body>\n{below}\n</body></html>\n"
    )


def sentence(text: str) -> str:
    """A line of a result as a sentence, in HTML; what stands in backticks is code."""
    whole = f"{text[:1].upper()}{text[1:]}{'' if text.endswith('.') else '.'}"
    return re.sub("`([^`]+)`", r"<code>\1</code>", escape(whole))


def paragraphs(lines: Sequence[str]) -> list[str]:
    """Each line a paragraph."""
    return [f"<p>{sentence(line)}</p>" for line in lines]


def bullets(title: str, lines: Sequence[str]) -> str:
    """The lines below a heading; nothing where there are none."""
    items = "".join(f"<li>{sentence(line)}</li>" for line in lines)
    return f"<h2>{escape(title)}</h2><ul>{items}</ul>" if items else ""


def picture(figure: Figure, name: str, alt: str, caption: str = "") -> str:
    """A figure inside the page; ``name`` makes its text the same each time."""
    below = f"<figcaption>{escape(caption)}</figcaption>" if caption else ""
    return f'<figure><img alt="{escape(alt)}" src="{embedded(figure, name)}">{below}</figure>'


def table(shown: TextTable) -> str:
    """A table below its heading; columns of numbers stand to the right."""

    def cells(tag: str, texts: Sequence[str]) -> str:
        return "".join(
            f'<{tag} class="n">{escape(text)}</{tag}>' if right else f"<{tag}>{escape(text)}</{tag}>"
            for text, right in zip(texts, shown.numeric, strict=True)
        )

    head, body = cells("th", shown.heads), "".join(f"<tr>{cells('td', row)}</tr>" for row in shown.rows)
    return f'<h2>{escape(shown.title)}</h2><div class="wide"><table><tr>{head}</tr>{body}</table></div>'
