"""Candidates of a nonlinear PID, tried: how large the error is at work, and how loud the drive is at rest.

Each candidate runs in every case of the work, 20 s, whose second half is judged; the amplitudes of the true error
come from least squares at the force lines and at the motion's frequency, together with the spindle's lines.

*At rest* the axis creeps over two marks of the encoder in 10 s, so that no lucky place between two marks is taken for
quiet. ``du`` is the root mean square of the voltage's change from period to period: toggling counts times the loop's
derivative, which a drive makes audible.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
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
    changes_of,
    line_changes,
    parameters_of,
)

if TYPE_CHECKING:
    from leadscrew.analysis.harmonics import LineFit

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
