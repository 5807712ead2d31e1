"""What a measured friction force tells: models with intervals, errors on data they saw and on data they did not."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

import numpy as np

from leadscrew.friction.asymmetric import TwoSidedLuGre
from leadscrew.friction.dahl import Dahl
from leadscrew.friction.maxwell_slip import MaxwellSlip
from leadscrew.friction.static_map import Sliding, TwoSided
from leadscrew.identify.estimation import Parameter
from leadscrew.identify.friction_force.record import ForceRecord
from leadscrew.util.errors import ValueRefused
from leadscrew.util.escape import one_line

Load = Literal["force", "coefficient"]
"""Friction in N whatever the normal force; or a coefficient of friction times the measured normal force."""

MAP, STRIBECK, DAHL, LUGRE, SLIP = "Coulomb and viscous", "Stribeck map", "Dahl", "LuGre", "Maxwell slip"
"""Names of the models, simplest first."""


class Bin(NamedTuple):
    """Sliding friction around one speed; speed and force negative for the way back."""

    speed: float
    force: float
    """Mean over the strokes, N; of the coefficient where that is fitted."""
    low: float
    """95 % interval of the mean, from its scatter between strokes; NaN for fewer than three."""
    high: float
    strokes: int


@dataclass(frozen=True)
class ModelFit:
    """One model, fitted to the first part of the log and judged on the rest."""

    name: str
    load: Load
    friction: TwoSided | TwoSidedLuGre | Dahl | MaxwellSlip
    """Values for the functions of :mod:`leadscrew.friction`; of a coefficient model per newton of normal force."""
    parameters: dict[str, Parameter]
    offset: float
    """Added to the force, N (or per newton); 0 for models with values for each direction."""
    simulated: np.ndarray
    """N, at every sample of the record, driven by the motion alone from the first sample on."""
    training_rms: float
    holdout_rms: float
    """N; NaN without a hold-out."""
    holdout_worst: float
    training_percent: float
    """Of the friction amplitude."""
    holdout_percent: float
    condition: float
    """Of the least-squares problem, columns at unit length; NaN for one that has none."""
    whiteness: float
    """Share of the autocorrelations of the training residual within their 95 % bounds, about 95 for white noise."""
    notes: tuple[str, ...] = ()

    @property
    def identifiable(self) -> tuple[str, ...]:
        """Keys of the identifiable parameters."""
        return tuple(key for key, p in self.parameters.items() if p.identifiable)


@dataclass(frozen=True)
class FrictionForceFit:
    """All models of one record."""

    record: ForceRecord
    load: Load
    """Which of the two :attr:`models` and :attr:`chosen` are about; the other stands in :attr:`others`."""
    models: dict[str, ModelFit]
    others: dict[str, ModelFit]
    """With the other load, where the normal force was logged."""
    bins: list[Bin]
    """Binned force against speed, training part, sliding only."""
    training: int
    """Samples of the training part; the others are the hold-out."""
    amplitude: float
    """Friction amplitude of the part that is judged, N: half of largest minus smallest."""
    normal_mean: float
    """Mean normal force while sliding in the training part, N; 1 where there is none."""
    speeds: tuple[float, float]
    """Slowest and fastest sliding in the training part: 5 % and 95 % of the travel are slower."""
    notes: list[str] = field(default_factory=list)
    advice: list[str] = field(default_factory=list)

    @property
    def chosen(self) -> ModelFit:
        """LuGre, which plants and controllers take."""
        return self.models[LUGRE]

    def better_percent(self, name: str) -> float:
        """By how much the judged error of a model lies below that of Coulomb and viscous friction with its load."""
        return better_percent(self.models, name)

    def as_dict(self) -> dict[str, Any]:
        """The fit for JSON, without its arrays."""
        r = self.record
        return {
            "source": r.source, "samples": len(r.time), "training_samples": self.training, "unit": r.unit,
            "force_unit": r.force_unit, "sign_turned": r.turned, "encoder_step": r.encoder_step, "load": self.load,
            "amplitude": self.amplitude, "normal_mean": None if r.normal is None else self.normal_mean,
            "sliding_speeds": list(self.speeds),
            "models": [_model(m, self.models) for m in self.models.values()],
            "with_other_load": [_model(m, self.others) for m in self.others.values()],
            "bins": [b._asdict() for b in self.bins],
            "findings": [f._asdict() for f in r.findings], "notes": self.notes, "advice": self.advice,
        }  # fmt: skip


def better_percent(models: dict[str, ModelFit], name: str) -> float:
    """By how much the judged error of a model lies below that of Coulomb and viscous friction, in percent."""
    base, found = judged_rms(models[MAP]), judged_rms(models[name])
    return 100.0 * (1.0 - found / base) if base > 0.0 else 0.0


def judged_rms(model: ModelFit) -> float:
    """The error on the hold-out; on the training part where there is none."""
    return model.training_rms if np.isnan(model.holdout_rms) else model.holdout_rms


def _model(m: ModelFit, among: dict[str, ModelFit]) -> dict[str, Any]:
    return {
        "name": m.name, "load": m.load, "parameters": {k: p._asdict() for k, p in m.parameters.items()},
        "offset": m.offset, "training_rms": m.training_rms, "holdout_rms": m.holdout_rms,
        "holdout_worst": m.holdout_worst, "training_percent": m.training_percent,
        "holdout_percent": m.holdout_percent, "better_percent": better_percent(among, m.name),
        "condition": m.condition, "whiteness": m.whiteness, "notes": list(m.notes),
    }  # fmt: skip


def lugre_of(fit: FrictionForceFit, normal: float | None = None) -> TwoSidedLuGre:
    """LuGre in N (N m); of a coefficient model at the normal force ``normal``, the mean of the log unless given.

    Raises:
        ValueRefused: a normal force that is not positive, or one for a model that knows none.
    """
    f = fit.chosen.friction
    assert isinstance(f, TwoSidedLuGre)
    if fit.load == "force":
        if normal is not None:
            raise ValueRefused(f"normal = {normal!r}: this fit is of the force, not of a coefficient")
        return f
    scale = fit.normal_mean if normal is None else normal
    if not 0.0 < scale < float("inf"):
        raise ValueRefused(f"normal = {scale!r}: allowed range is (0, inf) N")
    return TwoSidedLuGre(f.stiffness * scale, f.damping * scale, _times(f.forward, scale), _times(f.backward, scale))


def map_of(fit: FrictionForceFit, normal: float | None = None) -> TwoSided:
    """The static map of the same LuGre fit: what is left of it in steady sliding."""
    f = lugre_of(fit, normal)
    return TwoSided(f.forward, f.backward)


def _times(way: Sliding, scale: float) -> Sliding:
    return Sliding(way.coulomb * scale, way.static * scale, way.stribeck_speed, way.viscous * scale)


def settings(fit: FrictionForceFit, *, key: str = "plant.friction", normal: float | None = None) -> dict[str, float]:
    """Values by dotted key, for ``--set`` and machine files: a plant whose friction is a ``TwoSidedLuGre``."""
    f = lugre_of(fit, normal)
    found = {f"{key}.stiffness": f.stiffness, f"{key}.damping": f.damping}
    for side, way in (("forward", f.forward), ("backward", f.backward)):
        found |= {f"{key}.{side}.{name}": value for name, value in way._asdict().items()}
    return found


def set_table(fit: FrictionForceFit, source: str, *, normal: float | None = None) -> str:
    """The same as a ``[set]`` table in TOML."""
    at = "" if fit.load == "force" else f" at a normal force of {fit.normal_mean if normal is None else normal:.6g} N"
    lines = [f"{key} = {value:.8g}" for key, value in settings(fit, normal=normal).items()]
    return (
        f"# LuGre friction of {one_line(source)}{at}, from leadscrew identify friction-force\n"
        "# for a plant whose friction is TwoSidedLuGre; without stiffness and damping for one with TwoSided\n"
        "[set]\n" + "\n".join(lines) + "\n"
    )
