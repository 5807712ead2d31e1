"""Runs against friction: sines of 0.7 Hz, and a circle of 10 mm with two axes that differ.

Where the digest is silent: a run takes 30 s from rest, and its last 10 s, seven periods, count; the sines are read
without an encoder, the circle with one of 0.5 um and 0.1 um of noise (both found by trying: with them its numbers
appear). On the circle Y's table has 10 % less gain. X is a cosine: the sine of a run a quarter of a period later.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from leadscrew.analysis.circular.paths import USUAL, CircularTest, Turn
from leadscrew.controllers.inverse_feed_forward import inverse_feed_forward
from leadscrew.controllers.learned_feed_forward import TUNINGS as LEARNING
from leadscrew.controllers.learned_feed_forward import learned_feed_forward
from leadscrew.controllers.npid import npid
from leadscrew.controllers.pid import TUNINGS as PID
from leadscrew.controllers.resonant import resonant
from leadscrew.kernel.block import Block
from leadscrew.plants.xy_table import XYTableParams
from leadscrew.plants.xy_table_lugre import LEVELS
from leadscrew.studies.npid_xytable.calibration import BASE_HZ, PERIOD_S
from leadscrew.studies.npid_xytable.controllers import CONTROLLERS
from leadscrew.studies.npid_xytable.runs import Loops

if TYPE_CHECKING:
    from leadscrew.analysis.harmonics import LineFit

RUN_S, COUNTS = 30.0, round(10.0 / PERIOD_S)
ON_FRICTION = "sine_1mm_on_friction_medium"
GAIN = XYTableParams().gain
ORDERS = tuple(range(1, 12))
"""Of 0.7 Hz: 1 is the motion."""
ODD_HZ = tuple(BASE_HZ * n for n in range(1, 42, 2))
"""The 21 odd harmonics up to 28.7 Hz."""

RETUNED = PID["ours.pid_ms_185"]
RESONANT = resonant(RETUNED, ODD_HZ, strength=2.0)
FULL = inverse_feed_forward(RESONANT, share=0.9)
"""The digest's last column: 90 % of feed-forward, 21 odd resonators; strength 2 gives its numbers."""

SINES: dict[str, Block] = {"paper.pid": PID["paper.pid"], "corrected.npid_um": npid, "retuned": RETUNED, "full": FULL}
"""The columns of the digest's table of friction."""


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
WRONG = {"half the presliding": (5.0, 1.0), "double the presliding": (20.0, 1.0), "no friction": (10.0, 0.0)}
"""What the learned feed-forward believes where more is wrong: presliding in um, share of friction at the start."""
ENCODER_UM, NOISE_UM = 0.5, 0.1


def varied_friction(case: Rough) -> tuple[Rough, ...]:
    """The case itself, then friction 20 % more and less, presliding 20 % more and less, gain 10 % less."""
    return (
        case,
        *(case._replace(friction_mv=x * case.friction_mv) for x in (1.2, 0.8)),
        *(case._replace(presliding_um=x * case.presliding_um) for x in (1.2, 0.8)),
        case._replace(gain=0.9 * case.gain),
    )


LEARNED = LEARNING["ours.learned"]
LEARNED_RESONANT = learned_feed_forward(RESONANT)


def corners(case: Rough) -> tuple[Rough, ...]:
    """Friction and presliding 20 % off, both ways, each with a gain 10 % less; then a static ratio of 1 and of 1.5."""
    return (
        *(
            case._replace(friction_mv=x * case.friction_mv, presliding_um=y * case.presliding_um, gain=0.9 * case.gain)
            for x in (0.8, 1.2)
            for y in (0.8, 1.2)
        ),
        *(case._replace(static_ratio=ratio) for ratio in (1.0, 1.5)),
    )


def learned(case: Rough) -> Block:
    """Learned feed-forward that believes the friction of a case."""
    return LEARNED.using(**{"belief.friction_mv": case.friction_mv, "belief.presliding_um": case.presliding_um})


def by_sign(block: Block) -> Block:
    """A learned feed-forward that does not learn: 90 % of the inverse plant, and 18 of 20 mV as a sign of the speed."""
    values = {"presliding_um": 0.05, "static_ratio": 1.0, "rate": 0.0, "share": 0.9, "friction_share": 0.9}
    return block.using(**{f"belief.{key}": value for key, value in values.items()})


CIRCLES: dict[str, Block] = {
    "paper.pid": PID["paper.pid"],
    "corrected.npid_um": npid,
    "ours.pid_scaled": CONTROLLERS["ours.pid_scaled"],
    "retuned": RETUNED,
    "by_sign": by_sign(LEARNED),
    "by_sign_resonant": by_sign(LEARNED_RESONANT),
    "learned": learned(MEDIUM),
}
"""On the circle; the two by sign stand for the digest's "friction FF", whose form it does not give."""


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


def errors(
    loops: Loops,
    controller: Block,
    cases: Sequence[Rough],
    encoder_um: float = 0.0,
    settings: Mapping[str, Sequence[float]] | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Time, and the true errors in um of sines side by side; an encoder's reading has 0.1 um of noise.

    ``settings``: parameters of the controller by dotted key, one a case.
    """
    noise = NOISE_UM if encoder_um else 0.0
    loop = loops.get(controller, ON_FRICTION, encoder_um=encoder_um, noise_um=noise, metrics={})
    keys = ("plant.friction_mv", "plant.presliding_um", "reference.amplitude", "plant.static_ratio", "plant.gain")
    varied = {key: np.array(column) for key, column in zip(keys, zip(*cases, strict=True), strict=True)}
    varied |= {f"controller.{key}": np.array(column) for key, column in (settings or {}).items()}
    run = loop.batch(RUN_S, varied, record=("true_error",))
    return run.time, 1e3 * run["true_error"]


@lru_cache(maxsize=1)
def _fit() -> LineFit:
    from leadscrew.analysis.harmonics import LineFit

    return LineFit(PERIOD_S * np.arange(COUNTS), tuple(BASE_HZ * n for n in ORDERS))


def counted(error: np.ndarray) -> Sines:
    """What counts of true errors."""
    late = error[:, -COUNTS:]
    return Sines(late, np.asarray(_fit().fit(late, noise="none").amplitudes))


@dataclass(frozen=True)
class Circle:
    """A circle of 10 mm: seven turns for the numbers, the last one for the standard's quantities. um."""

    radial: np.ndarray
    """Radius less the nominal one, in time: outwards positive."""
    test: CircularTest

    @property
    def deviation(self) -> float:
        """Standard deviation of the radius: what the digest calls rms, its mean left out."""
        return float(self.radial.std())

    @property
    def rms(self) -> float:
        """Root mean square of the contour error."""
        return float(np.sqrt(np.mean(self.radial**2)))

    @property
    def largest(self) -> float:
        """Largest contour error."""
        return float(np.abs(self.radial).max())


RADIUS_MM, WEAK_Y = 10.0, 0.9


def circles(
    loops: Loops,
    controller: Block,
    cases: Sequence[Rough] = (MEDIUM,),
    settings: Mapping[str, Sequence[float]] | None = None,
) -> list[Circle]:
    """The circles of a controller on both axes against these frictions, by an encoder; ``settings`` as in `errors`.

    Clockwise is counter-clockwise mirrored: nothing in the axes knows a direction.
    """
    wide = [case._replace(amplitude_mm=RADIUS_MM) for case in cases]
    weak = [case._replace(gain=WEAK_Y * case.gain) for case in wide]
    both = {key: (*column, *column) for key, column in (settings or {}).items()}
    t, error = errors(loops, controller, (*wide, *weak), ENCODER_UM, both)
    return [_circle(t, error[k], error[len(cases) + k], controller.name) for k in range(len(cases))]


def together(blocks: Sequence[Block], path: str = "") -> dict[str, tuple[float, ...]]:
    """Parameters of controllers that share one step, as columns by dotted key."""
    rows = [getattr(b.params, path) if path else b.params for b in blocks]
    dot = f"{path}." if path else ""
    return {f"{dot}{key}": tuple(getattr(row, key) for row in rows) for key in type(rows[0])._fields}


def _circle(t: np.ndarray, error_x: np.ndarray, error_y: np.ndarray, name: str) -> Circle:
    rate, quarter = 2.0 * math.pi * BASE_HZ, 0.25 / BASE_HZ

    def path(when: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        x = RADIUS_MM * np.cos(rate * when) - 1e-3 * np.interp(when + quarter, t, error_x)
        return x, RADIUS_MM * np.sin(rate * when) - 1e-3 * np.interp(when, t, error_y)

    last = t[-1] - quarter
    seven = path(t[t <= last][-COUNTS:])
    x, y = path(math.floor(last * BASE_HZ) / BASE_HZ - (1.0 - np.arange(USUAL) / USUAL) / BASE_HZ)
    test = CircularTest(
        RADIUS_MM, Turn("ccw", x, y), Turn("cw", x, -y), feed_mm_min=60.0 * RADIUS_MM * rate, name=name,
        sampling=f"{USUAL} points of the last turn, 2 kHz",
    )  # fmt: skip
    return Circle(1e3 * (np.hypot(*seven) - RADIUS_MM), test)


class FrictionRuns:
    """Everything that claims and pictures need, each made once."""

    def __init__(self, loops: Loops) -> None:
        self.loops = loops

    @cached_property
    def table(self) -> dict[str, Sines]:
        """:data:`SINES` on :data:`TABLE`; PID and NPID on :data:`MORE` as well."""
        most = (*TABLE, *MORE)
        gains = together([SINES["paper.pid"]] * len(most) + [RETUNED] * len(TABLE))
        linear = errors(self.loops, RETUNED, (*most, *TABLE), settings=gains)[1]
        return {
            "paper.pid": counted(linear[: len(most)]),
            "corrected.npid_um": counted(errors(self.loops, SINES["corrected.npid_um"], most)[1]),
            "retuned": counted(linear[len(most) :]),
            "full": counted(errors(self.loops, SINES["full"], TABLE)[1]),
        }

    @cached_property
    def learned(self) -> Sines:
        """The hardest case, learned, with an encoder: :func:`varied_friction`, :func:`corners`, then :data:`WRONG`."""
        cases = (*varied_friction(HIGH_15), *corners(HIGH_15), *(HIGH_15 for _ in WRONG))
        believed = [*((HIGH_15.presliding_um, 1.0) for _ in cases[: -len(WRONG)]), *WRONG.values()]
        keys = ("belief.presliding_um", "belief.friction_share")
        beliefs = dict(zip(keys, zip(*believed, strict=True), strict=True))
        return counted(errors(self.loops, learned(HIGH_15), cases, ENCODER_UM, beliefs)[1])

    @cached_property
    def circles(self) -> dict[str, Circle]:
        """:data:`CIRCLES` at 20 mV."""
        names = ("paper.pid", "ours.pid_scaled", "retuned")
        gains = together([CIRCLES[name] for name in names])
        found = dict(zip(names, circles(self.loops, RETUNED, (MEDIUM,) * len(names), gains), strict=True))
        for name in ("corrected.npid_um", "by_sign_resonant"):
            found[name] = circles(self.loops, CIRCLES[name])[0]
        found |= {"by_sign": self._learning[-1], "learned": self._learning[0]}
        return {name: found[name] for name in CIRCLES}

    @cached_property
    def learned_circles(self) -> list[Circle]:
        """The learned circle on the friction of :func:`varied_friction`; Y always has 10 % less gain."""
        return self._learning[:-1]

    @cached_property
    def _learning(self) -> list[Circle]:
        cases = varied_friction(MEDIUM)[:5]
        believed = together([CIRCLES["learned"]] * len(cases) + [CIRCLES["by_sign"]], "belief")
        return circles(self.loops, LEARNED, (*cases, MEDIUM), believed)
