"""Claims about the process that was reconstructed: its constants, its integration, its texture."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from leadscrew.plants.flexible_cut import MATERIALS, FlexibleCutParams
from leadscrew.report.claim import Claim
from leadscrew.studies.sofnn_tangent.chance import HALF_DIGIT
from leadscrew.studies.sofnn_tangent.comparison import NONE, comparison_of
from leadscrew.studies.sofnn_tangent.lines import FEED, PERIOD_S
from leadscrew.studies.sofnn_tangent.runs import Loops
from leadscrew.studies.sofnn_tangent.saying import said, word

SOURCE = "digest, section 6"
CONSTANTS: dict[str, tuple[float, ...]] = {
    "fabric": (45.0, 0.03, 1.0, 0.3, 0.3, 0.95),
    "leather": (25.0, 0.02, 0.4, 0.8, 0.2, 0.90),
    "foam": (90.0, 0.10, 0.2, 0.3, 0.5, 0.75),
}
"""S in deg mm, tau in s, A and B in deg, p, g; believed, not measured."""
CHORD_MM = 3.0
"""Of the blade."""
RATIO = 0.52
"""Stiffness of cutting over that of shear, fabric, in the digest."""
CHECKED = 60
"""Samples that are integrated a second time."""
TEXTURE_DEG, TEXTURE_MM = 0.25, 3.0


def plant_claims(loops: Loops) -> list[Claim]:
    """All of them."""
    return [*_constants(), *_integration(loops), *_texture(loops), *_uncompensated(loops)]


def _constants() -> Iterator[Claim]:
    ours = {name: tuple(material) for name, material in MATERIALS.items()}
    params = FlexibleCutParams()
    yield said(
        "plant_constants", SOURCE, "the materials, the axis's lag and the limit of the shear are the digest's",
        word(ours == CONSTANTS and params.axis_lag_s == 0.02 and params.most == 14.0), "", "yes",
        "fabric, leather and foam; the paper gives no process at all, and no material has been measured",
        sense="yes/no", basis="arithmetic",
    )  # fmt: skip
    for name, material in MATERIALS.items():
        yaw = math.degrees(0.5 * CHORD_MM)
        ratio = material.shear / yaw
        known = name == "fabric"
        yield said(
            f"plant_ratio_{name}", SOURCE,
            f"ratio of cutting to shear stiffness that gives S with a chord of 3 mm: {name}", ratio, "",
            RATIO if known else None, f"S = (180 / pi) (b / 2) r_c: {material.shear:g} / {yaw:.2f} = "
            f"{ratio:.3f}" + (f"; the digest {RATIO:g}" if known else "; the digest does not say it"),
            tolerance=HALF_DIGIT, kind="required" if known else "report", basis="arithmetic",
        )  # fmt: skip


def integrated_anew(loops: Loops, samples: int = CHECKED) -> tuple[float, float]:
    """Largest difference, deg, between the plant's deviation and SciPy's, and one by Euler's rule of the same period.

    The wave in fabric under the fixed network; between samples heading, curvature and offset are held.
    """
    from scipy.integrate import solve_ivp

    material, most, axis_s = MATERIALS["fabric"], FlexibleCutParams().most, FlexibleCutParams().axis_lag_s
    signals = ("actual.deviation", "applied", "disturbance.heading", "disturbance.curvature")
    run = loops.run("corrected.fnn", "wave_fabric_quiet", record=signals)
    applied, heading, curvature = (run[name][:samples] for name in signals[1:])
    y, euler = np.zeros(2), np.zeros(2)
    worst = worst_euler = 0.0
    for k in range(samples):
        load = material.shear * curvature[k] + material.fibre * math.sin(2.0 * math.radians(heading[k])) + material.bias
        steady = -most * math.tanh(load / most)

        def slope(_: float, z: np.ndarray, steady: float = steady, offset: float = applied[k]) -> np.ndarray:
            return np.array([(steady - z[0]) / material.lag_s, (offset - z[1]) / axis_s])

        y = solve_ivp(slope, (0.0, PERIOD_S), y, rtol=1e-10, atol=1e-12).y[:, -1]
        euler = euler + PERIOD_S * slope(0.0, euler)
        seen = run["actual.deviation"][k + 1]
        worst = max(worst, abs(seen - material.gain * y[1] - y[0]))
        worst_euler = max(worst_euler, abs(seen - material.gain * euler[1] - euler[0]))
    return worst, worst_euler


def _integration(loops: Loops) -> Iterator[Claim]:
    exact, euler = integrated_anew(loops)
    yield said(
        "plant_integration", SOURCE, f"largest difference from SciPy's integration of both lags, {CHECKED} samples",
        exact, "deg", 1e-8, f"{exact:.1e} deg; Euler's rule with the control period would be {euler:.2f} deg off",
        sense="<=",
    )  # fmt: skip


def _texture(loops: Loops) -> Iterator[Claim]:
    texture = loops.run(NONE, "straight", record=("disturbance.texture",))["disturbance.texture"]
    ds, count = FEED * PERIOD_S, len(texture)
    keep = math.exp(-ds / TEXTURE_MM)
    deviation = float(np.std(texture))
    independent = count * (1.0 - keep**2) / (1.0 + keep**2)
    yield said(
        "texture_deviation", SOURCE, f"standard deviation of the texture over {count * ds / 1000.0:g} m", deviation,
        "deg", TEXTURE_DEG, f"{deviation:.4f} deg; worth {independent:.0f} independent samples",
        tolerance=3.0 * TEXTURE_DEG / math.sqrt(2.0 * independent),
    )  # fmt: skip
    seen = float(np.corrcoef(texture[:-1], texture[1:])[0, 1])
    length = -ds / math.log(seen)
    yield said(
        "texture_length", SOURCE, "its correlation length, from samples next to each other", length, "mm", TEXTURE_MM,
        f"{length:.2f} mm from a correlation of {seen:.4f}",
        tolerance=3.0 * math.sqrt((1.0 - keep**2) / count) * ds / (keep * math.log(keep) ** 2),
    )  # fmt: skip


def _uncompensated(loops: Loops) -> Iterator[Claim]:
    aside = comparison_of(loops).cells[NONE].lateral.mean(axis=-1)
    for short, value, target, words in (
        ("least", aside.min(), 2.0, "smallest"), ("most", aside.max(), 15.0, "largest"),
    ):  # fmt: skip
        yield said(
            f"uncompensated_{short}", SOURCE, f"distance of the uncompensated cut from its line: {words} of nine cells",
            float(value), "mm", target, f"{value:.1f} mm; the digest gives 2 to 15 mm", tolerance=0.5,
        )  # fmt: skip
