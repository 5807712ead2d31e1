"""Claims about the evaluation of a circular test: circles whose faults are known, without any loop."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from leadscrew.analysis.circular.diagnosis import Diagnosis, diagnose
from leadscrew.analysis.circular.machine_errors import AxisErrors, MachineErrors, circle_with
from leadscrew.analysis.circular.paths import TURN, USUAL, CircularTest, Floats, Turn
from leadscrew.analysis.circular.quantities import Quantities, quantities
from leadscrew.report.claim import Claim, Kind, Sense

RADIUS_MM = 100.0
LEAD_MM = 10.005
NM = 1e-3
"""In um: what the analytic cases must keep."""

Path = Callable[[Floats, int], tuple[Floats, Floats]]
"""Errors of x and y, um, at angles in the order of travel, for a direction of 1 or -1."""


def circle_analytic_claims() -> list[Claim]:
    """Circles that can be worked by hand, and faults that the diagnosis must return."""
    return [*_analytic(), *_diagnosed()]


def _claim(
    name: str, statement: str, measured: float, unit: str, sense: Sense, target: float | None, tolerance: float,
    reason: str, kind: Kind = "required",
) -> Claim:  # fmt: skip
    return Claim(
        f"fsmc_ballscrew.{name}", "section 7.1", "ours", "arithmetic", statement, None, float(measured), unit, sense,
        target, tolerance, kind, "cannot be checked", reason,
    )  # fmt: skip


def _found(errors: Path, angles: Floats) -> Quantities:
    def turn(direction: str, sign: int) -> Turn:
        phi = sign * angles
        x, y = errors(phi, sign)
        return Turn(direction, RADIUS_MM * np.cos(phi) + 1e-3 * x, RADIUS_MM * np.sin(phi) + 1e-3 * y)

    return quantities(CircularTest(RADIUS_MM, turn("ccw", 1), turn("cw", -1)))


def _squareness(phi: Floats, sign: int) -> tuple[Floats, Floats]:
    return 1e-5 * 1e3 * RADIUS_MM * np.sin(phi), np.zeros_like(phi)


def _bow(phi: Floats, sign: int) -> tuple[Floats, Floats]:
    return np.zeros_like(phi), 2.0 * np.cos(phi) ** 2


def _dead_band(phi: Floats, sign: int) -> tuple[Floats, Floats]:
    return -np.sign(-sign * np.sin(phi)), -np.sign(sign * np.cos(phi))


def _cyclic(phi: Floats, sign: int) -> tuple[Floats, Floats]:
    return np.sin(TURN * RADIUS_MM * np.cos(phi) / LEAD_MM), np.zeros_like(phi)


def _scale(phi: Floats, sign: int) -> tuple[Floats, Floats]:
    return -np.cos(phi), -np.sin(phi)


def _analytic() -> list[Claim]:
    even = TURN * np.arange(USUAL) / USUAL
    close = np.sort(np.concatenate((even + 1e-8, even + TURN / USUAL - 1e-8)))
    squareness, bow, cyclic, scale = (_found(e, even) for e in (_squareness, _bow, _cyclic, _scale))
    dead, sampled = _found(_dead_band, close), _found(_dead_band, even)
    both, way = dead.both, sampled.ccw
    assert both and way and squareness.ccw and bow.ccw and cyclic.ccw and cyclic.both and scale.both and dead.ccw
    at = "R = 100 mm"
    play = f"dead band of 2 um on both axes, {at}"
    past = 2.0 * (np.cos(TURN / USUAL) - np.sin(TURN / USUAL))
    rows: list[tuple[str, str, float, float, str]] = [
        ("squareness_g", f"G of axes 10 urad out of square, {at}", squareness.ccw.circular, 1.0, "R beta"),
        ("straightness_g", f"G of a bow of 2 um, {at}", bow.ccw.circular, 1.0, "half of the bow"),
        ("dead_band_g", f"G of a {play}", dead.ccw.circular, 2.0,
         "with points 1e-8 rad from each reversal; the digest's 1.998 is what its points missed"),
        ("dead_band_gb", f"G(b) of a {play}", both.circular, 2.0, "the whole band"),
        ("dead_band_h", f"H of a {play}", both.hysteresis, 2.0, "the whole band"),
        ("dead_band_d", f"D of a {play}", both.mean_radial, 0.0, "the two directions err by as much, in and out"),
        ("cyclic_g", f"G of a cyclic error of 1 um on X, lead {LEAD_MM:g} mm, {at}", cyclic.ccw.circular, 1.901,
         "nearly twice the amplitude"),
        ("cyclic_d", f"D of a cyclic error of 1 um on X, lead {LEAD_MM:g} mm, {at}", cyclic.both.mean_radial, -0.073,
         "the Bessel function J1(2 pi R / lead), um"),
        ("scale_d", f"D of a scale error of -10 ppm on both axes, {at}", scale.both.mean_radial, -1.0, "R times it"),
    ]  # fmt: skip
    claims = [_claim(f"ballbar_{n}", s, m, "um", "=", t, NM, r) for n, s, m, t, r in rows]
    claims.append(
        _claim("ballbar_dead_band_g_1800", f"G of a {play}, {USUAL} points a turn", way.circular, "um", ">=",
               float(past), NM, f"0.2 degree past a reversal cos - sin leaves {past:.3f} um; a point on the reversal "
               "itself counts here as without play")
    )  # fmt: skip
    return claims


X = AxisErrors(
    lag_um=104.0, scale_ppm=-10.0, backlash_plus_um=2.0, backlash_minus_um=3.0, straightness_um=2.0, cyclic_um=1.0,
    lead_mm=LEAD_MM, cyclic_phase_rad=0.5,
)  # fmt: skip
Y = AxisErrors(
    lag_um=100.0, scale_ppm=20.0, backlash_plus_um=5.0, backlash_minus_um=4.0, straightness_um=-3.0, cyclic_um=0.7,
    lead_mm=5.0, cyclic_phase_rad=1.0,
)  # fmt: skip
ALL = MachineErrors(X, Y, squareness_urad=30.0)
"""Of the size of a good machining centre."""

ALONE = 720
"""Points a turn of a fault alone, which needs no more; the tests have all with 1,800."""

KINDS: dict[str, tuple[str, ...]] = {
    "backlash": ("backlash_plus_um", "backlash_minus_um"),
    "squareness": ("squareness_urad",),
    "scale mismatch": ("scale_ppm",),
    "servo mismatch": ("lag_um",),
    "straightness": ("straightness_um",),
    "cyclic error": ("cyclic_um", "lead_mm", "cyclic_phase_rad"),
}
"""The faults of the acceptance, and what of :data:`ALL` they are."""


def only(kind: str) -> MachineErrors:
    """The machine with this fault alone."""
    own = [name for name in KINDS[kind] if name in AxisErrors._fields]
    x, y = (AxisErrors()._replace(**{name: getattr(axis, name) for name in own}) for axis in (X, Y))
    return MachineErrors(x, y, squareness_urad=ALL.squareness_urad if kind == "squareness" else 0.0)


def made(errors: MachineErrors) -> dict[str, float]:
    """Every fault in um, by the names of the diagnosis."""
    found = {
        "squareness": 1e-3 * errors.squareness_urad * RADIUS_MM,
        "servo mismatch": errors.x.lag_um - errors.y.lag_um,
    }
    for name, axis in (("X", errors.x), ("Y", errors.y)):
        found |= {
            f"scale {name}": 1e-3 * axis.scale_ppm * RADIUS_MM, f"straightness {name}": axis.straightness_um,
            f"backlash {name}+": axis.backlash_plus_um, f"backlash {name}-": axis.backlash_minus_um,
            f"cyclic error {name}": axis.cyclic_um, f"stick motion {name}": 0.0, f"stick-slip {name}": 0.0,
        }  # fmt: skip
    return found


def share_of_allowed(found: Diagnosis, errors: MachineErrors) -> tuple[float, str]:
    """Of the faults that are there and those that are not, the one that is farthest off: part of what is allowed (2 %
    or 0.05 um, whichever is more), and its name.
    """
    off = {
        name: abs((found[name].um or 0.0) - size) / max(0.02 * abs(size), 0.05) for name, size in made(errors).items()
    }
    worst = max(off, key=lambda name: off[name])
    return off[worst], worst


def _diagnosed() -> list[Claim]:
    rows = []
    for kind in (*KINDS, "all together"):
        errors = ALL if kind == "all together" else only(kind)
        points = USUAL if kind == "all together" else ALONE
        share, worst = share_of_allowed(diagnose(circle_with(errors, RADIUS_MM, points)), errors)
        alone = "six faults on both axes at once" if kind == "all together" else f"{kind} alone"
        rows.append(
            _claim(f"ballbar_diagnosis_{kind.replace(' ', '_')}",
                   f"diagnosis of {alone}: largest difference from what was made, of 2 % or 0.05 um", share, "1", "<=",
                   1.0, 0.0, f"largest at {worst}; what was not made must not appear either; {points} points a turn")
        )  # fmt: skip
    return rows
