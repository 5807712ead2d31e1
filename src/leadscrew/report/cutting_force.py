"""Force laws of a table for reading: rows of tables, sentences, JSON, a picture, a page."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.analysis.cutting_force import ChipAndEdge, Kienzle, PowerLaw, kienzle, r_squared, specific_force
from leadscrew.figures.style import BLACK, BLUE, GREEN, ORANGE, VERMILION
from leadscrew.figures.table import NOTHING, finite, fixed
from leadscrew.figures.table import unit as shown_unit
from leadscrew.identify.cutting_force import ForceFit, LawFit
from leadscrew.identify.estimation import Interval, Parameter
from leadscrew.report import page as html
from leadscrew.report.report import Report, TextTable, head
from leadscrew.util import escape
from leadscrew.util.atomic import atomic_folder
from leadscrew.util.escape import one_line
from leadscrew.util.strict_json import strict

if TYPE_CHECKING:
    from leadscrew.figures.figure import Figure


MARKS = "osD^vP*X"
MOST_DEPTHS = len(MARKS)
"""Depths that have a mark each; of more, the laws are drawn for the least, the middle and the largest."""
MOST_BARS = 60


def picture(fit: ForceFit, title: str = "", beside: Kienzle | None = None) -> Figure:
    """Force and specific force against feed, measured and by the laws, and what is left in each row."""
    from leadscrew.figures.figure import Figure

    figure = Figure(figsize=(11.0, 4.0), layout="constrained")
    left, middle, right = figure.subplots(1, 3)
    t = fit.table
    low, high = float(t.feed.min()) / 1.3, float(t.feed.max()) * 1.3
    f = np.geomspace(low, high, 80)
    laws: list[tuple[str, Any, str, Any]] = [("power law", fit.law, BLUE, "-")]
    for name, other in fit.others.items():
        if isinstance(other.law, ChipAndEdge):
            laws.append(("chip and edge", other.law, GREEN, "-."))
        elif "depth_exponent" in other.parameters and name:
            laws.append(("with depth exponent", other.law, VERMILION, "--"))
    if beside is not None:
        laws.append((f"given: {beside.kc11:g}, {beside.mc:g}", beside, ORANGE, ":"))
    shade = np.unique(t.depth)
    kind: dict[str, Any] = {"linestyle": "none", "color": BLACK, "fillstyle": "none"}
    if len(shade) > MOST_DEPTHS:
        left.plot(t.feed, t.force, marker=".", markersize=3, alpha=0.5, **kind, label="cuts", rasterized=True)
        kc = specific_force(t.force, t.feed, t.depth)
        middle.plot(t.feed, kc, marker=".", markersize=3, alpha=0.5, **kind, rasterized=True)
        shade = shade[[0, len(shade) // 2, -1]]
    else:
        for k, depth in enumerate(shade):
            rows = t.depth == depth
            left.plot(t.feed[rows], t.force[rows], marker=MARKS[k], **kind, label=f"depth {depth:g} mm")
            kc = specific_force(t.force[rows], t.feed[rows], t.depth[rows])
            middle.plot(t.feed[rows], kc, marker=MARKS[k], **kind)
    for name, law, colour, line in laws:
        for depth in shade:
            shown = name if depth == shade[0] else None
            left.plot(f, law.force(f, depth), color=colour, linestyle=line, linewidth=1.1, label=shown)
        # laws in proportion to the depth have one specific force for all depths
        for depth in shade if isinstance(law, PowerLaw) and law.depth_exponent != 1.0 else shade[-1:]:
            middle.plot(f, specific_force(law.force(f, depth), f, depth), color=colour, linestyle=line, linewidth=1.1)
    for ax in (left, middle):
        ax.set(xscale="log", yscale="log", xlabel="feed (mm/rev)")
        _plain_ticks(ax)
    left.set_ylabel("main cutting force (N)")
    middle.set_ylabel("specific cutting force (N/mm²)")
    at = np.arange(len(t.force))
    if len(at) > MOST_BARS:
        right.plot(t.rows, fit.chosen.left_out_percent, ".", color=ORANGE, markersize=3, label="row left out",
                   rasterized=True)  # fmt: skip
    else:
        right.bar(at - 0.2, fit.chosen.residual_percent, 0.4, color=BLUE, label="row in the fit")
        right.bar(at + 0.2, np.nan_to_num(fit.chosen.left_out_percent), 0.4, color=ORANGE, label="row left out")
        ticks = at if len(at) <= 20 else at[:: len(at) // 10]
        right.set_xticks(ticks, [str(t.rows[int(i)]) for i in ticks])
    right.axhline(0.0, color=BLACK, linewidth=0.6)
    right.set(xlabel="row of the table", ylabel="measured over power law, minus 1 (%)")
    for ax in (left, middle, right):
        ax.grid(color="0.92", linewidth=0.6)
        ax.set_axisbelow(True)
    if title:
        figure.suptitle(escape.figure(title), fontsize="medium")
    figure.legend(loc="outside lower center", ncols=6, frameon=False, fontsize="small")
    return figure


def _plain_ticks(ax: Any) -> None:
    from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 3.0, 5.0)))
        axis.set_major_formatter(StrMethodFormatter("{x:g}"))
        axis.set_minor_formatter(NullFormatter())


def law_table(fit: ForceFit, drawn: Mapping[str, Parameter] | None = None) -> TextTable:
    """Parameters with their intervals: power law, Kienzle's, chip and edge; ``drawn`` are bootstrap intervals."""
    found, same, law = fit.chosen.parameters, kienzle(fit.law, fit.kappa_deg), "F = Kf a f^P"
    kf, exponent = found["kf"], found.get("exponent")
    rows = [_row("Kf", kf, "N/mm^(1+P)", law)]
    if exponent is None:
        rows.append(["P", finite(fit.law.exponent), NOTHING, NOTHING, "given", law])
    else:
        rows.append(_row("P", exponent, "", law))
    for name, interval in (drawn or {}).items():
        rows.append(_row({"kf": "Kf", "exponent": "P"}[name], interval, "", "the same, bootstrap"))
    chip = f"F = kc11 b h^(1-mc), {fit.kappa_deg:g} deg"
    rows.append(_row("kc11", _kc11(fit), "N/mm^2", chip))
    if exponent is not None:
        rows.append(_row("mc", Interval(same.mc, 1.0 - exponent.high, 1.0 - exponent.low), "", chip))
    middle = f"at {finite(_middle(fit.table.feed), 3)} mm/rev, {finite(_middle(fit.table.depth), 3)} mm"
    rows.append(_row("kc", fit.chosen.middle, "N/mm^2", middle))
    for name, other in fit.others.items():
        if isinstance(other.law, ChipAndEdge):
            rows.append(_row("Ktc", other.parameters["ktc"], "N/mm^2", "F = Ktc a f + Kte b"))
            rows.append(_row("Kte", other.parameters["kte"], "N/mm", "F = Ktc a f + Kte b"))
        elif "depth_exponent" in other.parameters and name:
            rows.append(_row("q", other.parameters["depth_exponent"], "", "F = K a^q f^P"))
    heads = ("parameter", "value", "95 % from", "to", "unit", "law")
    return TextTable(heads, rows, [False, *[True] * 3, False, False], title="Parameters")


def fit_table(fit: ForceFit, beside: Kienzle | None = None) -> TextTable:
    """Errors of every fit on the same rows, and of a law from elsewhere."""
    rows = [_fit_row(f"power law, {fit.chosen.method}", fit.chosen)]
    rows += [_fit_row(name, other) for name, other in fit.others.items()]
    if beside is not None:
        left = errors(fit, beside)
        name = f"given: kc11 {beside.kc11:g}, mc {beside.mc:g}"
        r2 = left["r2"]
        rows.append([name, finite(left["rms_percent"], 3), finite(left["worst_percent"], 3), NOTHING,
                     finite(left["rms_n"], 3), *_r2(r2), NOTHING])  # fmt: skip
    heads = ("fit", "rms (%)", "worst (%)", "left out (%)", "rms (N)", "R² of F", "R² of ln F", "R² of ln kc",
             "condition")  # fmt: skip
    return TextTable(heads, rows, [False, *[True] * 8], title="Fits")


def errors(fit: ForceFit, law: Kienzle) -> dict[str, Any]:
    """What a law from elsewhere leaves of the cuts of this table: its law is not fitted to it."""
    t = fit.table
    modelled = law.force(t.feed, t.depth)
    off = 100.0 * (t.force / modelled - 1.0)
    kc = np.log(specific_force(t.force, t.feed, t.depth))
    return {
        "kc11": law.kc11, "mc": law.mc,
        "rms_percent": float(np.sqrt(np.mean(off**2))), "worst_percent": float(np.abs(off).max()),
        "rms_n": float(np.sqrt(np.mean((t.force - modelled) ** 2))),
        "r2": {
            "force": r_squared(t.force, modelled), "log force": r_squared(np.log(t.force), np.log(modelled)),
            "log specific force": r_squared(kc, np.log(specific_force(modelled, t.feed, t.depth))),
        },
    }  # fmt: skip


def cut_table(fit: ForceFit) -> TextTable:
    """One row for each cut."""
    t = fit.table
    kc, modelled = specific_force(t.force, t.feed, t.depth), fit.law.force(t.feed, t.depth)
    rows = [
        [str(t.rows[i]), finite(t.feed[i]), finite(t.depth[i]), fixed(t.force[i], 1), fixed(kc[i], 0),
         fixed(modelled[i], 1), fixed(fit.chosen.residual_percent[i], 1), fixed(fit.chosen.left_out_percent[i], 1)]
        for i in range(len(t.force))
    ]  # fmt: skip
    heads = ("row", "feed (mm/rev)", "depth (mm)", "force (N)", "kc (N/mm²)", "law (N)", "off (%)", "left out (%)")
    return TextTable(heads, rows, [True] * 8, title="Cuts")


def at_table(fit: ForceFit, cuts: Sequence[tuple[float, float]]) -> TextTable:
    """Forces of cuts that were not made."""
    rows = []
    for feed, depth in cuts:
        found, inside = fit.force(feed, depth)
        rows.append([finite(feed), finite(depth), *(finite(x) for x in found), "" if inside else "outside the table"])
    heads = ("feed (mm/rev)", "depth (mm)", "force (N)", "95 % from", "to", "")
    return TextTable(heads, rows, [True] * 5 + [False], title="Forces asked for")


def settings(fit: ForceFit) -> list[str]:
    """The parameters of a turning plant, as ``KEY=VALUE``; none where the exponent is one that no plant takes."""
    if not 0.0 < fit.law.exponent <= 1.0:
        return []
    found = [f"plant.law.kf={fit.law.kf:.6g}", f"plant.law.exponent={fit.law.exponent:.6g}"]
    ratio = ratios(fit).get("feed_force")
    return found if ratio is None else [*found, f"plant.feed_force_ratio={ratio[0]:.4g}"]


def for_simulation(fit: ForceFit, option: str = "") -> str:
    """The parameters in one line, each behind an option; or why there are none."""
    if not settings(fit):
        return f"not for a simulation: an exponent of {fit.law.exponent:.4g}, where a plant takes one in (0, 1]"
    return f"for a simulation: {' '.join(f'{option}{pair}' for pair in settings(fit))}"


def ratios(fit: ForceFit) -> dict[str, tuple[float, float, float]]:
    """Median, least and largest ratio of the other components of the force to the main one."""
    return {
        name: (float(np.median(x)), float(x.min()), float(x.max()))
        for name in ("feed_force", "passive_force")
        if name in fit.table.others
        for x in [fit.table.others[name] / fit.table.force]
    }


def sentences(fit: ForceFit) -> list[str]:
    """The result in words, a line each."""
    t, chosen = fit.table, fit.chosen
    lines = [
        f"{len(t.force)} cuts, feed {finite(t.feed.min())} to {finite(t.feed.max())} mm/rev, depth "
        f"{finite(t.depth.min())} to {finite(t.depth.max())} mm, main force {finite(t.force.min())} to "
        f"{finite(t.force.max())} N",
        f"a cut that the fit has not seen is off by {finite(chosen.left_out_rms_percent, 3)} % (root mean square)",
    ]
    if fit.depth is not None and fit.depth.p_value >= 0.05:
        q = fit.depth.exponent
        lines.append(
            f"in proportion to the depth: exponent {q.value:.3f} ({q.low:.3f} to {q.high:.3f}), p = "
            f"{fit.depth.p_value:.2g} for 1"
        )
    for name, (middle, low, high) in ratios(fit).items():
        lines.append(f"{name.replace('_', ' ')} over main force: {middle:.3g} (median; {low:.3g} to {high:.3g})")
    return lines


def summary(
    fit: ForceFit, source: str, *, beside: Kienzle | None = None, cuts: Sequence[tuple[float, float]] = (),
    drawn: Mapping[str, Parameter] | None = None,
) -> dict[str, Any]:  # fmt: skip
    """The result as the one JSON object that ``leadscrew identify cutting-force --json`` prints."""
    t, same = fit.table, kienzle(fit.law, fit.kappa_deg)
    depth = fit.depth
    return {
        **head("identify cutting-force"), "file": source,
        "columns": dict(t.columns), "cuts": len(t.force), "repeated_rows": [list(x) for x in t.repeated],
        "law": {"kf": fit.law.kf, "exponent": fit.law.exponent, "exponent_given": fit.exponent_given},
        "kienzle": {**same._asdict(), "kc11_low": _kc11(fit).low, "kc11_high": _kc11(fit).high},
        "fits": {f"power law, {fit.chosen.method}": _as_dict(fit.chosen), **dict(_others(fit))},
        "depth_exponent": None if depth is None else {**depth.exponent._asdict(), "p_value": depth.p_value},
        "bootstrap": None if drawn is None else {name: x._asdict() for name, x in drawn.items()},
        "given": None if beside is None else errors(fit, beside),
        "at": [{"feed": f, "depth": a, **x._asdict(), "inside": inside}
               for f, a in cuts for x, inside in [fit.force(f, a)]],
        "ratios": {name: {"median": m, "least": lo, "most": hi} for name, (m, lo, hi) in ratios(fit).items()},
        "rows": [dict(zip(("row", "feed", "depth", "force"), row, strict=True))
                 for row in zip(t.rows, t.feed.tolist(), t.depth.tolist(), t.force.tolist(), strict=True)],
        "set": settings(fit), "sentences": sentences(fit), "notes": list(fit.notes),
    }  # fmt: skip


def report_of(
    fit: ForceFit, file: Path, *, beside: Kienzle | None = None, cuts: Sequence[tuple[float, float]] = (),
    drawn: Mapping[str, Parameter] | None = None,
) -> Report:  # fmt: skip
    """The report of ``leadscrew identify cutting-force``."""
    return Report(
        summary(fit, str(file), beside=beside, cuts=cuts, drawn=drawn),
        parts=[
            law_table(fit, drawn), fit_table(fit, beside), cut_table(fit), *([at_table(fit, cuts)] if cuts else []),
            *sentences(fit), for_simulation(fit, "--set "),
        ],
        notes=fit.notes,
        page=lambda folder: write(fit, file.name, folder, beside=beside, cuts=cuts, drawn=drawn),
    )  # fmt: skip


def experiment(fit: ForceFit, source: str) -> str:
    """An experiment file: the study ``grey_turning`` with this material."""
    lines = [pair.replace("=", " = ") for pair in settings(fit)]
    return (
        f"# Force law fitted to {one_line(source)} by leadscrew identify cutting-force\n"
        "# 150 N are held at 1 mm and 1200 1/min by a PI controller; names of others: leadscrew list grey_turning\n"
        'schema_version = 1\nstudy = "grey_turning"\ncontroller = "pi_incremental"\nscenario = "fig6_fixed_depth"\n'
        "\n[set]\n" + "\n".join(lines) + "\n"
    )


def write(
    fit: ForceFit, source: str, folder: str | Path, *, beside: Kienzle | None = None,
    cuts: Sequence[tuple[float, float]] = (), drawn: Mapping[str, Parameter] | None = None,
) -> None:  # fmt: skip
    """Writes ``report.html``, ``cutting_force.json`` and ``.png``, and ``cut.toml`` where a plant takes the law.

    Complete, or not at all.

    Raises:
        DataError: the folder exists already and is not empty, or cannot be written.
    """
    with atomic_folder(folder) as place:
        figure = picture(fit, source, beside)
        figure.savefig(place / "cutting_force.png", dpi=130, metadata={"Software": None})
        found = strict(summary(fit, source, beside=beside, cuts=cuts, drawn=drawn))
        (place / "cutting_force.json").write_text(json.dumps(found, indent=1, allow_nan=False) + "\n", encoding="utf-8")
        if settings(fit):
            (place / "cut.toml").write_text(experiment(fit, source), encoding="utf-8")
        (place / "report.html").write_text(_page(fit, source, figure, beside, cuts, drawn), encoding="utf-8")


def _page(
    fit: ForceFit, source: str, figure: Figure, beside: Kienzle | None, cuts: Sequence[tuple[float, float]],
    drawn: Mapping[str, Parameter] | None,
) -> str:  # fmt: skip
    title = f"Cutting force: {source}"
    lines = [*sentences(fit), *(f"note: {n}" for n in fit.notes), for_simulation(fit)]
    parts = [
        *html.paragraphs(lines),
        html.picture(figure, "cutting_force", "force against feed, and residuals"),
        html.table(law_table(fit, drawn)),
        html.table(fit_table(fit, beside)),
        html.table(cut_table(fit)),
    ]
    if cuts:
        parts.append(html.table(at_table(fit, cuts)))
    return html.page(title, parts)


def _kc11(fit: ForceFit) -> Interval:
    """``ln kc11 = ln Kf + (1 - P) ln sin(kappa)``, with its interval."""
    value, sine = kienzle(fit.law, fit.kappa_deg).kc11, np.log(np.sin(np.radians(fit.kappa_deg)))
    row = np.array([1.0, -sine][: len(fit.chosen.covariance)])
    kf = fit.chosen.parameters["kf"]
    quantile = np.log(kf.high / kf.value) / max(float(np.sqrt(fit.chosen.covariance[0, 0])), 1e-300)
    reach = float(np.exp(quantile * np.sqrt(row @ fit.chosen.covariance @ row)))
    return Interval(value, value / reach, value * reach)


def _row(name: str, value: Interval | Parameter, unit: str, law: str) -> list[str]:
    return [name, *(finite(x) for x in (value.value, value.low, value.high)), shown_unit(unit), law]


def _fit_row(name: str, fit: LawFit) -> list[str]:
    return [name, finite(fit.rms_percent, 3), finite(fit.worst_percent, 3), finite(fit.left_out_rms_percent, 3),
            finite(fit.rms_n, 3), *_r2(fit.r2),
            finite(fit.condition, 2)]  # fmt: skip


def _r2(found: Mapping[str, float]) -> list[str]:
    values = [found[name] for name in ("force", "log force", "log specific force")]
    return [fixed(x, 3) for x in values]


def _others(fit: ForceFit) -> Iterator[tuple[str, dict[str, Any]]]:
    return ((name, _as_dict(other)) for name, other in fit.others.items())


def _as_dict(fit: LawFit) -> dict[str, Any]:
    return {
        "parameters": {name: x._asdict() for name, x in fit.parameters.items()},
        "specific_force_in_the_middle": fit.middle._asdict(), "rms_percent": fit.rms_percent,
        "worst_percent": fit.worst_percent, "left_out_rms_percent": fit.left_out_rms_percent, "rms_n": fit.rms_n,
        "r2": dict(fit.r2), "condition": fit.condition, "freedom": fit.freedom,
        "residual_percent": fit.residual_percent, "left_out_percent": fit.left_out_percent,
    }  # fmt: skip


def _middle(values: np.ndarray) -> float:
    return float(np.exp(np.log(values).mean()))
