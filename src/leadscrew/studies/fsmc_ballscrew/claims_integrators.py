"""Claims about stepping the stage through a hold: how far each scheme is from the truth, in nm, not in what time.

The paper names no solver and no step. What we ask of ourselves are the acceptance numbers and the table of the
project's digest; how fast each scheme is stands in ``leadscrew bench`` and on the page on stiff friction.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from leadscrew.plants.ballscrew_stage import BallscrewStageParams, BallscrewStageState, stage_jacobian
from leadscrew.report.claim import Claim, Kind, Sense
from leadscrew.studies.fsmc_ballscrew.integrators import SMOOTH, TRUTH, angles, error_nm, every, rodas, sharp_pd
from leadscrew.studies.fsmc_ballscrew.runs import Loops

WAY = {"sine_wide": "5 sin t", "sine_fast": "sin 2 pi t"}
ACCEPTED = ((rodas(1e-3), 0.5, 0.5), (rodas(1e-4), 0.05, 0.05))
"""Scheme, and the error that is accepted on each of the two sines, nm."""
DIGEST = ((every("rk4", 1.0), 2e-5, 2e-5), (every("fixed", 50.0), 0.65, 0.74))
"""Scheme, and the digest's error, nm: ours must not be larger."""
SHOWN = ((rodas(1e-6), 0.0024, 0.0026), (every("rk4", 2.0), 4.9, 4.8))
"""Scheme, and the digest's error, nm. Its feed-forward is not written down, so the digits need not agree."""
LIMITS = (("euler", "explicit Euler", 2.0, 2.34), ("rk4", "RK4", 2.785293563405282, 3.26))
"""Method, its limit on the negative real axis, and the digest's largest stable step in us."""
NO_SOLVER = "the paper names neither solver nor step"


def integrator_claims(loops: Loops) -> list[Claim]:
    """Every row about integrators."""
    return [*_errors(loops), *_leap(loops), *_limits()]


def _claim(name: str, statement: str, measured: float, unit: str, sense: Sense, target: float | None, tolerance: float,
           reason: str, kind: Kind = "required") -> Claim:  # fmt: skip
    return Claim(
        f"fsmc_ballscrew.integrator_{name}", "section 2, (1) to (5)", "ours", "printed plant", statement, None,
        measured, unit, sense, target, tolerance, kind, "cannot be checked", reason,
    )  # fmt: skip


def _key(name: str) -> str:
    return name.lower().replace(", ", "_").replace(" ", "_").replace("-", "m").replace(".", "p")


def _errors(loops: Loops) -> Iterator[Claim]:
    for at, sine in enumerate(SMOOTH):
        truth = angles(sine, TRUTH)
        for kind, table in (("required", ACCEPTED), ("required", DIGEST), ("report", SHOWN)):
            for scheme, *bounds in table:
                found = error_nm(sine, scheme, truth)
                yield _claim(
                    f"{_key(scheme.name)}_{sine}", f"largest error of {scheme.name} on {WAY[sine]}", found, "nm", "<=",
                    bounds[at], 0.0, f"against RODAS at 1e-11 over {len(truth)} holds of 250 us; {NO_SOLVER}",
                    kind,  # type: ignore[arg-type]
                )  # fmt: skip


def _leap(loops: Loops) -> Iterator[Claim]:
    truth = angles("sine_wide", TRUTH, law=sharp_pd)
    for us in (50.0, 10.0):
        scheme = every("fixed", us)
        found = error_nm("sine_wide", scheme, truth, law=sharp_pd)
        yield _claim(
            f"{_key(scheme.name)}_leap", f"largest error of {scheme.name} on 5 sin t where the torque leaps", found,
            "nm", "<=", None, 0.0,
            "the stage breaks loose within microseconds, and a step of fixed length finds out late", "report",
        )  # fmt: skip


def _limits() -> Iterator[Claim]:
    rows = np.array(stage_jacobian(BallscrewStageParams(), BallscrewStageState()))
    fastest = float(np.linalg.eigvals(rows[1:, 1:]).real.min())
    for key, method, reach, digest in LIMITS:
        yield _claim(
            f"limit_{key}", f"largest stable step of {method} while the stage sticks", -1e6 * reach / fastest, "us",
            "=", digest, 0.005, f"the eigenvalue at rest is {fastest:.3g} 1/s, set by sigma_1 / J",
        )  # fmt: skip
