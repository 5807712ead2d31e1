"""Rule tables of two inputs with seven sets each: 7 by 7 consequent indices, -3 (NB) to 3 (PB).

Rows by the sets of the error, columns by those of its change, both from NB to PB. A positive consequent raises the
output. Table 1 of the paper is missing in the text that we have: :data:`STANDARD` is our choice, the diagonal table
that is usual since MacVicar-Whelan (1976). The other tables are for the study's tests of "roughly chosen rules".
"""

from __future__ import annotations

import numpy as np

SETS = ("NB", "NM", "NS", "ZO", "PS", "PM", "PB")
"""Names of the seven sets, of both inputs and of the output (Fig 3)."""
MOST = 3
"""Index of the outermost set; it lies at 6 scaling factors, ``2 MOST``."""

INDEX = np.arange(-MOST, MOST + 1)
SUM = INDEX[:, None] + INDEX[None, :]
"""``i + j``: what the diagonal table concludes before it is held."""


def held(indices: np.ndarray) -> np.ndarray:
    """Consequents rounded to whole sets and held to the outermost ones."""
    return np.clip(np.rint(indices), -MOST, MOST).astype(float) + 0.0


STANDARD = held(SUM)
"""``clip(i + j, -3, 3)``: the error and its change count the same."""
WEAK_EC = held(INDEX[:, None] + 0.34 * INDEX[None, :])
"""``clip(round(i + 0.34 j), -3, 3)``: the change of the error counts a third."""
DEAD_ZONE = np.where(np.abs(SUM) <= 1, 0.0, STANDARD)
"""The standard table with 0 where ``|i + j| <= 1``: nothing is done near the set-point."""
COARSE = held(np.sign(SUM) * 2.0 * np.ceil(np.abs(SUM) / 2.0))
"""Every other consequent left out, rounded away from 0: ZO, then NM and PM, then NB and PB."""
THREE_LEVELS = MOST * np.sign(SUM).astype(float)
"""Only NB, ZO and PB: a relay along the diagonal."""


def rough(seed: int, antisymmetric: bool = True) -> np.ndarray:
    """The standard table with -1, 0 or 1 added to every consequent at random, held to -3 and 3.

    Antisymmetric: the rule at ``(-i, -j)`` is the negative of that at ``(i, j)``, so (ZO, ZO) concludes ZO. Otherwise
    every rule errs on its own, and the set-point itself may be pushed away from.
    """
    noise = np.random.default_rng(seed).integers(-1, 2, size=STANDARD.shape).astype(float)
    if antisymmetric:
        last = noise.size // 2
        flat = noise.ravel()
        flat[last] = 0.0
        flat[last + 1 :] = -flat[:last][::-1]
        noise = flat.reshape(STANDARD.shape)
    return held(STANDARD + noise)


TABLES: dict[str, np.ndarray] = {
    "standard": STANDARD,
    "weak_ec": WEAK_EC,
    "dead_zone": DEAD_ZONE,
    "coarse": COARSE,
    "three_levels": THREE_LEVELS,
    "rough": rough(1),
}
"""The tables by name."""
