"""The friction curve of an identified axis: the map, its 95 % band, and what the log shows at each speed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from leadscrew.friction.static_map import Sliding, TwoSided

if TYPE_CHECKING:
    from leadscrew.identify.axis.result import AxisFit, Judged

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
