"""Sines of 0.7 Hz against LuGre friction: 30 s from rest, of which the last 10 s, seven periods, count.

The printed controllers and the retuned one are read without an encoder, the learned feed-forward with one of 0.5 um
and 0.1 um of noise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from leadscrew.analysis.harmonics import LineFit
from leadscrew.controllers._npid import npid
from leadscrew.kernel.block import Block
from leadscrew.plants._xy_table import XYTableParams
from leadscrew.plants._xy_table_lugre import LEVELS
from leadscrew.studies.lab import Lab, measure
from leadscrew.studies.npid_xytable.calibration import PERIOD_S
from leadscrew.studies.npid_xytable.table2 import BASE_HZ
from leadscrew.studies.npid_xytable.tunings import TUNINGS

RUN_S, COUNTS = 30.0, round(10.0 / PERIOD_S)
ON_FRICTION = "sine_1mm_on_friction_medium"
GAIN = XYTableParams().gain
ORDERS = tuple(range(1, 12))
"""Of 0.7 Hz: 1 is the motion."""

RETUNED = TUNINGS["ours.pid_ms_185"]
LEARNED = TUNINGS["ours.learned"]


class Rough(NamedTuple):
    """A sine against friction."""

    friction_mv: float
    presliding_um: float
    amplitude_mm: float
    static_ratio: float = 1.2
    gain: float = GAIN


LOW, MEDIUM, HIGH, HIGH_15 = (
    Rough(2.6, 2.0, 1.0), Rough(20.0, 5.0, 1.0), Rough(150.0, 10.0, 1.0), Rough(150.0, 10.0, 15.0),
)  # fmt: skip
TABLE = (LOW, MEDIUM, HIGH, HIGH_15)
LOW_15 = LOW._replace(amplitude_mm=15.0)
COULOMB_15 = Rough(2.6, LEVELS["coulomb"].params.presliding_um, 15.0, 1.0)
COULOMB_REAL = COULOMB_15._replace(friction_mv=150.0)
MORE = (LOW_15, COULOMB_15, COULOMB_REAL)
WRONG = {
    "believed: half the presliding": (5.0, 1.0),
    "believed: double the presliding": (20.0, 1.0),
    "believed: no friction": (10.0, 0.0),
}
"""What the learned feed-forward believes where more is wrong: presliding in um, share of friction at the start."""
ENCODER_UM, NOISE_UM = 0.5, 0.1


def off(case: Rough) -> dict[str, Rough]:
    """The case as it is believed, and what may be off, alone and at once."""
    found = {"as believed": case}
    found |= {f"friction {100 * x - 100:+.0f} %": case._replace(friction_mv=x * case.friction_mv) for x in (1.2, 0.8)}
    found |= {
        f"presliding {100 * x - 100:+.0f} %": case._replace(presliding_um=x * case.presliding_um) for x in (1.2, 0.8)
    }
    found["gain -10 %"] = case._replace(gain=0.9 * case.gain)
    for x, y in ((0.8, 0.8), (0.8, 1.2), (1.2, 0.8), (1.2, 1.2)):
        found[f"gain -10 %, friction {100 * x - 100:+.0f} %, presliding {100 * y - 100:+.0f} %"] = case._replace(
            friction_mv=x * case.friction_mv, presliding_um=y * case.presliding_um, gain=0.9 * case.gain
        )
    found |= {f"static over sliding friction {r:g}": case._replace(static_ratio=r) for r in (1.0, 1.5)}
    return found


@dataclass(frozen=True)
class Sines:
    """The last 10 s of runs; the first axis is the case. um."""

    error: np.ndarray
    orders: np.ndarray
    """Amplitudes at :data:`ORDERS`."""

    @property
    def rms(self) -> np.ndarray:
        """Root mean square of the true error."""
        return np.asarray(np.sqrt(np.mean(self.error**2, axis=1)))

    @property
    def largest(self) -> np.ndarray:
        """Largest true error."""
        return np.asarray(np.abs(self.error).max(axis=1))


def turned_deg(error: np.ndarray) -> float:
    """Angle of the motion between its reversal and the largest error of the last 10 s."""
    turned = 360.0 * (BASE_HZ * PERIOD_S * np.arange(COUNTS) % 0.5) - 90.0
    return float(abs(turned[int(np.argmax(np.abs(error)))]))


def errors(
    lab: Lab,
    controller: Block,
    cases: Sequence[Rough],
    encoder_um: float = 0.0,
    settings: Mapping[str, Sequence[float]] | None = None,
) -> np.ndarray:
    """The true errors in um of sines side by side; an encoder's reading has 0.1 um of noise.

    ``settings``: parameters of the controller by dotted key, one a case.
    """
    noise = NOISE_UM if encoder_um else 0.0
    loop = lab.loop(controller, ON_FRICTION, encoder_um=encoder_um, noise_um=noise)
    keys = ("plant.friction_mv", "plant.presliding_um", "reference.amplitude", "plant.static_ratio", "plant.gain")
    varied = {key: np.array(column) for key, column in zip(keys, zip(*cases, strict=True), strict=True)}
    varied |= {f"controller.{key}": np.array(column) for key, column in (settings or {}).items()}
    run = loop.batch(RUN_S, varied, record=("true_error",))
    return np.asarray(1e3 * run["true_error"])


def counted(error: np.ndarray) -> Sines:
    """What counts of true errors."""
    late = error[:, -COUNTS:]
    lines = LineFit(PERIOD_S * np.arange(COUNTS), tuple(BASE_HZ * n for n in ORDERS))
    return Sines(late, np.asarray(lines.fit(late, noise="none").amplitudes))


def together(blocks: Sequence[Block]) -> dict[str, tuple[float, ...]]:
    """Parameters of controllers that share one step, as columns by key."""
    rows = [b.params for b in blocks]
    return {key: tuple(getattr(row, key) for row in rows) for key in type(rows[0])._fields}


@measure
def sines_on_friction(lab: Lab) -> dict[str, Sines]:
    """Table I's PID and NPID on :data:`TABLE` and :data:`MORE`, the retuned PID on :data:`TABLE`."""
    most = (*TABLE, *MORE)
    gains = together([TUNINGS["paper.pid"]] * len(most) + [RETUNED] * len(TABLE))
    linear = errors(lab, RETUNED, (*most, *TABLE), settings=gains)
    return {
        "paper.pid": counted(linear[: len(most)]),
        "corrected.npid_um": counted(errors(lab, npid, most)),
        "ours.pid_ms_185": counted(linear[len(most) :]),
    }


@measure
def learned_sines(lab: Lab) -> dict[str, Sines]:
    """The hardest case under a learned feed-forward with an encoder, by what is off or wrongly believed."""
    cases = {**off(HIGH_15), **dict.fromkeys(WRONG, HIGH_15)}
    believed = [WRONG.get(name, (HIGH_15.presliding_um, 1.0)) for name in cases]
    keys = ("belief.presliding_um", "belief.friction_share")
    beliefs = dict(zip(keys, zip(*believed, strict=True), strict=True))
    block = LEARNED.using(**{"belief.friction_mv": HIGH_15.friction_mv, "belief.presliding_um": HIGH_15.presliding_um})
    found = counted(errors(lab, block, tuple(cases.values()), ENCODER_UM, beliefs))
    return {name: Sines(found.error[k : k + 1], found.orders[k : k + 1]) for k, name in enumerate(cases)}
