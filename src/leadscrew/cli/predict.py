"""``leadscrew predict``: what a grey predictor would have said of a logged signal, beside simpler predictors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

import typer

from leadscrew.cli.options import Csv, Json, Log
from leadscrew.cli.output import deliver
from leadscrew.figures.table import fixed, number
from leadscrew.report.report import Report, TextTable, head
from leadscrew.util.errors import DataError, NameUnknown, ValueRefused

if TYPE_CHECKING:
    from leadscrew.grey.score import Score


def predict(
    log: Log,
    column: Annotated[
        str | None, typer.Option(metavar="COLUMN", help="The signal; force, of a folder of simulate feedback.")
    ] = None,
    model: Annotated[str, typer.Option(metavar="NAME", help="gm11, dgm11, verhulst, gm11_shifted, ...")] = "gm11",
    window: Annotated[int, typer.Option(metavar="N", help="Samples of a window, from 4.")] = 5,
    horizon: Annotated[int, typer.Option(metavar="N", help="Samples ahead, from 1.")] = 1,
    reference: Annotated[float | None, typer.Option(metavar="X", help="For gm11_clamped: what is asked for.")] = None,
    shift: Annotated[float | None, typer.Option(metavar="X", help="For gm11_shifted: added before the fit.")] = None,
    first: Annotated[int, typer.Option("--from-row", metavar="N", help="First row of data used, from 1.")] = 1,
    final: Annotated[int | None, typer.Option("--to-row", metavar="N", help="Last row of data used.")] = None,
    csv: Csv = None,
    as_json: Json = False,
) -> None:
    """How well a grey model predicts a logged signal, beside its last value, a line and two points.

    Each prediction uses the samples up to one row and is compared with the row --horizon later. Near a set-point
    GM(1,1) is a fixed filter that amplifies noise: there the last value is usually better.
    """
    from leadscrew.grey.predictors import KINDS
    from leadscrew.grey.score import BESIDE, compare
    from leadscrew.kernel.parameters import nearest
    from leadscrew.logs import read_table
    from leadscrew.logs.roles import candidates

    if model not in KINDS:
        raise NameUnknown(f"--model {model!r}: there is no such predictor{nearest(model, list(KINDS))}")
    options = _options(model, window, horizon, reference, shift)
    column = column or ("feedback" if log.is_dir() else "force")
    table = read_table(log)
    y = table.numbers(column)
    if not candidates(list(table.columns), "time"):
        table.evenly(1.0)
    rows = len(y)
    final = rows if final is None else final
    if not 1 <= first < final <= rows:
        raise ValueRefused(f"--from-row {first} --to-row {final}: expected two rows in order, of 1 to {rows} in {log}")
    y = y[first - 1 : final]
    try:
        scores, made = compare(y, tuple(dict.fromkeys((model, *BESIDE))), window, horizon, **options)
    except DataError as error:
        raise DataError(f"{log}, column {column!r}: {error}") from None
    said = _sentence(scores[0], {s.model: s.rmse for s in scores})
    count = len(y) - window - horizon + 1
    data = {
        **head("predict"), "log": str(log), "column": column, "model": model, "window": window, "horizon": horizon,
        "first_row": first, "last_row": final, "samples": len(y), "predictions": count, "says": said,
        "scores": [
            {"model": s.model, "rmse": s.rmse, "worst": s.worst, "bias": s.bias, "better_share": s.better_share,
             "against_last": s.against_last, "verdict": s.verdict}
            for s in scores
        ],
    }  # fmt: skip
    base = next(s.rmse for s in scores if s.model == "last")
    ahead = "one sample" if horizon == 1 else f"{horizon} samples"
    report = Report(
        data,
        parts=[_table(scores, base), f"{count} predictions {ahead} ahead, windows of {window}.", said],
        csv=lambda: _csv(column, first, horizon, window, y, made),
    )
    deliver(report, csv=csv, as_json=as_json)


def _table(scores: Sequence[Score], base: float) -> TextTable:
    """The predictors; ``base`` is the RMSE of the last value."""
    rows = []
    for s in scores:
        last = s.model == "last"
        rows.append(
            [s.model, number(s.rmse), fixed(s.rmse / base, 3) if base > 0.0 else "", number(s.worst), number(s.bias, 2),
             "" if last else f"{100.0 * s.better_share:.0f} %", "" if last else s.verdict]
        )  # fmt: skip
    heads = ["predictor", "RMSE", "of last", "worst error", "mean error", "nearer than last", "against last"]
    return TextTable(heads, rows, [False, *[True] * 5, False])


def _options(model: str, window: int, horizon: int, reference: float | None, shift: float | None) -> dict[str, float]:
    if window < 4:
        raise ValueRefused(f"--window {window}: expected 4 samples or more")
    if horizon < 1:
        raise ValueRefused(f"--horizon {horizon}: expected 1 sample or more")
    given = {"reference": ("gm11_clamped", reference), "shift": ("gm11_shifted", shift)}
    options = {}
    for name, (owner, value) in given.items():
        if model != owner and value is not None:
            raise ValueRefused(f"--{name} {value!r}: is read by --model {owner} only, not by {model}")
        if model == owner:
            if value is None or not abs(value) < float("inf"):
                what = "is missing" if value is None else f"{value!r}"
                raise ValueRefused(f"--{name} {what}: --model {owner} needs it, a finite number")
            options[name] = value
    return options


def _sentence(score, rmse: dict[str, float]) -> str:
    """What the comparison says of the model that was asked for."""
    if score.model in ("last", "line", "two_point"):
        best = min(rmse, key=lambda name: rmse[name])
        return f"Smallest RMSE here: {best}."
    others = {name: rmse[name] for name in ("last", "line", "two_point")}
    best = min(others, key=lambda name: others[name])
    beside = f"best of the others: {best}, RMSE {others[best]:.4g}"
    match score.verdict:
        case "better":
            first = f"{score.model} predicts this signal better than its last value does"
        case "worse":
            first = f"{score.model} predicts this signal worse than its last value does"
        case _:
            share = f"{score.rmse / rmse['last']:.2f} times the RMSE of" if rmse["last"] > 0.0 else "the RMSE of"
            first = f"{score.model} has {share} the last value, within two standard errors: not decided by these rows"
    return f"{first} ({beside})."


def _csv(column: str, first: int, horizon: int, window: int, y, made) -> str:
    """One row a sample: the row that it has in the log, its value, and the prediction of each model for it."""
    lines = [",".join(["row", column, *made])]
    for i in range(window - 1 + horizon, len(y)):
        cells = [f"{made[name][i - horizon]:.9g}" for name in made]
        lines.append(",".join([str(first + i), f"{y[i]:.9g}", *cells]))
    return "\n".join(lines) + "\n"
