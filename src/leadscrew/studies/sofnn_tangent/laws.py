"""What only this study computes: facts of Table 1, areas of Figure 4, angles folded as the paper defines them.

Table 1 is ``P`` in levels by ``EC`` (rows) and ``E`` (columns), both -6 to 6. An *odd* table has ``P(-E, -EC) = -P``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from leadscrew.fuzzy.partition import Partition
from leadscrew.neural.inference_net import CENTRES, LABELS
from leadscrew.neural.performance import GOLDEN, ROUNDED, TABLE, correction

if TYPE_CHECKING:
    from leadscrew.kernel.block import Block

SETS = Partition(tuple(CENTRES.tolist()), LABELS)
LEVELS_PER_DEG = 6.0 / 90.0
DEG_PER_LEVEL = 15.0 / 6.0


# ---- Table 1
class Pair(NamedTuple):
    """Two cells that an odd table would have of opposite sign."""

    ec: int
    e: int
    value: float
    mirror: float
    """At ``-E``, ``-EC``."""


def even_part(table: np.ndarray) -> np.ndarray:
    """What no odd network can know of a table."""
    return 0.5 * (table + table[::-1, ::-1])


def uneven_pairs(table: np.ndarray) -> list[Pair]:
    """Pairs of cells that do not cancel; one of each pair, ``EC > 0`` or ``EC = 0`` and ``E > 0``."""
    cells = [(ec, e) for ec in range(7) for e in range(-6, 7) if ec > 0 or e > 0]
    pairs = [Pair(ec, e, float(table[ec + 6, e + 6]), float(table[6 - ec, 6 - e])) for ec, e in cells]
    return [pair for pair in pairs if pair.value + pair.mirror != 0.0]


def rises(table: np.ndarray, axis: int) -> int:
    """How often the correction rises from one cell to the next along EC (0) or E (1); a monotone one never does."""
    return int(np.count_nonzero(np.diff(table, axis=axis) > 0.0))


def dead_zone_deg() -> float:
    """Smallest deviation with a correction when levels are whole numbers, to 0.01 deg; found by trying."""
    tried = np.arange(0.0, 20.0, 0.01)
    corrected = [correction(ROUNDED, TABLE, GOLDEN, LEVELS_PER_DEG * e, 0.0) for e in tried]
    return float(tried[np.flatnonzero(corrected)[0]])


# ---- Figure 4
class Area(NamedTuple):
    """An area of Figure 4: E and EC at the peaks of the sets that the text names, and its P."""

    roman: str
    e: float
    ec: float
    says: str

    def __str__(self) -> str:
        return f"area {self.roman} (E = {self.e:g}, EC = {self.ec:g})"


AREAS = {"i": Area("I", -4.0, 2.0, "PS"), "ii": Area("II", 2.0, 2.0, "NS"), "iii": Area("III", 2.0, -2.0, "ZO")}


def sets_of(value: float) -> str:
    """The set to which a level belongs most; both where two have the same membership."""
    winner = SETS.winner(value)
    return f"{LABELS[winner.index]} or {LABELS[winner.index + 1]}" if winner.tied else LABELS[winner.index]


def membership(value: float, label: str) -> float:
    """How much a level belongs to a set."""
    return float(SETS.memberships(value)[LABELS.index(label)])


def passed_areas(e: np.ndarray, ec: np.ndarray) -> list[str]:
    """The areas of Figure 4 that a response passes, in their order: by the signs of the deviation and of its rate."""
    passed: list[str] = []
    for x, dx in zip(e, ec, strict=True):
        if abs(x) < 0.02 or abs(dx) < 1e-4:
            continue
        area = {(False, True): "I", (True, True): "II", (True, False): "III"}.get((x > 0.0, dx > 0.0), "")
        if area and (not passed or passed[-1] != area):
            passed.append(area)
    return passed


# ---- angles
def folded(heading: np.ndarray) -> np.ndarray:
    """The acute angle to the horizontal, -90 to 90 deg: what the paper calls the tangential angle."""
    return (np.asarray(heading) + 90.0) % 180.0 - 90.0


def jumps(angle: np.ndarray) -> int:
    """How often an angle jumps by more than 90 deg from one sample to the next."""
    return int(np.count_nonzero(np.abs(np.diff(angle)) > 90.0))


# ---- the fuzzy system that the rules are trained on
def fixed_fuzzy() -> Block:
    """Mamdani's inference as a controller at the paper's scales; the sign is that of the block, command minus reading.

    Levels of 15 deg, and of 15 deg a sample; an offset of 2.5 deg a level.
    """
    from leadscrew.fuzzy.block import controller
    from leadscrew.neural.samples import reasoning_system

    inputs = {"E": ("error", -LEVELS_PER_DEG), "EC": ("change", -LEVELS_PER_DEG)}
    return controller(reasoning_system(), inputs, output_scale=DEG_PER_LEVEL, unit="deg", drive="position")
