"""The page that lists the reports of a folder, one card each, made from the ``report.json`` of each."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import quote

from leadscrew.report.report import KIND
from leadscrew.util import atomic, reading
from leadscrew.util.errors import DataError

MARK = '<meta name="generator" content="leadscrew index">'
"""By this an ``index.html`` is known to be one of ours, to be replaced."""


class Card(NamedTuple):
    """A report as the list shows it."""

    name: str
    title: str
    link: str
    conclusion: str = ""
    numbers: tuple[tuple[str, str], ...] = ()
    """Value with its unit, and what it is."""
    picture: str = ""
    alt: str = ""


def cards(folder: Path, order: Sequence[str] = ()) -> list[Card]:
    """The reports in the folders below ``folder``, those in ``order`` first; a folder without a report is none."""
    found = []
    names = sorted(p.name for p in folder.iterdir() if p.is_dir() and not p.name.startswith("."))
    for below in (folder / name for name in [*(n for n in order if n in names), *(n for n in names if n not in order)]):
        try:
            data = reading.json_object(below / "report.json")
        except DataError:
            continue
        if data.get("kind") == KIND and (below / "report.html").is_file():
            found.append(_card(below, data))
    return found


def _card(below: Path, data: dict[str, Any]) -> Card:
    own, conclusion = data.get("card"), data.get("conclusion")
    own = own if isinstance(own, dict) else {}
    numbers = [n for n in own.get("numbers", []) if isinstance(n, list) and len(n) == 2]
    picture, where = str(own.get("picture") or ""), quote(below.name)
    shown = picture and Path(picture).name == picture and (below / picture).is_file()
    return Card(
        name=str(data.get("study", below.name)),
        title=str(data.get("title") or data.get("study", below.name)),
        link=f"{where}/report.html",
        conclusion=str(conclusion[0]) if isinstance(conclusion, list) and conclusion else "",
        numbers=tuple((str(value), str(what)) for value, what in numbers),
        picture=f"{where}/{quote(picture)}" if shown else "",
        alt=str(own.get("alt", "")),
    )


def write(folder: str | Path, title: str = "Reports", order: Sequence[str] = ()) -> Path | None:
    """Writes ``index.html`` of a folder; gives its path, or None where one stands there that is not ours.

    Raises:
        DataError: it cannot be written.
    """
    from leadscrew.report.html import code, template

    page = Path(folder) / "index.html"
    if page.exists() and MARK not in page.read_text(encoding="utf-8", errors="replace")[:2000]:
        return None
    text = template("index.html.j2", code=code).render(title=title, cards=cards(Path(folder), order))
    atomic.atomic_write(text, page, durable=False)
    return page
