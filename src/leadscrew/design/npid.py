"""Design of a nonlinear PID: the smallest error that the certificate and the noise budget allow.

1. The sampled loop of the PID, from the steps that run; margins.
2. Limits. *At rest*: the largest gain ``k_rest`` for which the autonomous loop is proved on ``[1, k_rest]`` (Tsypkin or
   the circle), divided by ``m1``. *Driven*: the largest slope ``k_driven`` for which the incremental circle criterion
   is proved on ``[1, k_driven]``, divided by ``m2``. *Noise*: the voltage's change from period to period at rest, with
   the encoder's counts and noise, at most ``budget_mv``.
3. Candidates on a grid of strength and scale, simulated at the work; those within the limits; the one with the smallest
   weighted error; a finer grid around it, twice.
4. Which limit binds: the ones that the result comes within 0.5 % of (noise: 3 %, as far as a run can tell).

Without the noise limit the search would run to a scale of zero (``alpha`` to infinity): a constant gain, that is a
linear PID with larger gains. The result says what that would give.

Candidates of a nonlinear PID, tried: how large the error is at work, and how loud the drive is at rest.

Each candidate runs in every case of the work, 20 s, whose second half is judged; the amplitudes of the true error
come from least squares at the force lines and at the motion's frequency, together with the spindle's lines.

*At rest* the axis creeps over two marks of the encoder in 10 s, so that no lucky place between two marks is taken for
quiet. ``du`` is the root mean square of the voltage's change from period to period: toggling counts times the loop's
derivative, which a drive makes audible.

A PID retuned for small errors under force lines, at a given peak of sensitivity.

The sampled loop is ``C(z) P(z)`` with ``C = kp + ki T z/(z - 1) + kd (z - 1)/(T z)``, linear in the gains, so the plant
is computed once and a whole grid of gains is judged at all frequencies at once:

    minimise    mean over the lines of   abs(1 / (1 + C P)) / abs(1 / (1 + C0 P))         (C0: the old gains)
    subject to  max over w of abs(1 / (1 + C P)) <= Ms,    ki / kp <= 1 / ti,    closed loop stable

The ratio is the one of the disturbance responses, because both have the same path from force to position. A coarse
grid, then Nelder-Mead from its best point; closed-loop poles decide on stability. ``1 / ti`` bounds the integral: the
more of it, the smaller the slow errors and the larger the overshoot of a step.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.design.npid_axis import (
    RUN_S,
    Gains,
    Law,
    TableAxis,
    Work,
    block_of,
    bounds_of,
    changes_of,
    line_changes,
    parameters_of,
    strength_for,
)
from leadscrew.util.errors import ValueRefused

if TYPE_CHECKING:
    from leadscrew.analysis.harmonics import LineFit
    from leadscrew.analysis.stability.certificate import Certificate
    from leadscrew.analysis.stability.linear import LinearLoop
    from leadscrew.controller_file import ControllerFile
    from leadscrew.kernel.block import Block


EVERY = 4
"""Every how many periods the error is recorded: 500 Hz at 2 kHz, above all lines that are fitted."""

CREEP_HZ = 0.05
"""Frequency of the creep at rest: two marks to and fro in 20 s."""


@dataclass(frozen=True)
class Tried:
    """Candidates, one an entry; what diverged is infinite."""

    rows_um: np.ndarray
    """Amplitudes of the error at the force lines, ``(candidates, cases, lines)``."""
    tracking_um: np.ndarray
    """At the motion's frequency, ``(candidates, cases)``."""
    rms_um: np.ndarray
    largest_um: np.ndarray
    work_du_mv: np.ndarray
    """Change of the voltage from period to period at work, rms, ``(candidates, cases)``."""
    rest_du_mv: np.ndarray
    """The same at rest, ``(candidates,)``."""

    def score(self, base: Tried, weight: float) -> np.ndarray:
        """Weighted mean of all amplitudes, each relative to that of ``base`` (one candidate): 1 is no better."""
        with np.errstate(divide="ignore", invalid="ignore"):
            rows = self.rows_um / base.rows_um[0]
            tracking = self.tracking_um / base.tracking_um[0]
        used = base.rows_um[0] > 0.0
        total = np.where(used, rows, 0.0).sum(axis=(1, 2)) + weight * tracking.sum(axis=1)
        found = total / (used.sum() + weight * tracking.shape[1])
        return np.asarray(np.where(np.isfinite(found), found, np.inf))


@lru_cache(maxsize=16)
def _fit(lines_hz: tuple[float, ...], start_s: float, step_s: float, samples: int) -> LineFit:
    """The least squares at these lines, factorised once; all runs have the same times."""
    from leadscrew.analysis.harmonics import LineFit

    return LineFit(start_s + step_s * np.arange(samples), lines_hz)


class Bench:
    """The loop of one law on an axis at its work, compiled once; candidates differ in values alone."""

    def __init__(self, axis: TableAxis, work: Work, law: Law) -> None:
        self.axis, self.work, self.law = axis, work, law
        self.loop = axis.loop(block_of(law, Gains()), work)

    def tried(self, gains: Gains | Sequence[Gains], strength: Sequence[float], scale_um: Sequence[float]) -> Tried:
        """The candidates, one for each pair of strength and scale; with these gains, or each with its own."""
        strengths, scales = np.asarray(strength, dtype=float), np.asarray(scale_um, dtype=float)
        n, cases = len(strengths), self.work.cases
        law = {k: np.asarray(v) for k, v in parameters_of(self.law, strengths, scales).items()}
        loop = self.loop
        if isinstance(gains, Gains):
            loop = loop.using(changes_of(gains.as_dict()))
        else:
            law |= {key: np.array([g.as_dict()[key] for g in gains]) for key in gains[0].as_dict()}
        repeated = {k: np.tile(v, len(cases)) for k, v in changes_of(law).items()}
        volts = np.repeat(np.array([c.volts for c in cases]), n, axis=0).T
        varied: dict[str, Any] = {
            **repeated,
            **{k: v for k, v in line_changes(self.work.lines_hz, list(volts)).items() if k.endswith("amplitude")},
            "plant.spindle_hz": np.repeat([c.spindle_hz for c in cases], n),
        }
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            done = loop.batch(RUN_S, varied, record=("true_error",), every=EVERY)
            rest = loop.using(self._rest()).batch(RUN_S, changes_of(law), record=())
        error = 1e3 * done["true_error"]
        half = error.shape[1] // 2
        rows, tracking = np.full((len(cases) * n, volts.shape[0]), np.inf), np.full(len(cases) * n, np.inf)
        for i, case in enumerate(cases):
            here = slice(i * n, (i + 1) * n)
            good = np.isfinite(error[here]).all(axis=1)
            if not good.any():
                continue
            turning = {f for f in (case.spindle_hz, self.work.teeth * case.spindle_hz) if 0.0 < f < self._highest}
            asked = tuple(dict.fromkeys((self.work.frequency_hz, *self.work.lines_hz, *sorted(turning))))
            fit = (
                _fit(asked, float(done.time[half]), EVERY * self.axis.period_s, error.shape[1] - half)
                .fit(error[here][good, half:], noise="none")
                .amplitudes
            )
            where = np.flatnonzero(good) + i * n
            tracking[where] = fit[:, 0]
            rows[where] = fit[:, [asked.index(f) for f in self.work.lines_hz]]
        metrics = {k: self._shaped(v, n) for k, v in done.metrics.items()}
        return Tried(
            rows.reshape(len(cases), n, -1).transpose(1, 0, 2),
            tracking.reshape(len(cases), n).T,
            metrics["rms_error"],
            metrics["max_error"],
            metrics["chatter"],
            np.where(np.isfinite(rest.metrics["chatter"]), 1e3 * rest.metrics["chatter"], np.inf),
        )

    @property
    def _highest(self) -> float:
        return 0.5 / (EVERY * self.axis.period_s)

    def _shaped(self, values: np.ndarray, n: int) -> np.ndarray:
        found = 1e3 * np.asarray(values).reshape(len(self.work.cases), n).T
        return np.where(np.isfinite(found), found, np.inf)

    def _rest(self) -> dict[str, Any]:
        """The changes that make the loop rest: no force, a creep over two marks."""
        lines = line_changes(self.work.lines_hz, [0.0] * len(self.work.lines_hz))
        return {
            **lines,
            "plant.spindle_v": 0.0,
            "plant.tooth_v": 0.0,
            "reference.amplitude": 2e-3 * self.work.encoder_um,
            "reference.frequency": CREEP_HZ,
        }


FASTEST_INTEGRAL = 150.0
"""Largest ki / kp, rad/s: that of the retuned PID of the study."""


@dataclass(frozen=True)
class Retuned:
    """New gains, and what they are worth."""

    gains: Gains
    ms: float
    """Peak of the sensitivity."""
    ratio: float
    """Mean of the disturbance response at the lines against that of the old gains."""
    asked: float


class _Judge:
    """Sensitivities of a grid of gains."""

    def __init__(self, axis: TableAxis, lines_hz: tuple[float, ...], old: Gains) -> None:
        self.t = axis.period_s
        self.axis = axis
        unit = axis.linear(Gains(1.0, 0.0, 0.0))
        self.w = np.concatenate([np.geomspace(1.0, 0.999 * math.pi / self.t, 500), [math.pi / self.t]])
        self.plant = unit.response(self.w)
        lines = 2.0 * np.pi * np.asarray(lines_hz)
        self.lines = lines
        self.at_lines = unit.response(lines)
        self.base = np.abs(1.0 / (1.0 + self._law(old, lines) * self.at_lines))

    def _law(self, g: Gains, w: np.ndarray) -> np.ndarray:
        z = np.exp(1j * w * self.t)
        return np.asarray(g.kp + g.ki * self.t * z / (z - 1.0) + g.kd * (z - 1.0) / (self.t * z))

    def ms(self, g: Gains) -> float:
        return float(np.abs(1.0 / (1.0 + self._law(g, self.w) * self.plant)).max())

    def ratio(self, g: Gains) -> float:
        return float((np.abs(1.0 / (1.0 + self._law(g, self.lines) * self.at_lines)) / self.base).mean())

    def stable(self, g: Gains) -> bool:
        return self.axis.linear(g).stable(1.0)


def retuned(
    axis: TableAxis, lines_hz: tuple[float, ...], ms: float, old: Gains | None = None, ti_rate: float = FASTEST_INTEGRAL
) -> Retuned:
    """The PID with the smallest response to the lines at a peak of sensitivity of at most ``ms``.

    Raises:
        ValueRefused: ``ms`` at or below 1, or so small that no gains reach it.
    """
    from scipy.optimize import minimize

    if not (math.isfinite(ms) and ms > 1.0):
        raise ValueRefused(f"--retune {ms!r}: a peak of sensitivity is above 1; 1.6 is careful, 2 is brisk")
    start = old or Gains()
    judge = _Judge(axis, lines_hz, start)

    def gains(x: np.ndarray) -> Gains:
        kp = math.exp(float(x[0]))
        return Gains(kp, min(math.exp(float(x[2])), ti_rate) * kp, kp * math.exp(float(x[1])))

    def cost(x: np.ndarray) -> float:
        g = gains(x)
        over = max(0.0, judge.ms(g) / ms - 1.0)
        return math.log(judge.ratio(g)) + 200.0 * over

    spans = (
        math.log(start.kp) + np.linspace(-2.0, 1.5, 15),
        math.log(max(start.kd, 1e-9) / start.kp) + np.linspace(-1.5, 1.5, 13),
        math.log(ti_rate) - np.array([3.0, 1.5, 0.5, 0.0]),
    )
    tried = [np.array([a, b, c]) for a in spans[0] for b in spans[1] for c in spans[2]]
    order = sorted(tried, key=cost)
    best = next((x for x in order[:50] if judge.stable(gains(x))), None)
    if best is None:
        raise ValueRefused(f"--retune {ms:g}: no stable PID was found near the old gains")
    done = minimize(cost, best, method="Nelder-Mead", options={"xatol": 1e-5, "fatol": 1e-8, "maxiter": 600})
    found = gains(done.x if judge.stable(gains(done.x)) else best)
    if judge.ms(found) > 1.005 * ms:
        raise ValueRefused(
            f"--retune {ms:g}: the smallest peak of sensitivity found is {judge.ms(found):.3g}; ask for that at least"
        )
    return Retuned(found, judge.ms(found), judge.ratio(found), ms)


STUDY = "npid_xytable"
BUDGET = 1.2
"""Noise budget unless given: this many times what the PID alone does."""
STRENGTHS, FINE = 7, 7
FACTORS = 25
"""Of the linear PID that the nonlinear law is compared with."""
SCALES_UM = tuple(float(x) for x in np.geomspace(1e-3, 20.0, 15))
"""Scales that are tried; the smallest is a constant gain as far as anybody can tell."""
NEAR, NEAR_NOISE = 0.995, 0.97


@dataclass(frozen=True)
class Limits:
    """What a candidate may not exceed."""

    rest: float
    """Largest gain proved at rest, by ``rest_by``; infinite where nothing limits it."""
    rest_by: str
    driven: float
    """Largest slope proved under command and load."""
    m1: float
    m2: float
    budget_mv: float
    nyquist: float

    @property
    def gain(self) -> float:
        """``rest / m1``."""
        return self.rest / self.m1

    @property
    def slope(self) -> float:
        """``driven / m2``."""
        return self.driven / self.m2


@dataclass(frozen=True)
class Candidate:
    """One controller of the law, as tried."""

    strength: float
    scale_um: float
    gain: float
    slope: float
    score: float
    """Weighted mean of the error's amplitudes against the PID's: 1 is no better."""
    rest_du_mv: float
    work_du_mv: float
    rms_um: float
    largest_um: float
    tracking_um: float
    rows_um: tuple[tuple[float, ...], ...]

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return dict(vars(self))


@dataclass(frozen=True)
class NpidDesign:
    """A designed nonlinear PID, and what led to it."""

    axis: TableAxis
    work: Work
    law: Law
    gains: Gains
    retuned: Retuned | None
    limits: Limits
    base: Candidate
    """The PID alone."""
    best: Candidate
    free: Candidate
    """The best of the grid within the limits of gain and slope, whatever the noise."""
    linear: Candidate
    """The PID with all gains times as much as the same limits allow."""
    binding: tuple[str, ...]
    grid: tuple[Candidate, ...] = field(repr=False)
    driven: Certificate = field(repr=False)

    @property
    def parameters(self) -> dict[str, float]:
        """Of the controller's block."""
        return {**self.gains.as_dict(), **parameters_of(self.law, self.best.strength, self.best.scale_um)}

    def controller(self) -> Block:
        """The controller as a block for a loop."""
        return block_of(self.law, self.gains, self.best.strength, self.best.scale_um)

    @property
    def block_name(self) -> str:
        """The block of the catalogue."""
        return "npid_slope" if self.law == "slope" else "npid"

    def controller_file(self, study: str = STUDY) -> ControllerFile:
        """The controller as a file that ``simulate``, ``certify``, ``tune`` and ``export`` take."""
        from leadscrew._version import __version__
        from leadscrew.controller_file import ControllerFile

        notes = [
            f"made by leadscrew design npid for an axis {self.axis.gain:g} / (s^2 + {self.axis.damping:g} s + "
            f"{self.axis.stiffness:g}) with {1e3 * self.axis.dead_time_s:g} ms of dead time at "
            f"{1.0 / self.axis.period_s:g} Hz",
            f"slope at most {self.best.slope:.4g}; proved under command and load up to {self.limits.driven:.4g}",
            f"what binds: {', '.join(self.binding) or 'nothing, the optimum lies inside'}",
        ]
        tuning = {"made_by": "leadscrew design npid", "leadscrew": __version__, "notes": notes}
        return ControllerFile(study, self.block_name, self.parameters, tuning)

    def as_dict(self) -> dict[str, Any]:
        """The same as plain data, for JSON."""
        return {
            "axis": dict(vars(self.axis)),
            "law": self.law,
            "gains": self.gains.as_dict(),
            "retuned": None if self.retuned is None else {
                "asked_ms": self.retuned.asked, "ms": self.retuned.ms, "ratio": self.retuned.ratio,
            },
            "limits": {**vars(self.limits), "gain": self.limits.gain, "slope": self.limits.slope},
            "pid": self.base.as_dict(),
            "best": self.best.as_dict(),
            "without_noise_budget": self.free.as_dict(),
            "linear": self.linear.as_dict(),
            "binding": list(self.binding),
            "driven": self.driven.as_dict(),
            "controller": self.block_name,
            "parameters": self.parameters,
            "grid": [c.as_dict() for c in self.grid],
        }  # fmt: skip


def rest_limit(loop: LinearLoop) -> tuple[float, str]:
    """The largest gain that is proved for the loop at rest, on sectors from 1, and by which criterion.

    A static law with a slope of at least 1, as both laws here are: Tsypkin's multiplier may be used.
    """
    from leadscrew.analysis.stability.lmi import largest_proved

    best = (1.0, "nothing")
    for form, name in (("tsypkin", "Tsypkin"), ("circle", "circle")):
        found = largest_proved(loop, 1.0, form)  # type: ignore[arg-type]
        if found.grade == "certificate" and found.limit is not None and found.limit > best[0] * (1.0 + 1e-6):
            best = (found.limit, name)
    return best


def design_npid(
    axis: TableAxis | None = None,
    work: Work | None = None,
    gains: Gains | None = None,
    *,
    law: Law = "slope",
    retune_ms: float | None = None,
    m1: float = 1.1,
    m2: float = 1.1,
    budget_mv: float | None = None,
) -> NpidDesign:
    """A nonlinear PID for an axis at its work, as the module says.

    Args:
        axis: the plant, its dead time and period; the XY table of the study unless given.
        work: motion, force lines, encoder.
        gains: of the PID; Table I unless given.
        law: ``slope`` or ``cosh``.
        retune_ms: take the gains of :func:`retuned` at this peak of sensitivity instead.
        m1: factor that the gain keeps from the limit at rest.
        m2: factor that the slope keeps from the driven limit.
        budget_mv: largest change of the voltage from period to period at rest, rms; 1.2 times the PID's unless given.

    Raises:
        ValueRefused: an option out of range, a PID whose loop is unstable, or a budget that the PID alone exceeds.
    """
    from leadscrew.analysis.stability.lmi import driven

    axis, work, old = axis or TableAxis(), work or Work(), gains or Gains()
    for name, value in (("m1", m1), ("m2", m2)):
        if not (math.isfinite(value) and value >= 1.0):
            raise ValueRefused(f"{name} = {value!r}: a margin is a factor from 1 on")
    found = None if retune_ms is None else retuned(axis, work.lines_hz, retune_ms, old)
    used = old if found is None else found.gains
    loop = axis.linear(used)
    if not loop.stable(1.0):
        raise ValueRefused(
            f"the PID alone (kp {used.kp:g}, ki {used.ki:g}, kd {used.kd:g}) makes an unstable loop with this axis, so "
            "there is no nonlinear gain above it to design: retune it first (--retune MS)"
        )
    rest, rest_by = rest_limit(loop)
    first = driven(loop, (1.0, 1.0))
    largest = first.limit if first.limit is not None else 1.0
    bench = Bench(axis, work, law)
    none = 1.0 if law == "slope" else 0.0
    base = bench.tried(used, [none], [1.0])
    alone = _candidates(base, base, work, law, [none], [1.0])[0]
    budget = BUDGET * alone.rest_du_mv if budget_mv is None else budget_mv
    if not math.isfinite(alone.score) or not budget >= alone.rest_du_mv:
        raise ValueRefused(
            f"--budget {budget:g} mV: the PID alone moves the voltage by {alone.rest_du_mv:.3g} mV from period to "
            "period at rest, and a gain above 1 moves it more; allow more, or take a finer encoder or a smaller kd"
        )
    limits = Limits(rest, rest_by, largest, m1, m2, budget, loop.gain_limit(1.0))
    top = strength_for(law, limits.gain, limits.slope)
    if top <= none * (1.0 + 1e-9) + (1e-6 if law == "cosh" else 0.0):
        raise ValueRefused(
            f"no gain above 1 is left: proved are a gain of {rest:.4g} at rest and a slope of {largest:.4g} driven, "
            f"divided by m1 = {m1:g} and m2 = {m2:g}; retune the PID for more margin (--retune MS), or ask for less"
        )
    strengths = np.linspace(none, top, STRENGTHS)[1:]
    grid = _grid(bench, used, base, strengths, np.array(SCALES_UM))
    free = min(grid, key=lambda c: c.score)
    best = _best(grid, budget, alone)
    for shrink in (1.0, 0.3):
        best = _best([best, *_around(bench, used, base, best, none, top, shrink)], budget, alone)
    proved = driven(loop, (1.0, max(best.slope, 1.0 + 1e-9)), factor=1.0)
    return NpidDesign(
        axis, work, law, used, found, limits, alone, best, free, _linear(bench, used, base, limits),
        _binding(best, limits), tuple(grid), proved,
    )  # fmt: skip


def _candidates(tried: Tried, base: Tried, work: Work, law: Law, strengths: Any, scales: Any) -> list[Candidate]:
    score = tried.score(base, work.tracking_weight)
    return [
        Candidate(
            float(s), float(e), *bounds_of(law, float(s)), float(score[i]), float(tried.rest_du_mv[i]),
            float(tried.work_du_mv[i].mean()), float(tried.rms_um[i].mean()), float(tried.largest_um[i].max()),
            float(tried.tracking_um[i].mean()), tuple(tuple(map(float, row)) for row in tried.rows_um[i]),
        )
        for i, (s, e) in enumerate(zip(strengths, scales, strict=True))
    ]  # fmt: skip


def _grid(bench: Bench, gains: Gains, base: Tried, strengths: np.ndarray, scales: np.ndarray) -> list[Candidate]:
    a, b = (m.ravel() for m in np.meshgrid(strengths, scales, indexing="ij"))
    return _candidates(bench.tried(gains, a, b), base, bench.work, bench.law, a, b)


def _around(
    bench: Bench, gains: Gains, base: Tried, best: Candidate, none: float, top: float, shrink: float
) -> list[Candidate]:
    """A finer grid around a candidate: a step of the coarse one either way, times ``shrink``."""
    step = shrink * (top - none) / (STRENGTHS - 1)
    ratio = (SCALES_UM[-1] / SCALES_UM[0]) ** (shrink / (len(SCALES_UM) - 1))
    strengths = np.linspace(max(best.strength - step, none + 1e-3 * (top - none)), min(best.strength + step, top), FINE)
    scales = np.geomspace(best.scale_um / ratio, best.scale_um * ratio, FINE)
    return _grid(bench, gains, base, strengths, scales)


def _best(found: list[Candidate], budget: float, alone: Candidate) -> Candidate:
    """The smallest error within the budget; the PID alone where nothing is."""
    return min([c for c in found if c.rest_du_mv <= budget] or [alone], key=lambda c: c.score)


def _linear(bench: Bench, gains: Gains, base: Tried, limits: Limits) -> Candidate:
    """The PID with all gains times the largest factor within the same limits: what the nonlinear law has to beat."""
    top = min(limits.gain, limits.slope)
    factors = np.linspace(1.0, top, FACTORS)
    plain = [1.0 if bench.law == "slope" else 0.0] * FACTORS
    ones = [1.0] * FACTORS
    tried = bench.tried([gains.times(float(f)) for f in factors], plain, ones)
    rows = [
        replace(c, strength=float(f), scale_um=0.0, gain=float(f), slope=float(f))
        for f, c in zip(factors, _candidates(tried, base, bench.work, bench.law, plain, ones), strict=True)
    ]
    return _best(rows, limits.budget_mv, rows[0])


def _binding(best: Candidate, limits: Limits) -> tuple[str, ...]:
    """The limits that a candidate comes near."""
    said = []
    if best.gain >= NEAR * limits.gain:
        said.append("stability at rest")
    if best.slope >= NEAR * limits.slope:
        said.append("stability under command and load")
    if best.rest_du_mv >= NEAR_NOISE * limits.budget_mv:
        said.append("noise budget")
    return tuple(said)
