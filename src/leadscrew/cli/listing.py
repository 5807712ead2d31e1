"""``leadscrew list``: blocks, studies, and what can be set in them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from leadscrew.cli.output import Json, emit, print_table, width
from leadscrew.cli.subject import Trust, study_of

if TYPE_CHECKING:
    from leadscrew.figures.formats import Setting
    from leadscrew.kernel.block import Block
    from leadscrew.study_data import Study


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
    from leadscrew.figures.formats import Setting, first_line
    from leadscrew.kernel.parameters import entries
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
    _controller_settings([s for s in sheet if s.entry.key in found.parameters], own)
    if found.tuning:
        _tuning(found.tuning)
    typer.echo(f"\nleadscrew list {found.study} shows its study, with all that can be set.")


def _controller_settings(sheet: list[Any], own: Mapping[str, Any]) -> None:
    from leadscrew.figures.formats import number

    rows = [[s.entry.key, number(s.entry.default), number(own[s.entry.key]), s.entry.unit, s.entry.range, s.entry.doc]
            for s in sheet]  # fmt: skip
    print_table(["parameter", "here", "default", "unit", "range", "what it is"], rows, right=("here", "default"))


def _tuning(tuning: Mapping[str, Any]) -> None:
    """Where the settings come from; what a file of another hand does not say is left out."""
    from leadscrew.figures.formats import number
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


WIDE = 150
"""Columns from which it stands in a column of its own where a parameter is."""


def list_(
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="[NAME]",
            help="A block, a study, path/file.py:NAME, a fuzzy system's file, "
            "or a controller, machine or experiment file (.toml).",
        ),
    ] = None,
    trust: Trust = False,
    as_json: Json = False,
) -> None:
    """List blocks and studies; with a name, everything that can be set in it."""
    if name is None:
        _everything(as_json)
        return
    if is_controller(name):
        show(name, as_json)
        return
    found = _found(name)
    from leadscrew.study_data import Study

    if isinstance(found, Study):
        _study(found, as_json)
    else:
        _block(name, found, as_json)


def _found(name: str) -> Study | Block:
    """The study or block of a name.

    Raises:
        LeadscrewError: there is neither.
    """
    from leadscrew import catalogue, experiment, names, resolve
    from leadscrew.kernel.parameters import nearest
    from leadscrew.study_data import Study
    from leadscrew.util.errors import NameUnknown

    if experiment.is_file(name):
        return study_of(name)
    if names.is_reference(name):
        found = resolve.load(name)
        return found if isinstance(found, Study) else resolve.block(name)
    if name in catalogue.study_names():
        return resolve.study(name)
    if name in catalogue.block_names() or name in catalogue.FACTORIES:
        return resolve.block(name)
    known = [*catalogue.study_names(), *catalogue.block_names()]
    raise NameUnknown(f"there is no block or study {name!r}{nearest(name, known)}")


def _everything(as_json: bool) -> None:
    from leadscrew import catalogue
    from leadscrew.figures.formats import Setting, first_line
    from leadscrew.kernel.parameters import entries
    from leadscrew.util.errors import LeadscrewError

    def one(kind: str, name: str, what: Any) -> dict[str, Any]:
        try:
            found = what(name)
        except LeadscrewError as error:
            return {"name": name, "kind": kind, "doc": str(error)}
        return {
            "name": name,
            "kind": getattr(found, "kind", kind),
            "doc": first_line(getattr(found, "title", "") or getattr(found, "doc", "")),
            "parameters": [Setting(e).as_dict() for e in entries(getattr(found, "params", None))],
        }

    def defaults(row: dict[str, Any]) -> str:
        return ", ".join(f"{s['key']}={_short(s['default'])} {s['unit']}".rstrip() for s in row.get("parameters", ()))

    studies = [one("study", n, catalogue.study) for n in catalogue.study_names()]
    blocks = [one("block", n, catalogue.block) for n in catalogue.block_names()]
    makers = [
        {"name": n, "kind": catalogue.factory_kind(n), "doc": first_line(f.__doc__ or "")}
        for n, f in catalogue.factories().items()
    ]
    if as_json:
        emit({"studies": studies, "blocks": blocks, "makers": makers})
        return
    print_table(["study", "title"], [(r["name"], r["doc"]) for r in studies])
    typer.echo()
    print_table(
        ["block", "kind", "what it is", "parameters and their defaults"],
        [(r["name"], r["kind"], r["doc"], defaults(r)) for r in blocks],
    )
    typer.echo()
    print_table(
        ["made in Python by", "kind", "what it is"], [(r["name"] + "(...)", r["kind"], r["doc"]) for r in makers]
    )
    typer.echo("\nleadscrew list NAME shows what can be set, with unit, default and range.")


def _short(value: Any) -> str:
    """A default in a few characters; of an array its shape."""
    shape = getattr(value, "shape", None)
    if shape:
        return f"array {'x'.join(map(str, shape))}"
    return f"{value:g}" if isinstance(value, float) else str(value)


def _block(name: str, block: Block, as_json: bool) -> None:
    from leadscrew.figures.formats import Setting, plain
    from leadscrew.kernel.parameters import entries

    sheet = [Setting(e) for e in entries(block.params)]
    if as_json:
        emit(
            {
                "name": name, "kind": block.kind, "unit": block.unit, "signals": block.signals, "doc": block.doc,
                "drive": block.drive, "full_scale": block.full_scale, "sense": block.sense,
                "bumpless": block.align is not None, "stiff": block.stiff, "parameters": [s.as_dict() for s in sheet],
            }
        )  # fmt: skip
        return
    unit = f", in {block.unit}" if block.unit and block.unit != "1" else ""
    typer.echo(f"{name}: {block.kind}{unit}; takes {', '.join(block.signals) or 'nothing'}\n\n{plain(block.doc)}\n")
    if block.drive:
        typer.echo(f"{drive(block)}\n")
    if block.kind == "plant" and block.sense < 0:
        typer.echo("sense: a positive input moves its output towards negative values\n")
    if block.stiff:
        typer.echo("stiff: integrated by rodas unless a loop names a method\n")
    if sheet:
        _settings(sheet, "parameter")
    else:
        typer.echo("It has no parameters.")


def drive(block: Block) -> str:
    """What a controller's output means at the machine, in one line."""
    scale = f", full scale {block.full_scale:g} {block.unit if block.unit != '1' else ''}".rstrip()
    way = "positive" if block.sense > 0 else "negative"
    start = "aligned when it is enabled (bumpless)" if block.align is not None else "not bumpless"
    full = scale if block.full_scale else ""
    return f"drive: {block.drive}{full}; a positive output moves towards {way} feedback; {start}"


def _study(study: Study, as_json: bool) -> None:
    from leadscrew.figures.formats import first_line, integrated, metric_unit, settings

    loop = study.loop(next(iter(study.controllers)), next(iter(study.scenarios)))
    controllers = [{"name": n, "doc": first_line(b.doc)} for n, b in study.controllers.items()]
    scenarios = [{"name": s.name, "duration_s": s.duration_s, "doc": s.doc} for s in study.scenarios.values()]
    metrics = [{"name": n, "unit": metric_unit(loop, m), "doc": first_line(m.doc)} for n, m in loop.metrics.items()]
    found = settings(study)
    loops = {name: study.loop(next(iter(study.controllers)), name) for name in study.scenarios}
    plants = {b.name: b for b in (x.blocks["plant"] for x in loops.values()) if b is not None}
    integration = {name: x.integration for name, x in loops.items()}
    if as_json:
        emit(
            {
                "study": study.name, "title": study.title, "paper": study.paper, "controllers": controllers,
                "plants": [{"name": b.name, "unit": b.unit, "sense": b.sense} for b in plants.values()],
                "scenarios": scenarios, "integration": integration, "settings": [s.as_dict() for s in found],
                "metrics": metrics,
            }
        )  # fmt: skip
        return
    typer.echo(f"{study.name}: {study.title}\n{study.paper}\n")
    print_table(["controller", "what it is"], [(r["name"], r["doc"]) for r in controllers])
    typer.echo()
    rows = [(s.name, f"{s.duration_s:g} s", s.doc) for s in study.scenarios.values()]
    print_table(["scenario", "runs for", "what is asked"], rows, right=("runs for",))
    if by := ", ".join(dict.fromkeys(filter(None, map(integrated, integration.values())))):
        typer.echo(f"\nplant integrated by {by}")
    typer.echo()
    reversed_ = [b.name for b in plants.values() if b.sense < 0]
    if reversed_:
        typer.echo(
            f"sense of the drive: a positive input moves {', '.join(reversed_)} towards negative values; a controller "
            "must give a negative output for a positive error\n"
        )
    _settings(found, "--set")
    typer.echo()
    print_table(["metric", "unit", "what it is"], [(r["name"], r["unit"], r["doc"]) for r in metrics])


def _settings(found: Iterable[Setting], title: str) -> None:
    from leadscrew.figures.formats import number

    found = list(found)
    beside = width() >= WIDE and any(s.where for s in found)
    rows = []
    for s in found:
        where = some(s.where)
        doc = s.entry.doc if beside or not where else f"{s.entry.doc} (only in {where})".lstrip()
        rows.append(
            [s.entry.key, number(s.entry.default), s.entry.unit, s.entry.range, doc, *([where] if beside else [])]
        )
    columns = [title, "default", "unit", "range", "what it is", *(["only in"] if beside else [])]
    print_table(columns, rows, right=("default",))


def some(names: Sequence[str], most: int = 3) -> str:
    """Names in a row, not more of them than a line can hold; ``--json`` has them all."""
    if len(names) <= most:
        return ", ".join(names)
    return f"{', '.join(names[: most - 1])} and {len(names) - most + 1} more"
