"""A linear model from a log for reading: rows of tables, sentences, JSON, a page with pictures."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from leadscrew import escape
from leadscrew.identify.linear.result import LinearFit
from leadscrew.identify.linear.uncertainty import Interval
from leadscrew.newfolder import appearing
from leadscrew.report import page as html
from leadscrew.report.strict import strict
from leadscrew.report.tables import NOTHING

SCHEMA_VERSION = 1
WIDE = 500.0
"""Percent of the value that half an interval may be wide, for its ends to be worth printing."""
PARAMETER_COLUMNS = ("parameter", "value", "95 % from", "to", "unit", "")
CANDIDATE_COLUMNS = ("model", "delay s", "training rms", "hold-out rms", "")
STRETCH_COLUMNS = ("part", "from s", "to s", "rms", "worst", "% of range", "fit %")
NUMBERS = {*PARAMETER_COLUMNS[1:4], *CANDIDATE_COLUMNS[1:4], *STRETCH_COLUMNS[1:]}
"""Columns to be set to the right."""


def num(value: float, digits: int = 4) -> str:
    """A number with some significant digits, a dash for none."""
    return f"{value:.{digits}g}" if np.isfinite(value) else NOTHING


def parameter_rows(fit: LinearFit) -> list[list[str]]:
    """Gain, poles, zeros, delay, offset; then the coefficients."""
    rows = [_row(_name(fit, key), p) for key, p in fit.parameters.items()]
    rows.append(_row("input offset" if fit.structure.integrators else "output offset", fit.offset))
    return rows + [_row(key, p) for key, p in fit.coefficients.items()]


def _name(fit: LinearFit, key: str) -> str:
    if key == "gain" and fit.structure.integrators:
        return ("speed gain", "acceleration gain")[fit.structure.integrators - 1]
    return {"delay_s": "delay"}.get(key, key)


def _row(name: str, p: Interval) -> list[str]:
    if p.low == p.high:
        return [name, num(p.value, 5), NOTHING, NOTHING, p.unit, "given"]
    if not p.told and p.percent > WIDE:
        return [name, num(p.value, 5), NOTHING, NOTHING, p.unit, "not told"]
    return [name, num(p.value, 5), num(p.low, 5), num(p.high, 5), p.unit, "" if p.told else "not told"]


def candidate_rows(fit: LinearFit) -> list[list[str]]:
    """All structures that were tried, simplest first."""
    return [
        [
            c.structure.text,
            num(_delay(fit, c.delay_s), 3),
            _sized(fit, c.train_rms),
            _sized(fit, c.holdout_rms),
            c.against,
        ]
        for c in fit.candidates
    ]


def _delay(fit: LinearFit, delay_s: float) -> float:
    """Zero where the search ended on its bound."""
    return delay_s if delay_s > 1e-4 * fit.period else 0.0


def _sized(fit: LinearFit, value: float) -> str:
    """In the output's unit."""
    return num(value) + (f" {fit.output_unit}" if fit.output_unit != "1" and np.isfinite(value) else "")


def stretch_rows(fit: LinearFit) -> list[list[str]]:
    """Errors of simulation on training and hold-out."""
    return [
        [
            s.what,
            num(s.start_s),
            num(s.end_s),
            _sized(fit, s.rms),
            _sized(fit, s.worst),
            num(s.nrmse_percent, 3),
            f"{s.fit_percent:.2f}",
        ]
        for s in fit.stretches
    ]


def polynomial(values: Sequence[float] | np.ndarray) -> str:
    """``s^2 + 144.8 s + 166.3``."""
    said: list[str] = []
    degree = len(values) - 1
    for k, value in enumerate(values):
        power = degree - k
        if value == 0.0 and len(values) > 1:
            continue
        size = num(abs(value), 5)
        factor = "" if power == 0 else "s" if power == 1 else f"s^{power}"
        text = factor if size == "1" and factor else f"{size} {factor}".strip()
        said.append((("- " if value < 0.0 else "+ ") if said else ("-" if value < 0.0 else "")) + text)
    return " ".join(said)


def equation(fit: LinearFit) -> str:
    """The transfer function in one line."""
    above, below = polynomial(fit.numerator), polynomial(fit.denominator)
    above = f"({above})" if " " in above and fit.structure.zeros else above
    return f"{above} / ({below}) exp(-{num(_delay(fit, fit.delay_s))} s)"


def sentences(fit: LinearFit) -> list[str]:
    """The result in words, a line each."""
    low, high = fit.excited_hz
    tried = len(fit.candidates)
    how = (
        f"the simplest of {tried} within {100.0 * fit.margin:g} % of the least hold-out error"
        if tried > 1
        else "asked for"
    )
    return [
        f"{fit.input_name} ({fit.input_unit}) to {fit.output_name} ({fit.output_unit}), every {num(fit.period)} s: "
        f"{equation(fit)}",
        f"{fit.structure.text}: {how}; {fit.method}",
        f"the input speaks from {num(low, 3)} to {num(high, 3)} Hz; condition number {num(fit.condition, 2)}",
        f"residual: {fit.whiteness:.0f} % of autocorrelations as of white noise (95 expected); with the input before "
        f"{fit.missed:.1f}, after {fit.feedback:.1f} deviations (above 4 is no chance)",
    ]  # fmt: skip


def summary(fit: LinearFit, log: str) -> dict[str, Any]:
    """The one JSON object of ``leadscrew identify linear --json``."""
    return {
        "schema_version": SCHEMA_VERSION, "kind": "leadscrew identify linear", "log": log, **fit.as_dict(),
        "sentences": sentences(fit),
    }  # fmt: skip


def write(fit: LinearFit, folder: str | Path) -> None:
    """Writes ``report.html``, ``linear.json`` and the pictures ``linear_*.png``; complete, or not at all.

    Raises:
        DataError: the folder exists already and is not empty, or cannot be written.
    """
    from leadscrew.report.identified_linear_picture import pictures

    with appearing(folder) as place:
        drawn = pictures(fit)
        for name, (figure, _) in drawn.items():
            figure.savefig(place / f"linear_{name}.png", dpi=130, metadata={"Software": None})
        found = strict(summary(fit, fit.source))
        (place / "linear.json").write_text(json.dumps(found, indent=1, allow_nan=False) + "\n", encoding="utf-8")
        (place / "report.html").write_text(_page(fit, drawn), encoding="utf-8")


def _page(fit: LinearFit, drawn: dict[str, Any]) -> str:
    title = f"Linear model: {fit.input_name} to {fit.output_name}"
    lines = [*sentences(fit), *(f"note: {n}" for n in fit.notes), *(f"next: {a}" for a in fit.advice)]
    parts = [
        f"<p>{escape.html(fit.source)}</p>",
        *html.paragraphs(lines),
        html.table("Errors of simulation", STRETCH_COLUMNS, stretch_rows(fit), NUMBERS),
        html.table("Parameters", PARAMETER_COLUMNS, parameter_rows(fit), NUMBERS),
        *(html.picture(figure, name, caption, caption) for name, (figure, caption) in drawn.items()),
        html.table("Models tried", CANDIDATE_COLUMNS, candidate_rows(fit), NUMBERS),
    ]
    return html.page(title, parts)
