"""The reports of ``leadscrew list``: blocks, studies, and what can be set in them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from leadscrew import catalogue, controller_file, resolve
from leadscrew.figures.formats import Setting, first_line, integrated, metric_unit, plain, settings
from leadscrew.figures.table import as_typed, number, unit
from leadscrew.kernel.parameters import entries
from leadscrew.report.report import Lines, Part, Report, TextTable, head
from leadscrew.toml_file import flat
from leadscrew.util.errors import LeadscrewError

if TYPE_CHECKING:
    from leadscrew.kernel.block import Block
    from leadscrew.study_data import Study

SCORES = {"before_held_out": "before, held out", "trained": "tuned, trained", "held_out": "tuned, held out"}
"""The tables of ``[tuning]`` that are shown, and as what."""


# ---- a controller file
def controller(name: str) -> Report:
    """A controller file.

    Raises:
        DataError: its parameters do not fit its controller.
    """
    file = controller_file.read(name)
    of = resolve.from_controller_file(name)
    own = {e.key: e.default for e in entries(resolve.controller(resolve.study(file.study), file.controller).params)}
    sheet = [Setting(e) for e in entries(of.params)]
    parameters = [
        {**s.as_dict(), "value": s.entry.default, "default": own[s.entry.key], "set": s.entry.key in file.parameters}
        for s in sheet
    ]
    rows = [
        [s.entry.key, as_typed(s.entry.default), as_typed(own[s.entry.key]), unit(s.entry.unit), s.entry.range,
         s.entry.doc]
        for s in sheet
        if s.entry.key in file.parameters
    ]  # fmt: skip
    heads = ["parameter", "here", "default", "unit", "range", "what it is"]
    return Report(
        {**head("list"), "file": name, "kind": "controller", "study": file.study, "controller": file.controller,
         "doc": of.doc, "parameters": parameters, "tuning": dict(file.tuning)},
        parts=[
            f"{name}: a controller of {file.study}, {file.controller} with these settings",
            first_line(of.doc),
            TextTable(heads, rows, [False, True, True, False, False, False]),
            *(_tuning(file.tuning) if file.tuning else ()),
            f"leadscrew list {file.study} shows its study, with all that can be set.",
        ],
    )  # fmt: skip


def _tuning(tuning: Mapping[str, Any]) -> Iterator[Part]:
    """Where the settings come from; what a file of another hand does not say is left out."""
    done = f"{tuning['evaluations']} evaluations by " if "evaluations" in tuning else ""
    parts = [f"{done}{tuning.get('optimiser', '')}".strip()]
    parts += [f"{word} {tuning[key]}" for key, word in (("seed", "seed"), ("date", "on"), ("leadscrew", "Leadscrew"))
              if key in tuning]  # fmt: skip
    how = f"made by {tuning['made_by']}" if "made_by" in tuning else "tuned"
    yield f"{how}: {', '.join(p for p in parts if p)}"
    for word, key in (("varied", "vary"), ("over", "over")):
        if isinstance(tuning.get(key), Mapping):
            yield f"{word}: {', '.join(f'{k} = {v}' for k, v in flat(tuning[key]))}"
    shown = {key: title for key, title in SCORES.items() if isinstance(tuning.get(key), Mapping)}
    if shown:
        names = list(dict.fromkeys(n for key in shown for n in tuning[key]))
        rows = [[n, *(number(tuning[key][n]) if n in tuning[key] else "" for key in shown)] for n in names]
        yield TextTable(["goal, constraint", *shown.values()], rows, [False, *[True] * len(shown)])
    for line in [tuning.get("verdict"), *(f"note: {n}" for n in tuning.get("notes") or ())]:
        if line:
            yield str(line)


# ---- all that there is
def everything() -> Report:
    """Studies, blocks, and what makes blocks."""

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
    return Report(
        {**head("list"), "studies": studies, "blocks": blocks, "makers": makers},
        parts=[
            TextTable.words(["study", "title"], [(r["name"], r["doc"]) for r in studies]),
            TextTable.words(
                ["block", "kind", "what it is", "parameters and their defaults"],
                [(r["name"], r["kind"], r["doc"], defaults(r)) for r in blocks],
            ),
            TextTable.words(
                ["made in Python by", "kind", "what it is"],
                [(f"{r['name']}(...)", r["kind"], r["doc"]) for r in makers],
            ),
            "leadscrew list NAME shows what can be set, with unit, default and range.",
        ],
    )


def _short(value: Any) -> str:
    """A default in a few characters; of an array its shape."""
    shape = getattr(value, "shape", None)
    if shape:
        return f"array {'x'.join(map(str, shape))}"
    return f"{value:g}" if isinstance(value, float) else str(value)


# ---- a block
def block(name: str, of: Block) -> Report:
    """A block: what it takes, what it is, what can be set."""
    sheet = [Setting(e) for e in entries(of.params)]
    in_unit = f", in {unit(of.unit)}" if unit(of.unit) else ""
    parts: list[Part] = [f"{name}: {of.kind}{in_unit}; takes {', '.join(of.signals) or 'nothing'}"]
    parts.append(Lines(plain(of.doc).splitlines()))
    if of.drive:
        parts.append(drive(of))
    if of.kind == "plant" and of.sense < 0:
        parts.append("sense: a positive input moves its output towards negative values")
    if of.stiff:
        parts.append("stiff: integrated by rodas unless a loop names a method")
    parts.append(_settings(sheet, "parameter") if sheet else "It has no parameters.")
    return Report(
        {**head("list"), "name": name, "kind": of.kind, "unit": of.unit, "signals": of.signals, "doc": of.doc,
         "drive": of.drive, "full_scale": of.full_scale, "sense": of.sense, "bumpless": of.align is not None,
         "stiff": of.stiff, "parameters": [s.as_dict() for s in sheet]},
        parts=parts,
    )  # fmt: skip


def drive(of: Block) -> str:
    """What a controller's output means at the machine, in one line."""
    full = f", full scale {of.full_scale:g} {unit(of.unit)}".rstrip() if of.full_scale else ""
    way = "positive" if of.sense > 0 else "negative"
    start = "aligned when it is enabled (bumpless)" if of.align is not None else "not bumpless"
    return f"drive: {of.drive}{full}; a positive output moves towards {way} feedback; {start}"


# ---- a study
def study(of: Study) -> Report:
    """A study: controllers, scenarios, what can be set, metrics."""
    loop = of.loop(next(iter(of.controllers)), next(iter(of.scenarios)))
    controllers = [{"name": n, "doc": first_line(b.doc)} for n, b in of.controllers.items()]
    scenarios = [{"name": s.name, "duration_s": s.duration_s, "doc": s.doc} for s in of.scenarios.values()]
    metrics = [{"name": n, "unit": metric_unit(loop, m), "doc": first_line(m.doc)} for n, m in loop.metrics.items()]
    sheet = settings(of)
    loops = {name: of.loop(next(iter(of.controllers)), name) for name in of.scenarios}
    plants = {b.name: b for b in (x.blocks["plant"] for x in loops.values()) if b is not None}
    integration = {name: x.integration for name, x in loops.items()}
    by = ", ".join(dict.fromkeys(filter(None, map(integrated, integration.values()))))
    reversed_ = [b.name for b in plants.values() if b.sense < 0]
    parts: list[Part] = [
        f"{of.name}: {of.title}",
        of.paper,
        TextTable.words(["controller", "what it is"], [(r["name"], r["doc"]) for r in controllers]),
        TextTable(
            ["scenario", "duration (s)", "what is asked"],
            [(s.name, number(s.duration_s), s.doc) for s in of.scenarios.values()],
            [False, True, False],
        ),
        *([f"plant integrated by {by}"] if by else []),
    ]
    if reversed_:
        parts.append(
            f"sense of the drive: a positive input moves {', '.join(reversed_)} towards negative values; a controller "
            "must give a negative output for a positive error"
        )
    parts.append(_settings(sheet, "--set"))
    rows = [(r["name"], unit(r["unit"]), r["doc"]) for r in metrics]
    parts.append(TextTable.words(["metric", "unit", "what it is"], rows))
    return Report(
        {**head("list"), "study": of.name, "title": of.title, "paper": of.paper, "controllers": controllers,
         "plants": [{"name": b.name, "unit": b.unit, "sense": b.sense} for b in plants.values()],
         "scenarios": scenarios, "integration": integration, "settings": [s.as_dict() for s in sheet],
         "metrics": metrics},
        parts=parts,
    )  # fmt: skip


def _settings(sheet: Iterable[Setting], title: str) -> TextTable:
    rows = []
    for s in sheet:
        where = some(s.where)
        doc = f"{s.entry.doc} (only in {where})".lstrip() if where else s.entry.doc
        rows.append([s.entry.key, as_typed(s.entry.default), unit(s.entry.unit), s.entry.range, doc])
    return TextTable([title, "default", "unit", "range", "what it is"], rows, [False, True, False, False, False])


def some(names: Sequence[str], most: int = 3) -> str:
    """Names in a row, not more of them than a line can hold; ``--json`` has them all."""
    if len(names) <= most:
        return ", ".join(names)
    return f"{', '.join(names[: most - 1])} and {len(names) - most + 1} more"
