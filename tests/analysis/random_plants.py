"""Random plants with delay: what the stability criteria promise, against simulation.

Every plant has three poles, one or no zero and a delay of whole periods, behind a hold; a gain or an error law closes
it. The criteria see the loop's matrices, taken from the blocks that run (:func:`loop_of`); the simulation steps the
plant and its delay line by itself (:func:`stepped`), all plants, laws and starts at once.

:func:`gap_table` sets what is proved beside what is true: the smallest gain, fixed law or switching gain that was found
to make the loop unstable. A proof below that is no fault: between the two nothing is known.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from leadscrew.analysis.stability.linear import LinearLoop
from leadscrew.analysis.stability.lmi import Form, largest_proved

COUNT = 20
SEED = 8
PERIOD_S = 1e-2
STARTS = 50
"""Initial states of every trial; the worst counts."""
NEAR = 0.01
"""How near the simulated limit must come to Nyquist's."""
LOWER = 0.3
"""Where the shifted sector begins, in parts of the Nyquist limit."""
PERIODS = 1000
"""Of a trial."""
LONG = 3000
"""Of a trial at the bound of Jury and Lee, so near Nyquist's limit that motions decay slowly."""
STEEP = 1.5
"""Upper bound of the slopes for Jury and Lee, in parts of the Nyquist limit: laws may be steeper than it, and fall."""
BELOW = 0.999
"""Trials are run with the sector's upper bound at this part of what is proved."""


@dataclass(frozen=True)
class Plant:
    """A sampled plant of order three, its delay in periods, and the continuous one that it comes from."""

    a: np.ndarray
    b: np.ndarray
    c: np.ndarray
    delay: int
    continuous: tuple[np.ndarray, np.ndarray, np.ndarray]


def random_plants(count: int = COUNT, seed: int = SEED) -> list[Plant]:
    """Plants drawn from ``seed``: one pole real, two real or a pair, each 1 to 40 rad/s; gain 1 at rest; 1 to 4
    periods.
    """
    from leadscrew.plants._linear import hold_matrices

    draw = np.random.default_rng(seed)
    found = []
    for _ in range(count):
        slow, fast, third = np.exp(draw.uniform(math.log(1.0), math.log(40.0), 3))
        pair = draw.random() < 0.5
        damping = draw.uniform(0.15, 0.9)
        two = [1.0, 2.0 * damping * fast, fast**2] if pair else np.polymul([1.0, fast], [1.0, third])
        den = np.polymul([1.0, slow], two)
        num = np.array([1.0 / draw.uniform(5.0, 60.0), 1.0]) if draw.random() < 0.5 else np.array([1.0])
        a = np.eye(3, k=1)
        a[2] = -den[:0:-1]
        b = np.array([0.0, 0.0, 1.0])
        c = np.zeros(3)
        c[: len(num)] = den[-1] * num[::-1]
        size = den[-1] ** (np.arange(3) / 3.0)  # states of like size
        a, b, c = a / size[:, None] * size, b / size, c * size
        held, drive = hold_matrices(a, b, PERIOD_S)
        found.append(Plant(np.array(held), np.array(drive), c, int(draw.integers(1, 5)), (a, b, c)))
    return found


def loop_of(plant: Plant) -> LinearLoop:
    """The loop of a gain of one around a plant, from its blocks:
    :func:`~leadscrew.analysis.stability.loop.sampled_loop`.
    """
    from leadscrew.analysis.stability.loop import sampled_loop
    from leadscrew.controllers._pid import pid
    from leadscrew.kernel.loop import Loop
    from leadscrew.plants._linear import state_space
    from leadscrew.references._sine import sine

    return sampled_loop(
        Loop(
            reference=sine, controller=pid(kp=1.0, ki=0.0, kd=0.0), plant=state_space(*plant.continuous),
            period=PERIOD_S, metrics={}, computation_delay=plant.delay * PERIOD_S,
        ),
        name="random plant",
    )  # fmt: skip


Law = Callable[[np.ndarray, np.ndarray, int], np.ndarray]
"""``phi(e, k2, period)`` for the sector [0, 1], scaled by ``k2``; ``e`` plants by starts."""


def saturation(e: np.ndarray, k: np.ndarray, period: int) -> np.ndarray:
    """Straight up to 1, then held."""
    return np.asarray(k * np.clip(e, -1.0, 1.0))


def dead_zone(e: np.ndarray, k: np.ndarray, period: int) -> np.ndarray:
    """Nothing up to 1, then straight."""
    return np.asarray(k * (e - np.clip(e, -1.0, 1.0)))


def slope_law(e: np.ndarray, k: np.ndarray, period: int) -> np.ndarray:
    """The slope-limited law: a slope from 0 at rest to ``k`` far out."""
    return np.asarray(k * (e - np.arctan(e)))


def straight(e: np.ndarray, k: np.ndarray, period: int) -> np.ndarray:
    """A fixed gain."""
    return k * e


def waves(e: np.ndarray, k: np.ndarray, period: int) -> np.ndarray:
    """A gain that swings between 0 and ``k`` with the logarithm of the error: steep, but in the sector."""
    return np.asarray(k * e * (0.5 + 0.5 * np.sin(4.0 * np.log(np.abs(e) + 1e-12))))


def bands(e: np.ndarray, k: np.ndarray, period: int) -> np.ndarray:
    """A gain that jumps between 0 and ``k`` from one band of the error to the next."""
    return np.asarray(np.where(np.floor(3.0 * np.log2(np.abs(e) + 1e-12)) % 2.0 == 0.0, k, 0.0) * e)


def rolling(e: np.ndarray, k: np.ndarray, period: int) -> np.ndarray:
    """A gain that swings between 0 and ``k`` over wide bands of the error: slopes from ``-k / 2`` to ``3 k / 2``."""
    return np.asarray(k * e * (0.5 + 0.5 * np.sin(math.sqrt(3.0) * np.log(np.abs(e) + 1e-12))))


def hump(e: np.ndarray, k: np.ndarray, period: int) -> np.ndarray:
    """Straight at rest, largest at 1, falls to 0 far out: slopes from ``-0.45 k`` to ``k``."""
    return np.asarray(k * e * np.exp(-0.5 * e * e))


def switching(low: int, high: int) -> Law:
    """A gain that is 0 for ``low`` periods and ``k`` for ``high``, over and over."""

    def law(e: np.ndarray, k: np.ndarray, period: int) -> np.ndarray:
        return np.asarray(k * e if period % (low + high) >= low else 0.0 * e)

    return law


def scattered(e: np.ndarray, k: np.ndarray, period: int) -> np.ndarray:
    """A gain that is 0 or ``k`` at random, alike in every trial."""
    return np.asarray(k * e if np.random.default_rng(period).random() < 0.6 else 0.0 * e)


STATIC: dict[str, Law] = {"straight": straight, "waves": waves, "bands": bands}
"""In the sector, of any slope."""
MONOTONE: dict[str, Law] = {
    "straight": straight, "saturation": saturation, "dead zone": dead_zone, "slope-limited": slope_law,
}  # fmt: skip
"""In the sector and the slope sector."""
FALLING: dict[str, Law] = {"rolling": rolling, "hump": hump}
"""In the sector, of slopes up to 1.5 of its bound, and not monotone: neither Tsypkin's nor Zames and Falb's."""
VARYING: dict[str, Law] = {
    "switching 3+3": switching(3, 3), "switching 8+8": switching(8, 8), "switching 20+12": switching(20, 12),
    "scattered": scattered,
}  # fmt: skip


def stepped(
    plants: list[Plant],
    law: Law,
    k: np.ndarray,
    low: np.ndarray | float = 0.0,
    periods: int = PERIODS,
    seed: int = 1,
    drive: np.ndarray | None = None,
) -> np.ndarray:
    """Errors of the loops closed with ``low e + law``, from :data:`STARTS` states each; periods by plants by starts.

    ``k`` is one bound a plant. Starts are of all sizes, 0.01 to 100 in the unit of the laws. ``drive`` is a command.
    """
    count = len(plants)
    draw = np.random.default_rng(seed)
    a = np.array([p.a for p in plants])
    b = np.array([p.b for p in plants])[:, :, None]
    c = np.array([p.c for p in plants])[:, None, :]
    late = np.array([p.delay for p in plants])
    most = int(late.max())
    sizes = np.geomspace(0.01, 100.0, STARTS)
    x = draw.normal(size=(count, 3, STARTS)) * sizes / np.abs(c).max(axis=2, keepdims=True)
    sent = draw.normal(size=(most + 1, count, STARTS)) * sizes
    upper, floor = np.asarray(k, dtype=float)[:, None], np.broadcast_to(np.asarray(low, dtype=float), (count,))[:, None]
    seen = np.empty((periods, count, STARTS))
    rows = np.arange(count)
    for n in range(periods):
        e = -(c @ x)[:, 0, :]
        if drive is not None:
            e = e + drive[n]
        seen[n] = e
        sent[n % (most + 1)] = floor * e + law(e, upper - floor, n)
        x = a @ x + b * sent[(n - late) % (most + 1), rows][:, None, :]
    return seen


def growth(seen: np.ndarray) -> np.ndarray:
    """By what factor the last tenth of a trial exceeds its fifth, the worst start of each plant.

    Below 1 where the motion dies out, 1 in a limit cycle; what has fallen by 1e-12 counts as having died out.
    """
    tenth = len(seen) // 10
    with np.errstate(over="ignore", invalid="ignore"):
        first, middle, last = (np.abs(seen[k * tenth : (k + 1) * tenth]).max(axis=0) for k in (0, 4, 9))
        found = np.where(np.isfinite(last), last / np.maximum(middle, 1e-12 * first), np.inf)
    return np.asarray(np.nan_to_num(found, nan=np.inf, posinf=np.inf).max(axis=1))


@dataclass(frozen=True)
class Inside:
    """Trials inside proved sectors."""

    trials: int
    worst: float
    """Largest :func:`growth` of all."""
    where: str
    """Which law and criterion that was."""
    apart: float
    """The same of the distance between motions from different starts under one command."""


@lru_cache(maxsize=4)
def inside(count: int = COUNT, seed: int = SEED) -> Inside:
    """Every law of its kind at :data:`BELOW` of the bound of every proved sector, and pairs of motions under a command.

    Jury and Lee's bound is below the Nyquist limit and the laws' slopes are at most :data:`STEEP` of their gain, so
    they keep to its bound of the slope.
    """
    plants = random_plants(count, seed)
    found = gaps(count, seed)
    circle, tsypkin, jury_lee, shifted, low = (
        np.array([getattr(g, name) for g in found]) for name in ("circle", "tsypkin", "jury_lee", "shifted", "low")
    )
    asked: list[tuple[str, dict[str, Law], np.ndarray, np.ndarray | float, int]] = [
        ("circle", VARYING | STATIC, BELOW * circle, 0.0, PERIODS),
        ("circle from above 0", VARYING | STATIC, low + BELOW * (shifted - low), low, PERIODS),
        ("Tsypkin", MONOTONE, BELOW * tsypkin, 0.0, PERIODS),
        ("Jury-Lee", MONOTONE | FALLING, BELOW * jury_lee, 0.0, LONG),
    ]
    worst, where, trials = 0.0, "", 0
    for criterion, laws, k, floor, periods in asked:
        for name, law in laws.items():
            factor = float(growth(stepped(plants, law, k, floor, periods)).max())
            trials += count * STARTS
            if factor >= worst:
                worst, where = factor, f"{name}, {criterion}"
    return Inside(trials, worst, where, max(converged(plants, law, BELOW * circle) for law in MONOTONE.values()))


def converged(plants: list[Plant], law: Law, k: np.ndarray) -> float:
    """:func:`growth` of how far the motions from all starts are apart under one command: constant and two sines."""
    t = np.arange(PERIODS)[:, None] * PERIOD_S
    drive = 3.0 + 5.0 * np.sin(1.3 * t) + 1.0 * np.sin(17.0 * t)
    seen = stepped(plants, law, k, drive=drive[:, :, None])
    return float(growth(seen[:, :, 1:] - seen[:, :, :1]).max())


def simulated_limit(plants: list[Plant], nyquist: np.ndarray) -> np.ndarray:
    """The gain at which a simulated loop neither grows nor decays, from its growth 1 % below and above ``nyquist``.

    NaN where the limit does not lie between the two.
    """
    rates = []
    for part in (1.0 - NEAR, 1.0 + NEAR):
        seen = np.abs(stepped(plants, straight, part * nyquist))
        spans = [seen[i : i + PERIODS // 4].max(axis=0) for i in (PERIODS // 2, 3 * PERIODS // 4)]
        rates.append(np.log(spans[1] / spans[0]).max(axis=1))
    low, high = rates
    between = (low < 0.0) & (high > 0.0)
    return np.asarray(np.where(between, nyquist * (1.0 - NEAR + 2.0 * NEAR * low / (low - high)), np.nan))


def switching_limit(loop: LinearLoop, top: float, most: int = 14) -> float:
    """The smallest gain ``k`` for which some switching between 0 and ``k``, each for up to ``most`` periods, grows."""

    def radius(k: float) -> float:
        closed = loop.a - k * loop.b @ loop.c
        zero = [np.linalg.matrix_power(loop.a, n) for n in range(most + 1)]
        full = [np.linalg.matrix_power(closed, n) for n in range(1, most + 1)]
        both = np.array([low @ high for low in zero for high in full])
        return float(np.abs(np.linalg.eigvals(both)).max())

    low, high = 0.0, top * (1.0 + 1e-6)
    for _ in range(14):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if radius(middle) >= 1.0 else (middle, high)
    return high


@dataclass(frozen=True)
class Gap:
    """One plant: limits of the gain; ``circle``, ``tsypkin`` and ``jury_lee`` are proved for the sector from 0,
    ``shifted`` from ``low``.
    """

    delay: int
    nyquist: float
    simulated: float
    circle: float
    tsypkin: float
    jury_lee: float
    """For slopes of up to :data:`STEEP` of the Nyquist limit."""
    low: float
    shifted: float
    switching: float

    @property
    def varying_gap(self) -> float:
        """What is proved for gains that vary, in parts of what a switching gain was found to break."""
        return self.circle / self.switching

    @property
    def static_gap(self) -> float:
        """What is proved for fixed monotone laws, in parts of the Nyquist limit, which breaks every such proof."""
        return self.tsypkin / self.nyquist

    @property
    def steep_gap(self) -> float:
        """What is proved for fixed laws of bounded slope that may fall, in parts of the Nyquist limit."""
        return self.jury_lee / self.nyquist

    @property
    def shifted_gap(self) -> float:
        """What is proved from ``low`` upwards, in parts of the Nyquist limit."""
        return self.shifted / self.nyquist


@lru_cache(maxsize=4)
def gaps(count: int = COUNT, seed: int = SEED) -> tuple[Gap, ...]:
    """What is proved and what is true, plant by plant."""
    plants = random_plants(count, seed)
    loops = [loop_of(p) for p in plants]
    nyquist = np.array([loop.gain_limit() for loop in loops])
    simulated = simulated_limit(plants, nyquist)
    return tuple(
        Gap(
            plant.delay, float(top), float(seen), _proved(loop, 0.0, "circle"), _proved(loop, 0.0, "tsypkin"),
            _proved(loop, 0.0, "jury-lee", float(STEEP * top)), float(LOWER * top),
            _proved(loop, float(LOWER * top), "circle"), switching_limit(loop, float(top)),
        )
        for plant, loop, top, seen in zip(plants, loops, nyquist, simulated, strict=True)
    )  # fmt: skip


def _proved(loop: LinearLoop, k1: float, form: Form, slope: float | None = None) -> float:
    """Jury and Lee's has no lower bound of the slope: the one that is passed is not used."""
    found = largest_proved(loop, k1, form, None if slope is None else (-slope, slope))
    return float("nan") if found.limit is None else found.limit


def gap_table(count: int = COUNT, seed: int = SEED) -> str:
    """The gap between certificate and truth as text, a line a plant."""
    head = (
        "plant delay  Nyquist  simulated |  circle  switching  proved/true | Tsypkin  proved/true | Jury-Lee  "
        f"proved/true | circle from {LOWER:g} of it  proved/true"
    )
    rows = [head, "-" * len(head)]
    for i, g in enumerate(gaps(count, seed)):
        rows.append(
            f"{i:5d} {g.delay:5d} {g.nyquist:8.4f} {g.simulated:10.4f} | {g.circle:7.4f} {g.switching:10.4f} "
            f"{g.varying_gap:12.3f} | {g.tsypkin:7.4f} {g.static_gap:12.3f} | "
            f"{g.jury_lee:8.4f} {g.steep_gap:12.3f} | {g.shifted:18.4f} {g.shifted_gap:12.3f}"
        )
    return "\n".join(rows)
