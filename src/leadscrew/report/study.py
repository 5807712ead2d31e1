"""The report of an evaluated study."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from functools import partial
from typing import Any

from leadscrew.figures.formats import plain
from leadscrew.figures.table import NOTHING, number, unit
from leadscrew.report.report import KIND, KeyNumber, Picture, Section, StudyReport, TextTable
from leadscrew.studies.claims import SCHEMA_VERSION, VERDICTS, Claim
from leadscrew.studies.exhibits import Experiment, FigureOf
from leadscrew.studies.results import Miss, Results
from leadscrew.util.strict_json import strict

COLUMNS_EXPLAINED = (
    "*As printed* is what the paper's own equations and numbers give. *Corrected* is with the changes that the note or "
    "the method names. *Ours* is a controller or method of this program; the verdict on the paper does not use it. "
    "What was fitted to a statement counts as fitted, not as reproduced."
).replace("*", "")


_MINUS = re.compile(r"(?<![\w.])-(?=\d)")
"""A hyphen that is a minus."""


def report_of(results: Results, saved: Sequence[tuple[str, str]] = (), command: str = "") -> StudyReport:
    """The report; ``saved``: key and folder of each run that is saved beside it, ``command``: how to make it again."""
    study = results.study
    pictures = [picture_of(results, f) for f in results.figures]
    key = next((p for p, f in zip(pictures, results.figures, strict=True) if f.key), None)
    key_claims = [c for c in results.claims if c.key]
    sections = [
        Section("What the paper says", [COLUMNS_EXPLAINED], [claims_table(results.claims)], anchor="claims"),
        Section("Beyond the paper", sections=[experiment_section(e) for e in results.experiments], anchor="beyond"),
        Section("Figures", pictures=[p for p in pictures if p is not key], anchor="figures"),
        Section("What we assumed", tables=[assumed_table(study.assumed)], anchor="assumed"),
        Section("Method", study.method, anchor="method"),
        Section("Limits", study.limits, anchor="limits"),
        Section("Runs", RUNS_EXPLAINED, [runs_table(results, saved)] if saved else (), anchor="runs"),
    ]
    return StudyReport(
        name=study.name,
        title=study.title,
        citation=study.paper,
        conclusion=results.conclusion,
        key_table=claims_table(key_claims, short=True) if key_claims else None,
        key_picture=key,
        key_numbers=[card_number(c) for c in on_card(results, key_claims)],
        lines=[e.conclusion for e in results.experiments],
        sections=[s for s in sections if not _empty(s)],
        counts={v: n for v in VERDICTS if (n := sum(c.verdict == v for c in results.claims))},
        missed=[missed_line(m) for m in results.missed],
        data=data_of(results),
        command=command,
    )


def summary_of(results: Results, command: str = "") -> StudyReport:
    """Conclusion, key claims and key figure alone, as the demo shows them."""
    from dataclasses import replace

    whole = report_of(results, command=command)
    note = f"Only the key claims are judged here. `leadscrew run {results.study.name}` judges all."
    return replace(whole, sections=(), lines=(), counts={}, notes=[note])


def _empty(section: Section) -> bool:
    tables = [t for t in section.tables if t.rows]
    return not (tables or section.pictures or section.sections or (section.paragraphs and not section.tables)) or (
        section.anchor == "runs" and not tables
    )


# ---- claims
def claims_table(claims: Iterable[Claim], short: bool = False) -> TextTable:
    """Claims as rows; ``short``: without source, id and note. A column of ours only where a claim has one."""
    claims = list(claims)
    ours = any(c.ours is not None for c in claims)
    heads = ["statement", "paper", "as printed", "corrected", *(["ours"] if ours else []), "unit", "verdict"]
    rows = [
        [
            _MINUS.sub("−", plain(c.statement)),
            says(c),
            number(c.as_printed),
            number(c.corrected),
            *([number(c.ours)] if ours else []),
            unit(c.unit),
            c.verdict,
            *([] if short else [c.note]),
        ]
        for c in claims
    ]
    heads = heads if short else [*heads, "note"]
    return TextTable(
        heads,
        rows,
        [h in ("paper", "as printed", "corrected", "ours") for h in heads],
        below=() if short else [f"{c.source} · {c.basis} · {c.id}" for c in claims],
        ids=() if short else [c.id for c in claims],
        verdict=heads.index("verdict"),
    )


def says(claim: Claim) -> str:
    """What the paper says, with its digits; a true minus before a number."""
    text = claim.says
    return f"−{text[1:]}" if text.startswith("-") and text[1:2].isdigit() else text or NOTHING


def with_number(claims: Iterable[Claim]) -> list[Claim]:
    """The claims that have a number in the corrected column, or else in that of the printed system.

    Where the paper, too, gives a number in three of them, those alone.
    """
    measured = [c for c in claims if isinstance(_value(c), int | float)]
    printed = [c for c in measured if _is_number(c.says)]
    return printed if len(printed) >= 3 else measured


def on_card(results: Results, claims: Iterable[Claim]) -> list[Claim]:
    """The claims whose numbers stand on the card of the study."""
    known = {c.id.removeprefix(f"{results.study.name}."): c for c in claims}
    return [known[name] for name in results.study.card if name in known] or with_number(known.values())[-3:]


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _value(claim: Claim) -> Any:
    return claim.corrected if claim.corrected is not None else claim.as_printed


def card_number(claim: Claim) -> KeyNumber:
    """A claim's number with its unit, and what it is."""
    whose = "corrected" if claim.corrected is not None else "as printed"
    paper = f"{says(claim)} {unit(claim.unit)}".strip() if _is_number(claim.says) else says(claim)
    return KeyNumber(
        f"{number(_value(claim), 3)} {unit(claim.unit)}".strip(),
        f"{_MINUS.sub('−', plain(claim.statement))}: {whose} (paper: {paper})",
    )


def missed_line(miss: Miss) -> str:
    """A number that is not the expected one."""
    target = f"{miss.target} ± {miss.tolerance:g}" if miss.tolerance else miss.target
    measured = "not measured" if miss.value is None else _exact(miss.value)
    return f"MISSED {miss.id}: {measured}, expected {target}"


def _exact(value: Any) -> str:
    return f"{value:.12g}" if isinstance(value, float) else str(value)


# ---- the rest
def experiment_section(shown: Experiment) -> Section:
    """An experiment below its question."""
    return Section(
        shown.question,
        [plain(shown.method)] if shown.method else [],
        [TextTable.of(shown.table)],
        conclusion=shown.conclusion,
        anchor=shown.name,
    )


def picture_of(results: Results, figure: FigureOf) -> Picture:
    """A figure of the study, drawn from what was measured."""
    return Picture(figure.name, figure.caption, partial(figure.draw, results.lab))


def assumed_table(assumed: Iterable[Any]) -> TextTable:
    """What the paper does not give."""
    return TextTable.words(["what", "value", "why"], [list(a) for a in assumed])


RUNS_EXPLAINED = (
    "Every signal of these runs is in `signals.parquet` in its folder beside this page, with its manifest `run.json`. "
    "The command, given in this folder, repeats a run and compares it bit by bit.",
)


def runs_table(results: Results, saved: Iterable[tuple[str, str]]) -> TextTable:
    """The saved runs, and the command that repeats each."""
    rows = []
    for key, folder in saved:
        run = results.lab.runs[key]
        rows.append([key, number(float(run.duration)), str(run.diverged or "finished"), f"`leadscrew replay {folder}`"])
    return TextTable(["run", "duration (s)", "end", "to repeat it"], rows, [False, True, False, False])


def data_of(results: Results) -> dict[str, Any]:
    """The results as plain values for JSON; a number that is not finite is ``None``."""
    from leadscrew._version import __version__

    data: dict[str, Any] = strict(
        {
            "study": results.study.name,
            "title": results.study.title,
            "version": __version__,
            "schema_version": SCHEMA_VERSION,
            "kind": KIND,
            "conclusion": results.conclusion,
            "claims": [c.as_dict() for c in results.claims],
            "experiments": [e.as_dict() for e in results.experiments],
            "missed": [m._asdict() for m in results.missed],
        }
    )
    return data
