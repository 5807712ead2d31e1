"""An identified axis for reading: numbers, sentences, tables, JSON, pictures, and the report folder."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.figures.style import BLACK, BLUE, GREEN, ORANGE, VERMILION
from leadscrew.figures.table import NOTHING, finite, fixed
from leadscrew.figures.table import unit as shown_unit
from leadscrew.friction.static_map import Sliding, TwoSided
from leadscrew.identify.axis.cascade import OBEYS
from leadscrew.logs.measure import beyond_step
from leadscrew.report import page as html
from leadscrew.report.report import File, Report, TextTable, head
from leadscrew.util.atomic import atomic_folder
from leadscrew.util.strict_json import strict

if TYPE_CHECKING:
    from leadscrew.figures.figure import Figure
    from leadscrew.identify.axis.result import AxisFit, Judged, Parameter
    from leadscrew.logs.finding import Finding


PREFIXES = ((1.0, ""), (1e-3, "m"), (1e-6, "u"), (1e-9, "n"))
MODELS = {
    "coulomb": "Coulomb and viscous friction",
    "stribeck": "Coulomb, viscous and static friction (Stribeck)",
    "lugre": "LuGre friction (with pre-sliding)",
}
NAMES = {
    "mass": "moving mass", "offset": "offset", "backlash": "lost motion", "force_per_drive": "force of a unit of drive",
    "delay_s": "delay of the drive", "coulomb": "Coulomb friction", "viscous": "viscous friction",
    "static": "static friction", "stribeck_speed": "Stribeck speed", "stiffness": "pre-sliding stiffness",
    "damping": "pre-sliding damping",
}  # fmt: skip
ENDS_WELL = 2.0
"""Times the error on the training part that the error on the hold-out may be, before a sentence says so."""
FORCE_ENDS_WELL = 1.5
"""The same for the force that inverse dynamics leaves: position adds up what is small, force does not."""
TOO_GOOD = ": the model knows its own data too well, or the axis has changed, so go by the error on validation data"
NEGLIGIBLE = 0.1
"""Percent of the range of the position below which the error on the hold-out is good whatever the ratio."""
TRADES = 100.0
"""Condition number from which parameters trade with one another."""


def digits_of(parameter: Parameter) -> int:
    """Significant digits that show a parameter's interval: four, and up to seven where it is narrow."""
    half = 0.5 * (parameter.high - parameter.low)
    if not (math.isfinite(half) and half > 0.0 and parameter.value):
        return 4
    return min(max(4, math.floor(math.log10(abs(parameter.value) / half)) + 2), 7)


def shown(value: float, digits: int) -> str:
    """A value of a parameter; of more than four digits, zeros at the end count."""
    if digits <= 4 or not math.isfinite(value) or not value:
        return finite(value)
    return fixed(value, max(0, digits - 1 - math.floor(math.log10(abs(value)))))


def scaled(value: float, unit: str, digits: int = 4) -> str:
    """A value in SI with the prefix that suits it: 3.1e-6 m is ``3.1 um``; a dash for none."""
    if not math.isfinite(value):
        return NOTHING
    factor, prefix = next(((f, p) for f, p in PREFIXES if abs(value) >= f), PREFIXES[-1] if value else PREFIXES[0])
    return f"{finite(value / factor, digits)} {shown_unit(prefix + unit)}"


def display(largest: float, unit: str) -> tuple[float, str]:
    """Factor and unit for the axis of a picture whose largest value is this."""
    factor, prefix = next(((f, p) for f, p in PREFIXES if abs(largest) >= f), PREFIXES[0])
    return 1.0 / factor, shown_unit(prefix + unit)


def merged(fit: AxisFit) -> dict[str, Parameter]:
    """The parameters without those of backward motion that repeat the forward ones."""
    rows = dict(fit.parameters)
    for key, other in fit.parameters.items():
        twin = key.replace(".backward.", ".forward.")
        if fit.symmetric and twin != key and twin in rows and rows[twin].value == other.value:
            del rows[key]
    return rows


def name_of(fit: AxisFit, key: str) -> str:
    """What a key stands for: ``Coulomb friction, backward``."""
    *_, last = key.split(".")
    name = "moving inertia" if key == "mass" and fit.position_unit == "rad" else NAMES.get(last, last)
    if key.startswith("friction.forward."):
        return f"{name}, {'both ways' if key not in separate(fit) else 'forward'}"
    return f"{name}, backward" if key.startswith("friction.backward.") else name


def separate(fit: AxisFit) -> set[str]:
    """Keys of friction that are told apart by direction."""
    rows = merged(fit)
    return {k for k in rows if k.replace(".forward.", ".backward.") in rows and ".forward." in k}


def force_unit(fit: AxisFit) -> str:
    """The unit of forces in this fit: N or N m, or the drive's own where its force is not known."""
    found = next((p.unit for k, p in fit.parameters.items() if k.endswith(".coulomb") or k == "offset"), "")
    return found or fit.drive_unit


def state_of(parameter: Parameter) -> str:
    """``fitted``, ``not identifiable``, ``fixed`` or ``given``."""
    return "not identifiable" if parameter.how == "fitted" and not parameter.identifiable else parameter.how


def why(parameter: Parameter) -> str:
    """The note of a parameter, and that it has no interval where a fitted one has none."""
    bare = parameter.how == "fitted" and not (math.isfinite(parameter.low) and math.isfinite(parameter.high))
    return "; ".join(x for x in (parameter.note, "no interval is known" if bare else "") if x)


def length(fit: AxisFit, value: float) -> str:
    """A position or an error of it."""
    return scaled(value, fit.position_unit)


def open_loop(fit: AxisFit) -> tuple[Judged | None, Judged | None]:
    """The stretches ``training`` and ``hold-out``."""
    return fit.judgement("training"), fit.judgement("hold-out")


def sentences(fit: AxisFit) -> list[str]:
    """The result in words, a line each: what was fitted, its error on validation data, what is not identifiable."""
    alike = "alike both ways" if fit.symmetric else "by direction"
    lines = [*fit.faults, f"{MODELS[fit.model]}, {alike}", fit.method.rstrip("."), *_judged(fit)]
    if fit.condition > TRADES:
        lines.append(
            f"condition number {finite(fit.condition, 3)}: parameters trade with one another, so their intervals are "
            "wide"
        )
    if fit.missing:
        rows = merged(fit)
        keys = [k for k in fit.missing if k in rows or k not in fit.parameters]
        lines.append(f"not identifiable from this log: {', '.join(keys)}")
    lines.append(
        f"known from {length(fit, fit.travel[0])} to {length(fit, fit.travel[1])}, up to "
        f"{scaled(fit.top_speed, f'{fit.position_unit}/s')} and {finite(fit.top_acceleration)} "
        f"{fit.position_unit}/s^2; what the model says beyond that is a guess"
    )
    return lines


def _judged(fit: AxisFit) -> list[str]:
    seen, unseen = open_loop(fit)
    if unseen is None:
        lines = ["no hold-out: every error here is on data that the fit has seen, and says nothing about other data"]
    else:
        lines = [
            f"on data that the fit has not seen ({unseen.start_s:g} to {unseen.end_s:g} s) the simulated position is "
            f"off by {length(fit, unseen.rms)} rms, {finite(unseen.nrmse_percent, 3)} % of its range"
        ]
        if seen is not None and seen.rms > 0.0:
            lines.append(_beside(seen, unseen))
    closed = closed_loop(fit)
    if closed is not None:
        lines.append(
            f"under the known controller ({closed.start_s:g} to {closed.end_s:g} s) the simulated position is off by "
            f"{length(fit, closed.rms)} rms; a controller hides faults of a model, so judge the model by the line above"
        )
        left = fit.cascade_left_percent
        if left is not None and left > OBEYS:
            lines.append(
                f"the known controller leaves {finite(left, 3)} % of the logged drive (allowed are {OBEYS:g} %): it "
                "did not make this log, so its score says nothing; check kp, kv, ki, over and the unit of the command"
            )
    return lines


def _beside(seen: Judged, unseen: Judged) -> str:
    """The error on unseen data beside that on the data of the fit; the force left tells what a larger one means."""
    ratio = unseen.rms / seen.rms
    line = f"that is {f'{finite(ratio, 3)} times' if ratio >= 1.0 else 'no more than'} the error on the data of the fit"
    if ratio <= ENDS_WELL or unseen.nrmse_percent <= NEGLIGIBLE:
        return line
    forces = f"{finite(unseen.force_percent, 3)} % of the force is left there, {finite(seen.force_percent, 3)} % here"
    if unseen.force_percent > FORCE_ENDS_WELL * seen.force_percent:
        return f"{line}; {forces}{TOO_GOOD}"
    return f"{line}; {forces}, so small forces add up in the position"


def closed_loop(fit: AxisFit) -> Judged | None:
    """The stretch under the known controller: of the hold-out, or the last one that there is."""
    found = [j for j in fit.judged if j.what.endswith("closed loop")]
    return next((j for j in found if j.what.startswith("hold-out")), found[-1] if found else None)


def notes(fit: AxisFit, findings: Iterable[str] = ()) -> list[str]:
    """What is odd about the log and the fit, each sentence once."""
    return [note for note in dict.fromkeys([*findings, *fit.notes]) if note not in fit.faults]


def parameter_table(fit: AxisFit, reasons: bool = True) -> TextTable:
    """One row for each parameter: key, value, interval, unit, how it was found, what it is.

    With ``reasons`` also why it is not fitted, where it is not.
    """
    rows = []
    for key, p in merged(fit).items():
        note = why(p) if reasons else ""
        digits = digits_of(p)
        rows.append([key, *(shown(x, digits) for x in (p.value, p.low, p.high)), shown_unit(p.unit),
                     state_of(p), name_of(fit, key) + (f": {note}" if note else "")])  # fmt: skip
    heads = ("parameter", "value", "95 % from", "to", "unit", "how", "what")
    return TextTable(heads, rows, [False, *[True] * 3, False, False, False], title="Parameters")


def reason_lines(fit: AxisFit) -> list[str]:
    """What holds for single parameters, a line for each reason with the keys that it is about."""
    found: dict[str, list[str]] = {}
    for key, p in merged(fit).items():
        if why(p):
            found.setdefault(why(p), []).append(key)
    return [f"{', '.join(keys)}: {reason}" for reason, keys in found.items()]


def score_table(fit: AxisFit) -> TextTable:
    """Errors by stretch of the log: of the simulated position, and of the drive's force by inverse dynamics."""
    force = force_unit(fit)
    rows = [
        [j.what, finite(j.start_s), finite(j.end_s), length(fit, j.rms), length(fit, j.worst),
         finite(j.nrmse_percent, 3), f"{finite(j.rms_force, 3)} {force}", finite(j.force_percent, 3),
         finite(j.whiteness, 3)]
        for j in fit.judged
    ]  # fmt: skip
    heads = ("part", "from (s)", "to (s)", "rms", "worst", "% of range", "force rms", "% of force", "white (%)")
    return TextTable(heads, rows, [False, *[True] * 8], title="Errors by part of the log")


def compared_table(fit: AxisFit) -> TextTable:
    """Models that were tried: headers and rows, in the words of the fitter."""
    keys = list(dict.fromkeys(key for row in fit.compared for key in row))
    rows = [[_cell(fit, key, row.get(key)) for key in keys] for row in fit.compared]
    return TextTable([_header(key) for key in keys], rows, title="Models compared")


def correlation_table(fit: AxisFit) -> TextTable:
    """Correlations of the estimates, below the diagonal."""
    keys = [k for k in fit.parameters if k in fit.correlation]
    rows = [[row, *(finite(fit.correlation[row].get(column), 2) if j < i else "" for j, column in enumerate(keys[:-1]))]
            for i, row in enumerate(keys) if i]  # fmt: skip
    return TextTable(["", *keys[:-1]], rows, [False, *[True] * len(keys[:-1])], title="Correlation of the estimates")


def record_table(fit: AxisFit) -> TextTable:
    """What the log is like: what a reader needs to judge the fit."""
    unit = fit.position_unit
    rows = [
        ["period", scaled(fit.period, "s")],
        ["step of the encoder", length(fit, fit.encoder_step) if fit.encoder_step > 0.0 else "not seen"],
        ["noise of the position, rms", length(fit, fit.noise) + _rounding(fit)],
        ["travel", f"{length(fit, fit.travel[0])} to {length(fit, fit.travel[1])}"],
        ["largest speed", scaled(fit.top_speed, f"{unit}/s")],
        ["largest acceleration", f"{finite(fit.top_acceleration)} {unit}/s^2"],
        ["largest drive", f"{finite(fit.top_drive, 4)} {fit.drive_unit}"],
        ["condition number of the fit", finite(fit.condition, 3)],
    ]
    return TextTable.words(("of the log", "value"), rows, title="The log")


def _rounding(fit: AxisFit) -> str:
    """Where the noise comes from, if only from the encoder."""
    beyond = beyond_step(fit.noise, fit.encoder_step) or not fit.encoder_step
    return "" if beyond else ", none beyond the rounding to the encoder's steps"


def summary(fit: AxisFit) -> dict[str, Any]:
    """The result as the one JSON object that ``leadscrew identify axis --json`` prints."""
    seen, unseen = open_loop(fit)
    ratio = unseen.rms / seen.rms if seen is not None and unseen is not None and seen.rms > 0.0 else None
    return {
        **head("identify axis"), **fit.as_dict(),
        "holdout_over_training": ratio, "sentences": sentences(fit),
    }  # fmt: skip


def _header(key: str) -> str:
    return key.replace("holdout", "hold-out").replace("_percent", " %").replace("_", " ")


def _cell(fit: AxisFit, key: str, value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return length(fit, value) if "rms" in key and "force" not in key else finite(value, 3)
    return "" if value is None else str(value)


QUANTILE = 1.959964
STEP = 1e-4
"""Of a parameter, for the slope of the map in it."""


def friction_map(values: Mapping[str, float]) -> TwoSided:
    """Steady sliding by direction from values by key; without a static friction there is no Stribeck curve."""

    def side(way: str) -> Sliding:
        def of(name: str, otherwise: float) -> float:
            forward = values.get(f"friction.forward.{name}", otherwise)
            return float(values.get(f"friction.{way}.{name}", forward))

        coulomb = of("coulomb", 0.0)
        return Sliding(coulomb, of("static", coulomb), of("stribeck_speed", 1e-3), of("viscous", 0.0))

    return TwoSided(side("forward"), side("backward"))


def resistance(values: Mapping[str, float], speeds: np.ndarray) -> np.ndarray:
    """Friction and offset at each speed: what inertia leaves of the drive's force; the offset alone at rest."""
    from leadscrew.analysis.friction import friction_velocity

    return np.asarray(friction_velocity(friction_map(values), speeds)) + values.get("offset", 0.0)


def shown_by_log(fit: AxisFit, stretch: Judged) -> np.ndarray:
    """Drive's force minus inertia at each sample of a stretch: the map there, and what inverse dynamics leaves."""
    return resistance(fit.values, stretch.speed) + stretch.force_left


def band(fit: AxisFit, speeds: np.ndarray) -> np.ndarray | None:
    """Half of the 95 % interval of the map at each speed, from the parameters' intervals and their correlation.

        s^2 = g' C g        g: slope of the map in the fitted parameters        C: their covariance

    It says how well the map is known where its form is right, not how far samples scatter around it.

    Returns:
        None where a fitted parameter of the map has no interval or no correlation with the others.
    """
    keys = [k for k, p in fit.parameters.items() if p.how == "fitted" and (k == "offset" or _of_map(k))]
    if fit.symmetric:
        keys = [k for k in keys if ".backward." not in k]
    error = np.array([(fit.parameters[k].high - fit.parameters[k].low) / (2.0 * QUANTILE) for k in keys])
    if not keys or not np.all(np.isfinite(error)):
        return None
    try:
        covariance = np.array([[_correlation(fit, a, b) for b in keys] for a in keys]) * np.outer(error, error)
    except KeyError:
        return None
    slopes = np.array([_slope(fit, key, speeds) for key in keys])
    variance = np.einsum("ks,kl,ls->s", slopes, covariance, slopes)
    return np.asarray(QUANTILE * np.sqrt(np.maximum(variance, 0.0)))


def medians(speeds: np.ndarray, forces: np.ndarray, bins: int = 40, least: int = 10) -> tuple[np.ndarray, ...]:
    """Median force in equal bins of speed, with the quartiles; bins of fewer than ``least`` samples are left out.

    Returns:
        Middles of the bins, lower quartile, median, upper quartile.
    """
    edges = np.linspace(speeds.min(), speeds.max(), bins + 1)
    at = np.clip(np.digitize(speeds, edges) - 1, 0, bins - 1)
    kept = [b for b in range(bins) if np.count_nonzero(at == b) >= least]
    quartiles = np.array([np.percentile(forces[at == b], (25.0, 50.0, 75.0)) for b in kept]).reshape(-1, 3)
    return np.array([np.median(speeds[at == b]) for b in kept]), *quartiles.T


def _of_map(key: str) -> bool:
    return key.startswith("friction.") and key.rsplit(".", 1)[1] in ("coulomb", "viscous", "static", "stribeck_speed")


def _correlation(fit: AxisFit, a: str, b: str) -> float:
    return 1.0 if a == b else fit.correlation[a][b]


def _slope(fit: AxisFit, key: str, speeds: np.ndarray) -> np.ndarray:
    value = fit.values[key]
    step = STEP * max(abs(value), 1e-12)
    ends = []
    for change in (-step, step):
        values = fit.values | {key: value + change}
        if fit.symmetric and ".forward." in key:
            values[key.replace(".forward.", ".backward.")] = value + change
        ends.append(resistance(values, speeds))
    return np.asarray((ends[1] - ends[0]) / (2.0 * step))


MOST_POINTS = 5000
"""Samples of a stretch that a picture shows; of more, every n-th."""
LAGS = 400
POSITION = "Measured and simulated position, and what is between them"
RESIDUAL = (
    "What inverse dynamics leaves of the force, and its autocorrelation; within the window of its filter neighbours "
    "are alike by that alone"
)
FRICTION = "Drive's force minus inertia against speed, and the friction of the model"
INTERVALS = "Half of the 95 % interval of each parameter, in percent of its value"


def pictures(fit: AxisFit) -> dict[str, tuple[str, Figure]]:
    """Caption and figure by name, as far as the fit has what they show."""
    found = {
        "position": (POSITION, position_figure(fit)), "residual": (RESIDUAL, residual_figure(fit)),
        "friction": (FRICTION, friction_figure(fit)), "parameters": (INTERVALS, interval_figure(fit)),
    }  # fmt: skip
    return {name: (caption, figure) for name, (caption, figure) in found.items() if figure is not None}


def unseen(fit: AxisFit) -> Judged | None:
    """The stretch to show: the hold-out, or what there is."""
    return fit.judgement("hold-out") or (fit.judged[0] if fit.judged else None)


def position_figure(fit: AxisFit) -> Figure | None:
    """Measured and simulated position with the error below: the hold-out, and the closed loop where there is one."""
    from leadscrew.figures.figure import Figure

    first = unseen(fit)
    if first is None:
        return None
    shown = [j for j in (first, closed_loop(fit)) if j is not None]
    figure = Figure(figsize=(5.4 * len(shown) + 1.6, 4.6), layout="constrained")
    axes = figure.subplots(2, len(shown), squeeze=False, sharex="col", height_ratios=(3, 2))
    for (above, below), j in zip(axes.T, shown, strict=True):
        every = slice(None, None, max(1, len(j.time) // MOST_POINTS))
        factor, unit = display(float(np.abs(j.measured).max()), fit.position_unit)
        above.plot(j.time[every], factor * j.measured[every], color=BLACK, linewidth=2.0, label="measured")
        above.plot(j.time[every], factor * j.simulated[every], color=ORANGE, linestyle="--", label="simulated")
        above.set(title=f"{j.what}: {scaled(j.rms, fit.position_unit)} rms", ylabel=f"position ({unit})")
        left = j.measured - j.simulated
        factor, unit = display(float(np.abs(left).max()), fit.position_unit)
        below.plot(j.time[every], factor * left[every], color=BLUE, linewidth=0.8)
        below.set(xlabel="time (s)", ylabel=f"error ({unit})")
        below.axhline(0.0, color=BLACK, linewidth=0.6)
    _tidy(*axes.ravel())
    figure.align_ylabels(axes[:, 0])
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=2, frameon=False)
    return figure


def residual_figure(fit: AxisFit) -> Figure | None:
    """Residual force against time, and its autocorrelation with the bounds of white noise."""
    from leadscrew.figures.figure import Figure

    j = unseen(fit)
    if j is None or np.count_nonzero(np.isfinite(j.force_left)) < 8:
        return None
    figure = Figure(figsize=(11.0, 3.4), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(3, 2))
    every = slice(None, None, max(1, len(j.time) // MOST_POINTS))
    left.plot(j.time[every], j.force_left[every], color=BLUE, linewidth=0.6)
    left.axhline(0.0, color=BLACK, linewidth=0.6)
    unit = force_unit(fit)
    left.set(xlabel="time (s)", ylabel=f"residual force ({unit})")
    left.set_title(f"{j.what}: {finite(j.rms_force, 3)} {unit} rms, {finite(j.force_percent, 3)} % of the force")
    lags = autocorrelation(j.force_left)
    bound = 1.96 / np.sqrt(np.count_nonzero(np.isfinite(j.force_left)))
    times = np.arange(len(lags)) * (j.time[-1] - j.time[0]) / (len(j.time) - 1)
    right.axhspan(-bound, bound, color="0.85", label="95 % of white noise")
    right.plot(times, lags, color=VERMILION, linewidth=1.2, label="of the residual")
    right.axhline(0.0, color=BLACK, linewidth=0.6)
    right.set(xlabel="lag (s)", ylabel="autocorrelation", ylim=(min(-0.25, float(lags.min())), 1.03))
    right.legend(frameon=False, fontsize="small")
    _tidy(left, right)
    return figure


def autocorrelation(values: np.ndarray, lags: int = LAGS) -> np.ndarray:
    """Autocorrelation from lag 0 on, 1 there, up to a quarter of the samples; NaN marks samples that are left out."""
    from scipy.signal import correlate

    known = np.isfinite(values)
    x = np.where(known, values - np.mean(values[known]), 0.0)
    kept = slice(len(x) - 1, len(x) + max(2, min(lags, len(x) // 4)))
    sums, pairs = (correlate(v, v, mode="full", method="fft")[kept] for v in (x, known.astype(float)))
    found = sums / np.maximum(np.rint(pairs), 1.0)
    return np.asarray(found / found[0] if found[0] > 0.0 else np.zeros_like(found))


def friction_figure(fit: AxisFit) -> Figure | None:
    """Force minus inertia against speed: samples, their medians, and the model with its band."""
    from leadscrew.figures.figure import Figure

    j = unseen(fit)
    if j is None or np.count_nonzero(np.isfinite(j.force_left)) < 8:
        return None
    figure = Figure(figsize=(7.6, 4.4), layout="constrained")
    ax: Any = figure.subplots()
    factor, unit = display(float(np.abs(j.speed).max()), f"{fit.position_unit}/s")
    kept = np.isfinite(j.force_left)
    every = slice(None, None, max(1, int(kept.sum()) // MOST_POINTS))
    speed, forces = j.speed[kept], shown_by_log(fit, j)[kept]
    ax.plot(factor * speed[every], forces[every], ".", color="0.6", markersize=1.5, rasterized=True)
    ax.plot([], [], "s", color="0.6", markersize=4, label=f"samples, {j.what}")
    middle, low, median, high = medians(speed, forces)
    ax.errorbar(factor * middle, median, [median - low, high - median], fmt="o", markersize=4, color=BLACK,
                linewidth=0.8, label="their median and quartiles")  # fmt: skip
    for side in (-1.0, 1.0):
        end = float((side * speed).max())
        if end <= 0.0:
            continue
        speeds = side * np.linspace(end / 1000.0, end, 300)
        shown = resistance(fit.values, speeds)
        first = side < 0.0 or float(speed.min()) >= 0.0
        ax.plot(factor * speeds, shown, color=BLUE, linewidth=1.8, label="model" if first else None)
        reach = band(fit, speeds)
        if reach is not None:
            ax.fill_between(factor * speeds, shown - reach, shown + reach, color=ORANGE, alpha=0.5, linewidth=0.0,
                            label="95 % interval of the model" if first else None)  # fmt: skip
    spread = np.percentile(forces, (0.5, 99.5))
    ax.set(xlabel=f"speed ({unit})", ylabel=f"force minus inertia ({force_unit(fit)})",
           ylim=(spread[0] - 0.15 * np.ptp(spread), spread[1] + 0.15 * np.ptp(spread)))  # fmt: skip
    _tidy(ax)
    ax.margins(x=0.02)
    figure.legend(loc="outside lower center", ncols=4, frameon=False, fontsize="small")
    return figure


def interval_figure(fit: AxisFit) -> Figure | None:
    """Half of each 95 % interval in percent of the value; filled where the log determines the parameter."""
    from matplotlib.ticker import StrMethodFormatter

    from leadscrew.figures.figure import Figure

    rows = merged(fit)
    figure = Figure(figsize=(7.6, 1.2 + 0.34 * len(rows)), layout="constrained")
    ax: Any = figure.subplots()
    drawn = {k: p.percent for k, p in rows.items() if p.how == "fitted" and 0.0 < p.percent < np.inf}
    low, high = (min(drawn.values()), max(drawn.values())) if drawn else (0.1, 100.0)
    low, high = low / 2.0, max(high * 2.0, low * 100.0)
    for at, (key, p) in enumerate(rows.items()):
        if key in drawn:
            ax.plot([low, drawn[key]], [at, at], color="0.75", linewidth=1.0)
            mark, colour, fill = ("o", BLUE, "full") if p.identifiable else ("D", VERMILION, "none")
            ax.plot(drawn[key], at, mark, color=colour, markersize=7, fillstyle=fill)
        else:
            ax.text(low * 1.1, at, f"{state_of(p)}: no interval", va="center", fontsize="small", color="0.35")
    ax.set(xscale="log", xlim=(low, high), ylim=(len(rows) - 0.4, -0.6),
           xlabel="half of the 95 % interval, % of the value")  # fmt: skip
    ax.set_yticks(range(len(rows)), list(rows))
    ax.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    ax.axvline(100.0, color=GREEN, linewidth=1.0, linestyle=":")
    ax.plot([], [], "o", color=BLUE, label="identifiable from the log")
    ax.plot([], [], "D", color=VERMILION, fillstyle="none", label="not identifiable")
    figure.legend(loc="outside lower center", ncols=2, frameon=False, fontsize="small")
    ax.grid(axis="x", color="0.92", linewidth=0.6)
    ax.set_axisbelow(True)
    return figure


def _tidy(*axes: Any) -> None:
    for ax in axes:
        ax.grid(color="0.92", linewidth=0.6)
        ax.set_axisbelow(True)
        ax.margins(x=0)


def report_of(fit: AxisFit, findings: Sequence[Finding], files: Sequence[File]) -> Report:
    """The report of ``leadscrew identify axis``; ``findings`` are those of the check of the log."""
    return Report(
        {**summary(fit), "findings": [f._asdict() for f in findings]},
        parts=[
            parameter_table(fit, False), score_table(fit), *([compared_table(fit)] if fit.compared else []),
            *sentences(fit), *reason_lines(fit), *(f"to measure next: {a}" for a in fit.advice),
        ],
        notes=notes(fit, (f.sentence for f in findings)),
        files=files,
    )  # fmt: skip


MACHINE = "axis.toml"


def write(
    fit: AxisFit, folder: str | Path, machine: Callable[[Path], object] | None = None, findings: Sequence[str] = ()
) -> None:
    """Writes ``report.html``, ``axis.json``, the pictures as PNG, and the machine file ``axis.toml`` by ``machine``.

    Complete, or not at all.

    Args:
        fit: the result.
        folder: new, or empty.
        machine: writes the machine file to the path that it is given; none is written without.
        findings: the findings of the check of the log, for the page.

    Raises:
        DataError: the folder exists already and is not empty, or cannot be written.
    """
    with atomic_folder(folder) as place:
        if machine is not None:
            machine(place / MACHINE)
        drawn = pictures(fit)
        for name, (_, figure) in drawn.items():
            figure.savefig(place / f"{name}.png", dpi=120, metadata={"Software": None})
        found = strict({**summary(fit), "findings": list(findings)})
        (place / "axis.json").write_text(json.dumps(found, indent=1, allow_nan=False) + "\n", encoding="utf-8")
        page = page_of(fit, drawn, findings, machine is not None)
        (place / "report.html").write_text(page, encoding="utf-8", newline="\n")


def page_of(
    fit: AxisFit, drawn: dict[str, tuple[str, Figure]], findings: Sequence[str] = (), with_machine: bool = False
) -> str:
    """The page as one HTML file, pictures inside."""
    title = f"Identified axis: {Path(fit.source).name}"
    parts = [
        *html.paragraphs(sentences(fit)),
        html.bullets("Notes", notes(fit, findings)),
        html.bullets("What to measure next", fit.advice),
        html.table(parameter_table(fit)),
        '<p class="quiet">Intervals are of 95 %. A parameter that is fixed or given has none.</p>',
        html.table(score_table(fit)),
        '<p class="quiet">Position: simulated from the drive alone, from the measured state at the start of the part. '
        "Force: what inverse dynamics leaves. White: share of its autocorrelations within the bounds of white noise, "
        "95 % for noise alone.</p>",
        *(html.picture(figure, name, caption, caption) for name, (caption, figure) in drawn.items()),
    ]
    if fit.compared:
        parts.append(html.table(compared_table(fit)))
    if len(fit.correlation) > 1:
        parts.append(html.table(correlation_table(fit)))
    parts.append(html.table(record_table(fit)))
    if with_machine:
        parts.append(f"<p><code>{MACHINE}</code>, beside this page, is the axis as a machine file: a name wherever a "
                     "study is named.</p>")  # fmt: skip
    return html.page(title, parts)
