"""``leadscrew list FILE.toml`` of a controller file: what it is, its settings, and where they come from."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import typer

from leadscrew.cli.output import emit, print_table

SCORES = {"before_held_out": "before, held out", "trained": "tuned, trained", "held_out": "tuned, held out"}
"""The tables of ``[tuning]`` that are shown, and as what."""


def is_controller(name: str) -> bool:
    """Whether a name means a controller file.

    Raises:
        DataError: no such file, or bad TOML.
    """
    from leadscrew import toml_file

    return name.endswith(".toml") and toml_file.read(Path(name).expanduser()).get("kind") == "controller"


def show(name: str, as_json: bool) -> None:
    """A controller file as text or JSON.

    Raises:
        DataError: its parameters do not fit its controller.
    """
    from leadscrew import controller_file, resolve
    from leadscrew.kernel.sheet import entries
    from leadscrew.report.tables import Setting, first_line
    from leadscrew.resolve import controller

    found = controller_file.read(name)
    block = resolve.from_controller_file(name)
    own = {e.key: e.default for e in entries(controller(resolve.study(found.study), found.controller).params)}
    sheet = [Setting(e) for e in entries(block.params)]
    if as_json:
        rows = [{**s.as_dict(), "value": s.entry.default, "default": own[s.entry.key],
                 "set": s.entry.key in found.parameters} for s in sheet]  # fmt: skip
        emit({"file": name, "kind": "controller", "study": found.study, "controller": found.controller,
              "doc": block.doc, "parameters": rows, "tuning": dict(found.tuning)})  # fmt: skip
        return
    typer.echo(f"{name}: a controller of {found.study}, {found.controller} with these settings\n")
    typer.echo(f"{first_line(block.doc)}\n")
    _settings([s for s in sheet if s.entry.key in found.parameters], own)
    if found.tuning:
        _tuning(found.tuning)
    typer.echo(f"\nleadscrew list {found.study} shows its study, with all that can be set.")


def _settings(sheet: list[Any], own: Mapping[str, Any]) -> None:
    from leadscrew.report.tables import number

    rows = [[s.entry.key, number(s.entry.default), number(own[s.entry.key]), s.entry.unit, s.entry.range, s.entry.doc]
            for s in sheet]  # fmt: skip
    print_table(["parameter", "here", "default", "unit", "range", "what it is"], rows, right=("here", "default"))


def _tuning(tuning: Mapping[str, Any]) -> None:
    """Where the settings come from; what a file of another hand does not say is left out."""
    from leadscrew.report.tables import number
    from leadscrew.toml_file import flat

    done = f"{tuning['evaluations']} evaluations by " if "evaluations" in tuning else ""
    parts = [f"{done}{tuning.get('optimiser', '')}".strip()]
    parts += [f"{word} {tuning[key]}" for key, word in (("seed", "seed"), ("date", "on"), ("leadscrew", "Leadscrew"))
              if key in tuning]  # fmt: skip
    how = f"made by {tuning['made_by']}" if "made_by" in tuning else "tuned"
    typer.echo(f"\n{how}: {', '.join(p for p in parts if p)}")
    for word, key in (("varied", "vary"), ("over", "over")):
        if isinstance(tuning.get(key), Mapping):
            typer.echo(f"{word}: {', '.join(f'{k} = {v}' for k, v in flat(tuning[key]))}")
    shown = {key: title for key, title in SCORES.items() if isinstance(tuning.get(key), Mapping)}
    if shown:
        names = list(dict.fromkeys(n for key in shown for n in tuning[key]))
        rows = [[n, *(number(tuning[key][n]) if n in tuning[key] else "" for key in shown)] for n in names]
        typer.echo()
        print_table(["goal, constraint", *shown.values()], rows, right=tuple(shown.values()))
    for said in [tuning.get("verdict"), *(f"note: {n}" for n in tuning.get("notes") or ())]:
        if said:
            typer.echo(f"\n{said}")
