"""What ``identify axis`` found: parameters with intervals, errors on data it saw and on data it did not, and advice.

Keys are those of the plant :obj:`leadscrew.plants.servo_axis`, and ``delay_s``. Units are SI; where the force of a unit
of the drive is not known, the drive's own unit stands for the newton.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from leadscrew.identify.estimation import Parameter
from leadscrew.logs.measure import beyond_step


@dataclass(frozen=True)
class Judged:
    """Measured against simulated, over one stretch of the log."""

    what: str
    """``training``, ``hold-out``, ``whole log``; with ``, closed loop`` where the known controller was simulated."""
    start_s: float
    end_s: float
    rms: float
    """Of the position, m or rad, drive to position, started from the measured state at its beginning."""
    worst: float
    nrmse_percent: float
    """Of the range of the measured position."""
    rms_force: float
    """Of what inverse dynamics leaves of the drive's force, N or N m."""
    force_percent: float
    """The same, of the root mean square of the force."""
    whiteness: float
    """Share of the residual's autocorrelations within their 95 % bounds: about 95 for white noise."""
    time: np.ndarray
    measured: np.ndarray
    simulated: np.ndarray
    speed: np.ndarray
    force_left: np.ndarray
    """Residual of inverse dynamics by sample; with ``speed`` it shows what friction is missed."""


@dataclass(frozen=True)
class AxisFit:
    """A model of an axis, and how far to trust it."""

    source: str
    model: Literal["coulomb", "stribeck", "lugre"]
    symmetric: bool
    """Friction alike both ways."""
    position_unit: Literal["m", "rad"]
    drive_unit: str
    period: float
    parameters: dict[str, Parameter]
    judged: list[Judged]
    """Training first, then hold-out, then closed loop where it was asked for."""
    condition: float
    """Of the last least-squares problem, columns scaled: above 100 the parameters trade with one another."""
    correlation: dict[str, dict[str, float]]
    method: str
    """What was done, in one sentence: filter corner, refinement, windows."""
    encoder_step: float
    noise: float
    """Of the measured position, root mean square, m or rad; the rounding to steps is part of it."""
    top_speed: float
    top_acceleration: float
    travel: tuple[float, float]
    """Lowest and highest measured position."""
    top_drive: float
    faults: list[str] = field(default_factory=list)
    """Why the model is worthless, where it is; what is said first."""
    notes: list[str] = field(default_factory=list)
    """What is odd about the log or the fit, in sentences."""
    advice: list[str] = field(default_factory=list)
    """What to measure next, in sentences, most useful first."""
    missing: tuple[str, ...] = ()
    """Keys that are not identifiable from the log; ``leadscrew excite`` proposes a move for them."""
    cascade_left_percent: float | None = None
    """Of the logged drive, what the cascade leaves; None where none was given, or the log has no command."""
    compared: list[dict[str, Any]] = field(default_factory=list)
    """Models that were tried: name, hold-out error, what speaks against them."""

    @property
    def values(self) -> dict[str, float]:
        """Value by key."""
        return {key: p.value for key, p in self.parameters.items()}

    def judgement(self, what: str) -> Judged | None:
        """The stretch of that name."""
        return next((j for j in self.judged if j.what == what), None)

    def as_dict(self) -> dict[str, Any]:
        """The fit for JSON, without its arrays."""
        return {
            "source": self.source, "model": self.model, "symmetric": self.symmetric,
            "position_unit": self.position_unit, "drive_unit": self.drive_unit, "period_s": self.period,
            "parameters": {k: p._asdict() for k, p in self.parameters.items()},
            "judged": [
                {n: getattr(j, n) for n in ("what", "start_s", "end_s", "rms", "worst", "nrmse_percent", "rms_force",
                                            "force_percent", "whiteness")}
                for j in self.judged
            ],
            "condition": self.condition, "correlation": self.correlation, "method": self.method,
            "encoder_step": self.encoder_step, "noise": self.noise,
            "noise_beyond_step": beyond_step(self.noise, self.encoder_step), "top_speed": self.top_speed,
            "top_acceleration": self.top_acceleration, "travel": list(self.travel), "top_drive": self.top_drive,
            "faults": self.faults,
            "notes": self.notes, "advice": self.advice, "missing": list(self.missing), "compared": self.compared,
            "cascade_left_percent": self.cascade_left_percent,
        }  # fmt: skip
