"""Intervals of what a user reads (gain, poles, zeros, delay, coefficients) from the covariance of what was fitted.

The covariance of coefficients, start and offset is :func:`leadscrew.identify.estimation.coloured`; quantities such as a
pole follow to first order.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from leadscrew.identify.estimation import LITTLE, Parameter, fitted, identifiable, quantile
from leadscrew.identify.linear.model import NUDGE, Model, sampled_response


def slopes(quantity: Callable[[np.ndarray], np.ndarray], at: np.ndarray, spread: np.ndarray) -> np.ndarray:
    """Change of some quantities by each coefficient, by central differences over a small share of its spread."""
    size = np.where(at == 0.0, 1.0, np.abs(at))
    step = np.clip(1e-3 * spread, 1e-7 * size, 1e-3 * size)
    rows = []
    for k in range(len(at)):
        away = np.zeros(len(at))
        away[k] = step[k]
        rows.append((quantity(at + away) - quantity(at - away)) / (2.0 * step[k]))
    return np.array(rows).T


BENT = 0.5
"""Share by which the simulated output may leave a straight line between the ends of an interval. Beyond it a zero, a
fast pole and the delay stand for one another, and the interval does not hold (Bates and Watts, *Nonlinear Regression
Analysis*, 1988, chapter 7)."""
FAR = 2.0
"""Times the last excited frequency, beyond which a pole or zero rests on the form of the model alone."""
ANYTHING = float(np.log(1e6))
"""Logarithm of the largest factor that an interval states: one that is wider says nothing."""

Row = tuple[Parameter, np.ndarray]
"""A quantity and its change by each unknown of the system."""


class Bode(NamedTuple):
    """The model's response at rising frequencies, from sample to sample (the hold included), with 95 % bands."""

    frequency_hz: np.ndarray
    response: np.ndarray
    """Complex, output over input."""
    gain_share: np.ndarray
    """Half width of the band of the gain, as a share of it."""
    phase_half_width: np.ndarray
    """rad."""


class Quantities(NamedTuple):
    """Quantities with intervals."""

    coefficients: dict[str, Parameter]
    parameters: dict[str, Parameter]
    offset: Parameter
    covariance: np.ndarray
    bode: Bode


def quantities(
    model: Model, phi: np.ndarray, covariance: np.ndarray, units: tuple[str, str], hz: np.ndarray
) -> Quantities:
    """From ``phi`` and its covariance; ``units`` are those of input and output, ``hz`` the frequencies of the band."""
    kept = model.kept
    at, spread = phi[:kept], np.sqrt(np.maximum(np.diag(covariance), 0.0))
    inner = covariance[:kept, :kept]
    names, values = _coefficient_names(model), _coefficients(model, at)
    by = slopes(lambda x: _coefficients(model, x), at, spread[:kept])
    cov = by @ inner @ by.T
    deviations = np.sqrt(np.maximum(np.diag(cov), 0.0))
    rows: dict[str, Row] = {n: (_plain(v, d), g) for n, v, d, g in zip(names, values, deviations, by, strict=True)}
    delay, way = rows.pop("delay_s")
    period, fixed = model.problem.period, model.problem.delay is not None
    known = fixed or identifiable(delay.value, delay.half, period)
    delay = delay._replace(low=max(delay.low, 0.0), unit="s", identifiable=known)
    straight = _straightness(model, phi, covariance)
    coefficients = {name: straight(*row) for name, row in rows.items()}
    more = {
        "gain": _gain(model, at, spread, inner, units), **_poles(model, at, inner), **_zeros(model, at, spread, inner),
        "delay_s": (delay, way),
    }  # fmt: skip
    parameters = {name: straight(*row) for name, row in more.items()}
    return Quantities(coefficients, parameters, _offset(model, phi, spread, covariance, units), cov,
                _band(model, at, spread, inner, hz))  # fmt: skip


def hertz(name: str, found: Parameter) -> float:
    """Where a pole, a pair or a zero lies; 0 for another quantity."""
    if name.startswith(("pole", "zero ")) and found.unit == "1/s":
        return abs(found.value) / (2.0 * np.pi)
    return found.value if found.unit == "Hz" else 0.0


def beyond(name: str, found: Parameter, high_hz: float) -> bool:
    """Whether it lies where the input does not move the output by more than what is left."""
    return hertz(name, found) > FAR * high_hz


def within(found: Quantities, high_hz: float) -> Quantities:
    """Only what the log speaks of is identifiable.

    A pole beyond the last excited frequency stands for many others there, far from the found one too, where no interval
    reaches. Coefficients and delay change with it; gain and what lies in the band do not.
    """
    unseen = {name for name, p in found.parameters.items() if beyond(name, p, high_hz)}
    if high_hz > 0.0 and not unseen:
        return found
    kept = [n for n in found.parameters if n == "gain" or (hertz(n, found.parameters[n]) and n not in unseen)]
    kept += [n.replace("frequency", "damping") for n in kept if "frequency" in n]

    def judged(name: str, p: Parameter) -> Parameter:
        return p if (high_hz > 0.0 and name in kept) or p.low == p.high else p._replace(identifiable=False)

    return found._replace(
        coefficients={n: judged(n, p) for n, p in found.coefficients.items()},
        parameters={n: judged(n, p) for n, p in found.parameters.items()},
    )


def _straightness(model: Model, phi: np.ndarray, cov: np.ndarray) -> Callable[[Parameter, np.ndarray], Parameter]:
    """A judge of quantities: identifiable only where what the best numerator leaves is straight enough."""
    p, at = model.problem, slice(model.m + 1, model.kept)
    theta = phi[at]
    here = p.residual(theta)
    change = np.empty((len(here), len(theta)))
    for k, nudge in enumerate(NUDGE * np.eye(len(theta))):
        change[:, k] = (p.residual(theta + nudge) - here) / NUDGE
    late, (low, high) = p.delay is None, p.bounds()

    def judge(found: Parameter, slope: np.ndarray) -> Parameter:
        way = cov[:, : model.kept] @ slope
        size = float(slope @ way[: model.kept])
        if not found.identifiable or size <= 0.0:
            return found
        for sign in (-quantile(), quantile()):
            step = sign * way[at] / np.sqrt(size)
            if late and theta[-1] + step[-1] < 0.0:
                step = step * (theta[-1] / -step[-1])
            if np.any(theta + step > high + 1e-9) or np.any(theta + step < low - 1e-9):
                return found._replace(identifiable=False)
            line = change @ step
            off = np.linalg.norm(p.residual(theta + step) - here - line)
            if not off <= BENT * np.linalg.norm(line) + 0.1 * np.linalg.norm(here) / np.sqrt(len(here)):
                return found._replace(identifiable=False)
        return found

    return judge


def _coefficient_names(model: Model) -> list[str]:
    n, q = model.n, model.problem.structure.integrators
    return [*(f"b{k}" for k in range(model.m + 1)), *(f"a{k}" for k in range(q, n)), "delay_s"]


def _coefficients(model: Model, at: np.ndarray) -> np.ndarray:
    b, theta = model.split(at)
    denominator, delay_s, _ = model.problem.system(theta)
    return np.concatenate([b, denominator[1 : model.problem.structure.free + 1][::-1], [delay_s]])


def _plain(value: float, deviation: float, unit: str = "", negligible: float = 0.0) -> Parameter:
    half = quantile() * deviation
    return fitted(value, (value - half, value + half), unit, negligible=negligible)


def _ratio(logarithm: float, deviation: float, unit: str, sign: float = 1.0) -> Parameter:
    """Of a quantity of which the logarithm is known."""
    reach = min(quantile() * deviation, ANYTHING)
    ends = sorted(sign * np.exp(logarithm + np.array([-reach, reach])))
    return fitted(float(sign * np.exp(logarithm)), (ends[0], ends[1]), unit)


def _gain(model: Model, at: np.ndarray, spread: np.ndarray, cov: np.ndarray, units: tuple[str, str]) -> Row:
    def gain(x: np.ndarray) -> np.ndarray:
        b, theta = model.split(x)
        return np.array([b[0] / model.problem.structure.denominator(theta)[model.problem.structure.free]])

    by = slopes(gain, at, spread[: len(at)])
    q = model.problem.structure.integrators
    per = units[0] if q == 0 else f"({units[0]} s{'^2' if q == 2 else ''})"
    deviation = float(np.sqrt(max((by @ cov @ by.T)[0, 0], 0.0)))
    return _plain(gain(at)[0], deviation, f"{units[1]}/{per}"), by[0]


def _poles(model: Model, at: np.ndarray, cov: np.ndarray) -> dict[str, Row]:
    theta, first, r = model.split(at)[1], model.m + 1, model.problem.structure.free

    def row(logarithm: float, changes: dict[int, float], unit: str, sign: float = 1.0) -> Row:
        slope = np.zeros(len(at))
        for k, change in changes.items():
            slope[first + k] = change
        return _ratio(logarithm, float(np.sqrt(max(slope @ cov @ slope, 0.0))), unit, sign), slope

    real: list[Row] = []
    pairs: list[tuple[Row, Row]] = []
    for k in range(0, r - r % 2, 2):
        w, zeta = theta[k], theta[k + 1]
        damping = row(zeta, {k + 1: 1.0}, "")
        if damping[0].low < 1.0:
            pairs.append((row(w - np.log(2.0 * np.pi), {k: 1.0}, "Hz"), damping))
            continue
        z = np.exp(zeta)
        root = np.sqrt(z * z - 1.0)
        for sign in (-1.0, 1.0):
            # d ln(z +- sqrt(z^2 - 1)) / d ln z = +- z / sqrt(z^2 - 1)
            log = w + sign * np.log(z + root)
            real.append(row(log, {k: 1.0, k + 1: sign * z / root}, "1/s", -1.0))
    if r % 2:
        real.append(row(theta[r - 1], {r - 1: 1.0}, "1/s", -1.0))
    found = {f"pole {k + 1}": p for k, p in enumerate(sorted(real, key=lambda p: -p[0].value))}
    for k, (hertz, damping) in enumerate(sorted(pairs, key=lambda pair: pair[0][0].value)):
        found |= {f"frequency {k + 1}": hertz, f"damping {k + 1}": damping}
    return found


def _zeros(model: Model, at: np.ndarray, spread: np.ndarray, cov: np.ndarray) -> dict[str, Row]:
    roots = np.roots(model.split(at)[0][::-1])
    if not len(roots):
        return {}
    pair = abs(roots[0].imag) > 0.0

    def said(x: np.ndarray) -> np.ndarray:
        found = np.roots(model.split(x)[0][::-1])
        if pair:
            return np.array([abs(found[0]) / (2.0 * np.pi), -found[0].real / abs(found[0])])
        return np.sort(found.real)[::-1]

    by = slopes(said, at, spread[: len(at)])
    deviation = np.sqrt(np.maximum(np.diag(by @ cov @ by.T), 0.0))
    names = (
        (("zero frequency", "Hz"), ("zero damping", ""))
        if pair
        else [(f"zero {k + 1}", "1/s") for k in range(len(roots))]
    )
    return {n: (_plain(v, d, u), g) for (n, u), v, d, g in zip(names, said(at), deviation, by, strict=True)}


def _offset(model: Model, phi: np.ndarray, spread: np.ndarray, cov: np.ndarray, units: tuple[str, str]) -> Parameter:
    s = model.problem.structure

    def offset(x: np.ndarray) -> np.ndarray:
        if not s.integrators:
            return x[-1:]
        b, theta = model.split(x)
        return np.array([-x[-1] * s.integrators * s.denominator(theta)[s.free] / b[0]])

    by = slopes(offset, phi, spread)
    deviation = float(np.sqrt(max((by @ cov @ by.T)[0, 0], 0.0)))
    signal, unit = (model.problem.u, units[0]) if s.integrators else (model.problem.y, units[1])
    return _plain(offset(phi)[0], deviation, unit, LITTLE * float(np.sqrt(np.mean(signal**2))))


def _band(model: Model, at: np.ndarray, spread: np.ndarray, cov: np.ndarray, hz: np.ndarray) -> Bode:
    def response(x: np.ndarray) -> np.ndarray:
        b, theta = model.split(x)
        step = model.problem.system(theta)[2]
        weights = np.zeros(model.n)
        weights[: model.m + 1] = model.weights(step, b)
        return sampled_response(step, weights, model.problem.period, hz)

    here = response(at)
    share = slopes(response, at, spread[: len(at)]) / here[:, None]
    wide = [np.sqrt(np.maximum(np.einsum("ki,ij,kj->k", part, cov, part), 0.0)) for part in (share.real, share.imag)]
    return Bode(hz, here, quantile() * wide[0], quantile() * wide[1])
