"""Claims about the original servo: what Table 1 says of the plant's gain, and of the law that printed no equation.

Rows of the digest's section 6 beyond the common gain, and of section 9 up to the laws (its Monte Carlo is in
``claims_accuracy``).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from leadscrew.identify.gain import GainFit, Record, fit_gain, unit_travel
from leadscrew.identify.output_error import OutputErrorFit
from leadscrew.kernel.one_thread import one_thread
from leadscrew.report.claim import Basis, Claim, Kind, Sense
from leadscrew.studies.vud_lathe.claims_data import LAGS_S, RATE_SCALE_MM, gain_fits
from leadscrew.studies.vud_lathe.original import (
    EXPONENT,
    GAIN,
    KD,
    KI,
    KP,
    SPEED,
    OriginalResults,
    Played,
    duty_misfit,
    original_results,
    static_fit,
)
from leadscrew.studies.vud_lathe.runs import STEPS, Loops
from leadscrew.studies.vud_lathe.tables import FULL_SCALE_MM, SAMPLE_TIME_S, Move

HOLD_WORDS = {"linear": "linear between samples", "previous": "held", "current": "already the next one"}
ALONE = {
    "linear": (285.8, 333.3, 341.2, 286.1),
    "previous": (290.8, 337.6, 345.4, 291.2),
    "current": (280.2, 328.2, 336.0, 280.5),
}
"""Speeds that the moves ask for one by one, in the order of Table 1."""
MISFIT = {"previous": (3.5, 14.0, 15.6, 3.3), "current": (3.1, 12.0, 13.8, 3.3)}
STATIC_MISFIT = (1.6, 2.8, 2.7, 1.9)
TRAVEL = (287, 327, 335, 287)
MEAN_SPEED_MM_S = RATE_SCALE_MM / SAMPLE_TIME_S
"""Change of the error per 0.1 s that makes ec = 1, as a speed."""
LATE_S = 0.002
"""A further lag of two control periods, with which the digest's misfits under the static gain come out."""


def original_claims(loops: Loops, moves: Mapping[str, Move], found: OriginalResults | None = None) -> list[Claim]:
    """All of them; ``found`` is what :func:`original_results` gave, so that pictures can share it."""
    with one_thread():
        gains = gain_fits(moves)
        static = _static_gain(moves, gains)
        fits, played = found or original_results(loops, moves)
    return [
        *_alone(moves, gains), *static, *_regression(moves), *_first_sample(moves, gains["linear"].gain),
        *_fitted(fits), *_judged_by_duty(played, moves), *_static_law(moves),
        *_linear_residual(played["p_209"], played["pid_209"]), *_power_law(played["power_289"]), *_order(loops),
    ]  # fmt: skip


def _claim(
    name: str,
    source: str,
    statement: str,
    measured: float,
    unit: str,
    target: float | None,
    tolerance: float,
    reason: str,
    kind: Kind = "required",
    sense: Sense = "=",
    basis: Basis = "paper's data",
    paper: float | None = None,
) -> Claim:
    return Claim(
        f"vud_lathe.{name}", source, "ours", basis, statement, paper, float(measured), unit, sense, target, tolerance,
        kind, "cannot be checked", reason,
    )  # fmt: skip


def _key(move: str) -> str:
    return move.replace("r=-", "m").replace("r=", "p")


def _alone(moves: Mapping[str, Move], gains: Mapping[str, GainFit]) -> list[Claim]:
    rows = []
    for hold, fit in gains.items():
        for name, target in zip(moves, ALONE[hold], strict=True):
            more = 100.0 * (fit.gain_alone[name] / fit.gain - 1.0)
            rows.append(
                _claim(f"gain_alone_{hold}_{_key(name)}", "Table 1",
                       f"speed at full duty that {name} asks for by itself, duty {HOLD_WORDS[hold]}",
                       -fit.gain_alone[name], "mm/s", target, 0.5, f"{more:+.1f} % of the common speed")
            )  # fmt: skip
            if hold in MISFIT:
                expected = MISFIT[hold][list(moves).index(name)]
                rows.append(
                    _claim(f"gain_fit_{hold}_{_key(name)}", "Table 1",
                           f"misfit of {name} with the common speed, duty {HOLD_WORDS[hold]}", fit.nrmse_percent[name],
                           "%", expected, 0.1, f"{gains['linear'].nrmse_percent[name]:.1f} % with a straight line "
                           "between the samples")
                )  # fmt: skip
    for name, target in zip(moves, TRAVEL, strict=True):
        move = moves[name]
        way = FULL_SCALE_MM * abs(move.error[0] - move.error[-1])
        rows.append(
            _claim(f"travel_over_duty_{_key(name)}", "Table 1", f"way of {name} over the sum of its duty times 0.1 s",
                   way / (SAMPLE_TIME_S * float(np.sum(np.abs(move.duty)))), "mm/s", target, 0.5,
                   "no model at all, and the same split between long and short moves")
        )  # fmt: skip
    main = gains["linear"]
    more = 100.0 * (float(np.mean([main.gain_alone[n] for n in ("r=-50", "r=50")])) / main.gain - 1.0)
    rows.append(
        _claim("gain_short_moves", "Table 1", "what the short moves ask for above the common speed, mean of both", more,
               "%", 16.0, 1.0, "the gain falls with amplitude: no linear plant gives both columns", "report")
    )  # fmt: skip
    return rows


def _bent(move: Move, exponent: float) -> Record:
    """The record with a static gain in front, and with the way as its unit, so that every move counts the same."""
    time, duty, position = move.record()
    way = float(np.ptp(position))
    return Record(time, np.sign(duty) * np.abs(duty) ** exponent / way, position / way)


def static_gain_fit(moves: Mapping[str, Move], exponent: float, late_s: float = 0.0) -> GainFit:
    """Common speed and misfits where ``|duty|^exponent`` drives the chain, duty already the next one."""
    lags = (*LAGS_S, late_s) if late_s > 0.0 else LAGS_S
    return fit_gain({name: _bent(move, exponent) for name, move in moves.items()}, lags, "current")


def best_exponent(moves: Mapping[str, Move]) -> float:
    """The exponent with the smallest misfit over all moves."""
    from scipy.optimize import minimize_scalar

    def misfit(exponent: float) -> float:
        return sum(m**2 for m in static_gain_fit(moves, exponent).nrmse_percent.values())

    return float(minimize_scalar(misfit, bounds=(0.5, 1.2), method="bounded", options={"xatol": 1e-4}).x)


def _static_gain(moves: Mapping[str, Move], gains: Mapping[str, GainFit]) -> list[Claim]:
    best = best_exponent(moves)
    fit, late = static_gain_fit(moves, 0.856), static_gain_fit(moves, 0.856, LATE_S)
    worst = max(fit.nrmse_percent.values())
    rows = [
        _claim("static_gain_exponent", "Table 1", "exponent of the duty with which one speed fits all moves best", best,
               "1", 0.856, 0.001, f"below 1: the gain falls with amplitude; every move then within {worst:.1f} %"),
        _claim("static_gain_speed", "Table 1", "speed at full duty with |duty|^0.856 in place of the duty", -fit.gain,
               "mm/s", 262.6, 0.5, "duty already the next one, every move counts the same"),
    ]  # fmt: skip
    for name, target in zip(moves, STATIC_MISFIT, strict=True):
        measured = fit.nrmse_percent[name]
        rows.append(
            _claim(f"static_gain_fit_{_key(name)}", "Table 1", f"misfit of {name} with |duty|^0.856", measured, "%",
                   target, 0.1, f"{gains['current'].nrmse_percent[name]:.1f} % without the exponent; "
                   f"{late.nrmse_percent[name]:.2f} % if the duty acts {1000.0 * LATE_S:.0f} ms later",
                   "required" if abs(measured - target) <= 0.1 else "report")
        )  # fmt: skip
    return rows


def _slope(duty: np.ndarray, speed: np.ndarray) -> tuple[float, float]:
    """Slope through the origin, and share of the variance about the mean that it explains."""
    slope = float(duty @ speed / (duty @ duty))
    left = speed - slope * duty
    return slope, float(1.0 - left @ left / np.sum((speed - speed.mean()) ** 2))


def _regression(moves: Mapping[str, Move]) -> list[Claim]:
    def pairs(first: int) -> tuple[np.ndarray, np.ndarray]:
        duty = np.concatenate([m.duty[first:-1] for m in moves.values()])
        return duty, -MEAN_SPEED_MM_S * np.concatenate([-m.rate[first + 1 :] for m in moves.values()])

    duty, speed = pairs(1)
    slope, sizes = _slope(np.abs(duty), np.abs(speed))
    signed, rest = _slope(duty, speed)[1], _slope(*pairs(0))[1]
    return [
        _claim("rate_regression_speed", "Table 1", "slope of the speed in the next 0.1 s over the duty, k = 1 to 19",
               slope, "mm/s", 261.0, 0.5, "a straight line through the origin; lags and the ramp between samples are "
               "left out, so it is a lower figure than the output-error fit"),
        _claim("rate_regression_r2", "Table 1", "variance explained by it, magnitudes", sizes, "1", 0.968, 0.0005,
               "about the mean of the magnitudes; k = 0 left out"),
        _claim("rate_regression_signed_r2", "Table 1", "variance explained by it, with signs", signed, "1", None, 0.0,
               "the same residuals; with signs the speeds spread further about their mean", "report"),
        _claim("rate_regression_rest_r2", "Table 1", "variance explained by it, with signs and k = 0", rest, "1", None,
               0.0, "at k = 0 the duty is printed as 0, from before the step, and the axis then moves", "report"),
    ]  # fmt: skip


def _first_sample(moves: Mapping[str, Move], speed: float) -> list[Claim]:
    rows = []
    for name, target, sense, text in (
        ("r=-190", 0.5, "=", "a limit of current or slew holds the long move back at its start"),
        ("r=-50", 1.0, ">=", "the short move is not held back: its duty was larger before the first sample"),
    ):
        record = moves[name].record()
        share = float(record.position[1] / (speed * unit_travel(record, LAGS_S, "current")[1]))
        rows.append(
            _claim(f"first_sample_{_key(name)}", "Table 1",
                   f"way of {name} in the first 0.1 s over that under the duty of k = 1 from the step on", share, "1",
                   target, 0.1 if sense == "=" else 0.0, text, "required", sense)  # type: ignore[arg-type]
        )  # fmt: skip
    return rows


def _fitted(fits: Mapping[str, OutputErrorFit]) -> list[Claim]:
    expected: tuple[tuple[str, str, str, str, float, float], ...] = (
        ("p_289", GAIN, "gain of the P law at 289 mm/s", "1", 1.78, 0.01),
        ("p_209", GAIN, "gain of the P law at 209 mm/s", "1", 2.73, 0.01),
        ("p_free", SPEED, "speed at full duty with which a P law fits best", "mm/s", 209.0, 0.5),
        ("power_289", GAIN, "gain c of the law c |e|^p at 289 mm/s", "1", 0.929, 0.002),
        ("power_289", EXPONENT, "exponent p of the law c |e|^p at 289 mm/s", "1", 0.618, 0.001),
        ("power_free", SPEED, "speed at full duty with which c |e|^p fits best", "mm/s", 216.0, 0.5),
        ("power_216", GAIN, "gain c of the law c |e|^p at 216 mm/s", "1", 1.63, 0.015),
        ("power_216", EXPONENT, "exponent p of the law c |e|^p at 216 mm/s", "1", 0.758, 0.001),
    )  # fmt: skip
    rows = [
        _claim(f"law_{law}_{key.rpartition('.')[2]}", "Table 1", text, fits[law].parameters[key], unit, target,
               tolerance, f"standard error {fits[law].standard_error[key]:.2g}, condition number "
               f"{fits[law].condition:.1f}", basis="fitted to this number")
        for law, key, text, unit, target, tolerance in expected
    ]  # fmt: skip
    pid, pd = fits["pid_209"].parameters, fits["pd_289"].parameters
    lead_ms = 1000.0 * pd[KD] / pd[KP]
    derivative = "no derivative" if KD in fits["pid_209"].at_bound else f"kd {pid[KD]:.2g} s/mm"
    shares = f"kp {pid[KP]:.4f} 1/mm, ki {pid[KI]:.2g} 1/(mm s), {derivative}"
    misfits: tuple[tuple[str, str, float, float, str], ...] = (
        ("p_289", "the P law at 289 mm/s", 5.1, 0.05, "the long moves are too quick and the short ones too slow"),
        ("pd_289", "the PD law at 289 mm/s", 5.0, 0.05, f"{lead_ms:.0f} ms of derivative time change little"),
        ("p_209", "the P law at 209 mm/s", 1.8, 0.05, "a slower plant suits the errors, but not the duty of Table 1"),
        ("pid_209", "the PID law at 209 mm/s", 1.5, 0.05, shares),
        ("power_289", "c |e|^p at 289 mm/s", 1.6, 0.05, "two constants, four moves, and the speed of the duty column"),
        ("power_216", "c |e|^p at 216 mm/s", 0.87, 0.005, "the best of all, at the speed that fits the errors best"),
    )
    return rows + [
        _claim(f"law_{law}_misfit", "Table 1", f"misfit of {text}, root mean square of the four moves",
               fits[law].total_percent, "%", target, tolerance, reason, basis="fitted to this number")
        for law, text, target, tolerance, reason in misfits
    ]  # fmt: skip


def _judged_by_duty(played: Mapping[str, Played], moves: Mapping[str, Move]) -> list[Claim]:
    found = {name: duty_misfit(played[name], moves).values() for name in ("power_289", "power_216")}
    best, worst = min(found["power_289"]), max(found["power_289"])
    other = found["power_216"]
    text = "the duty is in no fit, so it judges them"
    return [
        _claim("law_duty_best", "Table 1", "duty of c |e|^p at 289 mm/s against Table 1, the best move", best, "1",
               0.017, 0.0005, text),
        _claim("law_duty_worst", "Table 1", "duty of c |e|^p at 289 mm/s against Table 1, the worst move", worst, "1",
               0.077, 0.0005, text),
        _claim("law_duty_216", "Table 1", "duty of c |e|^p at 216 mm/s against Table 1, the worst move",
               max(other), "1", None, 0.0, f"{min(other):.3f} at best: what the errors gain at that speed the duty "
               "loses, so one constant gain cannot serve both columns", "report"),
    ]  # fmt: skip


def _static_law(moves: Mapping[str, Move]) -> list[Claim]:
    fit = static_fit(moves)
    text = "sample by sample, no dynamics, k = 0 left out"
    return [
        _claim("law_static_gain", "Table 1", "c of |duty| = c |e|^p through the samples", fit.gain, "1", 1.076, 0.001,
               text, basis="fitted to this number"),
        _claim("law_static_exponent", "Table 1", "p of |duty| = c |e|^p through the samples", fit.exponent, "1", 0.689,
               0.001, text, basis="fitted to this number"),
        _claim("law_static_rms", "Table 1", "duty against |duty| = c |e|^p through the samples", fit.rms, "1", 0.036,
               0.0005, text, basis="fitted to this number"),
    ]  # fmt: skip


def _linear_residual(p: Played, pid: Played) -> list[Claim]:
    left = {
        (law, way): 1000.0 * abs(float(played.error_mm(way)[2000]))
        for law, played in (("P", p), ("PID", pid))
        for way in (-50.0, -170.0, -190.0)
    }
    each = ", ".join(f"{law} {way:g} mm: {um:.0f} um" for (law, way), um in left.items())
    return [
        _claim("law_linear_residual", "Table 1, Figure 12",
               "error after 2 s of the linear laws that fit Table 1, the smallest of all moves", min(left.values()),
               "um", 10.0, 0.0, f"{each}; a linear law slow enough for Table 1 is not within 10 um by then", "required",
               ">=", "reconstructed plant"),
        _claim("law_linear_residual_m50", "Table 1, Figure 12", "error of the P law 2 s after a step to -50 mm",
               left["P", -50.0], "um", 100.0, 50.0, f"{left['P', -170.0]:.0f} um after a step to -170 mm", "report",
               "=", "reconstructed plant"),
    ]  # fmt: skip


def _power_law(played: Played) -> list[Claim]:
    rows = [
        _claim(f"law_power_10um_{key}", "Figure 12", f"within 10 um of {way:g} mm by c |e|^p at 289 mm/s",
               played.within_s(way, 0.010), "s", target, 0.01, "our stand-in on an ideal encoder; a gain that grows "
               "towards e = 0 arrives where a linear law still creeps", basis="reconstructed plant", paper=2.0)
        for key, way, target in (("m50", -50.0, 1.03), ("m170", -170.0, 1.67))
    ]  # fmt: skip
    at = -170.0 - float(played.error_mm(-170.0)[1250])
    rows.append(
        _claim("law_power_position_m170", "Figure 11 (b)", "position of c |e|^p at 1.25 s on the way to -170 mm", at,
               "mm", -163.7, 0.05, f"{170.0 + at:.1f} mm short; the paper says that it nearly arrived",
               basis="reconstructed plant")
    )  # fmt: skip
    return rows


def _order(loops: Loops) -> list[Claim]:
    targets = {
        ("corrected.vud_beta_e_half", STEPS[0]): -0.016, ("corrected.vud_beta_e_half", STEPS[1]): 0.183,
        ("corrected.vud_beta_e", STEPS[0]): -0.127, ("corrected.vud_beta_e", STEPS[1]): -0.180,
    }  # fmt: skip
    way = {STEPS[0]: "m50", STEPS[1]: "m170"}
    rows = []
    for (controller, scenario), target in targets.items():
        vud, old = (loops.run(c, scenario).metrics["settling_1pct"] for c in (controller, "ours.original_fit"))
        rows.append(
            _claim(f"later_{controller.split('.')[1]}_{way[scenario]}", "after Figure 11",
                   f"{controller} is within 1 % of {way[scenario].replace('m', '-')} mm later than the original servo",
                   vud - old, "s", target, 0.01, "the paper's 'a little' is a delay of this size and sign" if vud > old
                   else "earlier, where the paper says a little later", basis="reconstructed plant")
        )  # fmt: skip
    return rows
