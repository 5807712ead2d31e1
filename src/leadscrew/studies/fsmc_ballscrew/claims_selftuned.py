"""Claims about friction found from one record, and about the controllers that then believe it."""

from __future__ import annotations

from leadscrew.friction.lugre import LuGre
from leadscrew.identify.friction import FrictionFit
from leadscrew.plants.ballscrew_stage import INERTIA
from leadscrew.report.claim import Claim, Kind, Sense
from leadscrew.studies.fsmc_ballscrew.controllers import CONTROLLERS
from leadscrew.studies.fsmc_ballscrew.fits import Fits
from leadscrew.studies.fsmc_ballscrew.naming import WAY
from leadscrew.studies.fsmc_ballscrew.runs import Loops, tail_um
from leadscrew.studies.fsmc_ballscrew.scenarios import SINES
from leadscrew.studies.fsmc_ballscrew.selftuned import believing
from leadscrew.studies.fsmc_ballscrew.tunings import GAINS

SECONDS = {"sine_slow": (8.4, 0.5), "sine_wide": (8.4, 0.06), "sine_fast": (3.0, 0.15)}
"""Duration of a run, and the part that does not count."""

UNSAID = "the paper takes its parameters from another paper and identifies none"


def _claim(
    name: str, statement: str, measured: float | str, unit: str, sense: Sense, target: float | str | None,
    tolerance: float = 0.0, kind: Kind = "required", reason: str = UNSAID,
) -> Claim:  # fmt: skip
    value = measured if isinstance(measured, str) else float(measured)
    return Claim(
        f"fsmc_ballscrew.selftuned_{name}", "Table 2", "ours", "printed plant", statement, None, value, unit, sense,
        target, tolerance, kind, "cannot be checked", reason,
    )  # fmt: skip


def selftuned_claims(loops: Loops, fits: Fits | None = None) -> list[Claim]:
    """Recovered parameters against the truth, and errors of the controllers that believe them."""
    kept = fits or Fits(loops)
    test, sines = kept.of("test"), kept.of("sines")
    return [*_recovered(test), *_from_sines(sines), *_tracking(loops, test, sines)]


def _off(fit: FrictionFit, name: str) -> float:
    return 100.0 * (getattr(fit.friction, name) / getattr(LuGre(), name) - 1.0)


def _said(fit: FrictionFit, name: str) -> str:
    percent = 100.0 * fit.standard_error[name] / getattr(fit.friction, name)
    return f"found {getattr(fit.friction, name):.5g}, own standard error {percent:.2g} %"


def _recovered(fit: FrictionFit) -> list[Claim]:
    limits: dict[str, tuple[float, Kind, str]] = {
        "stiffness": (1.0, "moonshot", "sigma_0"), "damping": (1.0, "moonshot", "sigma_1"),
        "static": (5.0, "moonshot", "F_S"), "stribeck_speed": (5.0, "moonshot", "v_s"),
        "coulomb": (0.01, "required", "F_C"), "viscous": (0.01, "required", "sigma_2"),
    }  # fmt: skip
    rows = [
        _claim(f"test_{name}", f"{symbol} found from the friction test of 7.5 s, size of the error",
               abs(_off(fit, name)), "%", "<=", most, 0.0, kind, _said(fit, name))
        for name, (most, kind, symbol) in limits.items()
    ]  # fmt: skip
    rows.append(
        _claim("test_inertia", "inertia found from the friction test, size of the error",
               100.0 * abs(fit.inertia / INERTIA - 1.0), "%", "<=", 1.0, 0.0, "required",
               f"found {fit.inertia:.4g} kg m^2")
    )  # fmt: skip
    return rows


def _from_sines(fit: FrictionFit) -> list[Claim]:
    limits = {"stiffness": (1.6, "sigma_0"), "damping": (1.7, "sigma_1"), "coulomb": (0.005, "F_C"),
              "viscous": (0.01, "sigma_2")}  # fmt: skip
    rows = [
        _claim(f"sines_{name}", f"{symbol} found from 7.9 s of 5 sin t + sin 2 pi t, size of the error",
               abs(_off(fit, name)), "%", "<=", most, 0.0, "required", _said(fit, name))
        for name, (most, symbol) in limits.items()
    ]  # fmt: skip
    untold = [name for name, known in fit.identifiable.items() if not known]
    rows.append(
        _claim("sines_untold", "what that record does not tell, by the fit's own statement", ", ".join(untold), "",
               "order", "static, stribeck_speed", 0.0, "required",
               f"F_S {_off(fit, 'static'):+.0f} %, v_s {_off(fit, 'stribeck_speed'):+.0f} %: both act in creeping, "
               "in a reversal of millimetres for a third of a millisecond")
    )  # fmt: skip
    return rows


def _errors(loops: Loops, law: object, which: tuple[str, ...] = SINES, **options: object) -> dict[str, float]:
    found = {}
    for scenario in which:
        seconds, after = SECONDS[scenario]
        run = loops.run(law, scenario, seconds, **options)  # type: ignore[arg-type]
        found[scenario] = tail_um(run, after)[0]
    return found


def _tracking(loops: Loops, test: FrictionFit, sines: FrictionFit) -> list[Claim]:
    scheduled = believing(CONTROLLERS["ours.pd_dob"], test, GAINS)
    fixed = believing(CONTROLLERS["ours.pd_dob_fixed"], sines)
    digest = {"sine_slow": (0.012, 0.43), "sine_wide": (0.059, 0.111), "sine_fast": (0.065, 0.033)}
    rows, found, plain = [], _errors(loops, scheduled), _errors(loops, fixed)
    for scenario in SINES:
        ours, theirs = digest[scenario]
        rows += [
            _claim(f"scheduled_{scenario}", f"largest error on {WAY[scenario]} at 4 kHz: scheduled gains that trust "
                   "the found friction", found[scenario], "um", "<=", None, 0.0, "report",
                   f"the digest has {ours} um with gains of its own"),
            _claim(f"fixed_{scenario}", f"largest error on {WAY[scenario]} at 4 kHz: fixed gains, friction found "
                   "from the sines", plain[scenario], "um", "<=", None, 0.0, "report", f"the digest has {theirs} um"),
        ]  # fmt: skip
    worst = max(found.values())
    chance = (
        "the third digit is chance: near the Stribeck speed a rounding of the scale decides when the stage lets go, "
        "and a fourth digit of the found friction moves the largest error by tens of per cent"
    )
    rows += [
        _claim("scheduled_worst", "largest error on the three sines with the found friction, no more than the digest's",
               worst, "um", "<=", 0.065, 0.0, "required", chance),
        _claim("scheduled_50nm", "the same, 50 nm", worst, "um", "<=", 0.05, 0.0, "moonshot", chance),
    ]  # fmt: skip
    fast = _errors(loops, scheduled, SINES[1:], period=1e-4)
    rows.append(
        _claim("scheduled_10khz", "largest error on the two larger sines at 10 kHz with the same gains",
               max(fast.values()), "um", "<=", 0.065, 0.0, "required", "no gain was chosen for 10 kHz")
    )  # fmt: skip
    return rows
