"""The plain fuzzy controller of the comparison: Mamdani's, with the rules that the networks start from.

Error and change in levels (6 levels are 90 degrees, and 90 degrees a sample), seven triangles each, 49 rules, minimum
and maximum, centroid over 241 points; a level of the output is 2.5 degrees. The rules are those of a positive error
that wants a positive offset: the block's error is command minus reading, the opposite of the paper's.

The paper compares with fixed rules and gives none; section 7 of the digest of the study ("fixed fuzzy literal").
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

from leadscrew.kernel.block import Block

if TYPE_CHECKING:
    from leadscrew.fuzzy.system import System

SETS = ("NB", "NM", "NS", "ZO", "PS", "PM", "PB")
LEVELS_PER_DEG = 6.0 / 90.0
DEG_PER_LEVEL = 2.5
POINTS = 241


def rules() -> list[str]:
    """49 rules: the set of the output is that of the error plus that of the change, at the ends the outermost."""
    return [
        f"if e is {SETS[i]} and de is {SETS[j]} then d is {SETS[min(max(i + j - 3, 0), 6)]}"
        for i in range(7)
        for j in range(7)
    ]


def system() -> System:
    """The fuzzy system, in levels."""
    from leadscrew.fuzzy.build import mamdani, triangles
    from leadscrew.fuzzy.system import Input, Output

    sides = [Input(name, -6.0, 6.0, triangles(SETS, -6.0, 6.0)) for name in ("e", "de")]
    out = Output("d", -6.0, 6.0, triangles(SETS, -6.0, 6.0), resolution=POINTS)
    return mamdani("fixed_fuzzy", sides, out, rules(), integration="midpoint")


@lru_cache(maxsize=1)
def fixed_fuzzy() -> Block:
    """The controller; its output is an offset in degrees."""
    from leadscrew.fuzzy.block import controller

    inputs = {"e": ("error", LEVELS_PER_DEG), "de": ("change", LEVELS_PER_DEG)}
    return controller(system(), inputs, output_scale=DEG_PER_LEVEL, unit="deg", drive="position")
