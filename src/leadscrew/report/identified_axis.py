"""An identified axis for reading: rows of tables and JSON. Pictures and page are modules of their own."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from leadscrew.logs.measure import beyond_step
from leadscrew.report.identified_axis_words import (
    digits_of,
    force_unit,
    length,
    merged,
    name_of,
    num,
    open_loop,
    scaled,
    sentences,
    state_of,
    why,
)

if TYPE_CHECKING:
    from leadscrew.identify.axis.result import AxisFit

SCHEMA_VERSION = 1
PARAMETER_COLUMNS = ("parameter", "value", "95 % from", "to", "unit", "how", "what")
SCORE_COLUMNS = ("stretch", "from s", "to s", "rms", "worst", "% of range", "force rms", "% of force", "white %")
RECORD_COLUMNS = ("of the log", "value")
NUMBERS = {*PARAMETER_COLUMNS[1:4], *SCORE_COLUMNS[1:], "value"}
"""Columns to be set to the right."""


def parameter_rows(fit: AxisFit, reasons: bool = True) -> list[list[str]]:
    """One row for each parameter: key, value, interval, unit, how it was found, what it is.

    With ``reasons`` also why it is not fitted, where it is not.
    """
    rows = []
    for key, p in merged(fit).items():
        note = why(p) if reasons else ""
        digits = digits_of(p)
        rows.append([key, num(p.value, digits), num(p.low, digits), num(p.high, digits), p.unit, state_of(p),
                     name_of(fit, key) + (f": {note}" if note else "")])  # fmt: skip
    return rows


def reason_lines(fit: AxisFit) -> list[str]:
    """What is to be said of single parameters, a line for each reason with the keys that it is about."""
    found: dict[str, list[str]] = {}
    for key, p in merged(fit).items():
        if why(p):
            found.setdefault(why(p), []).append(key)
    return [f"{', '.join(keys)}: {reason}" for reason, keys in found.items()]


def score_rows(fit: AxisFit) -> list[list[str]]:
    """Errors by stretch of the log: of the simulated position, and of the drive's force by inverse dynamics."""
    force = force_unit(fit)
    return [
        [j.what, num(j.start_s), num(j.end_s), length(fit, j.rms), length(fit, j.worst), num(j.nrmse_percent, 3),
         f"{num(j.rms_force, 3)} {force}", num(j.force_percent, 3), num(j.whiteness, 3)]
        for j in fit.judged
    ]  # fmt: skip


def compared_table(fit: AxisFit) -> tuple[list[str], list[list[str]]]:
    """Models that were tried: headers and rows, in the words of the fitter."""
    keys = list(dict.fromkeys(key for row in fit.compared for key in row))
    rows = [[_cell(fit, key, row.get(key)) for key in keys] for row in fit.compared]
    return [_header(key) for key in keys], rows


def correlation_table(fit: AxisFit) -> tuple[list[str], list[list[str]]]:
    """Correlations of the estimates, below the diagonal."""
    keys = [k for k in fit.parameters if k in fit.correlation]
    rows = [[row, *(num(fit.correlation[row].get(column), 2) if j < i else "" for j, column in enumerate(keys[:-1]))]
            for i, row in enumerate(keys) if i]  # fmt: skip
    return ["", *keys[:-1]], rows


def record_rows(fit: AxisFit) -> list[list[str]]:
    """What the log is like: what a reader needs to judge the fit."""
    unit = fit.position_unit
    return [
        ["period", scaled(fit.period, "s")],
        ["step of the encoder", length(fit, fit.encoder_step) if fit.encoder_step > 0.0 else "not seen"],
        ["noise of the position, rms", length(fit, fit.noise) + _rounding(fit)],
        ["travel", f"{length(fit, fit.travel[0])} to {length(fit, fit.travel[1])}"],
        ["largest speed", scaled(fit.top_speed, f"{unit}/s")],
        ["largest acceleration", f"{num(fit.top_acceleration)} {unit}/s^2"],
        ["largest drive", f"{num(fit.top_drive, 4)} {fit.drive_unit}"],
        ["condition number of the fit", num(fit.condition, 3)],
    ]


def _rounding(fit: AxisFit) -> str:
    """Where the noise comes from, if only from the encoder."""
    beyond = beyond_step(fit.noise, fit.encoder_step) or not fit.encoder_step
    return "" if beyond else ", none beyond the rounding to the encoder's steps"


def summary(fit: AxisFit) -> dict[str, Any]:
    """The result as the one JSON object that ``leadscrew identify axis --json`` prints."""
    seen, unseen = open_loop(fit)
    ratio = unseen.rms / seen.rms if seen is not None and unseen is not None and seen.rms > 0.0 else None
    return {
        "schema_version": SCHEMA_VERSION, "kind": "leadscrew identify axis", **fit.as_dict(),
        "holdout_over_training": ratio, "sentences": sentences(fit),
    }  # fmt: skip


def _header(key: str) -> str:
    return key.replace("holdout", "hold-out").replace("_percent", " %").replace("_", " ")


def _cell(fit: AxisFit, key: str, value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return length(fit, value) if "rms" in key and "force" not in key else num(value, 3)
    return "" if value is None else str(value)
