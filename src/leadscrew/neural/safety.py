"""Whether a performance network would drive a learning loop the right way.

A self-organising controller adds ``P(E, EC)`` to what it did. Where ``P(E, 0)`` has the sign of ``E``, it makes a
deviation larger; where ``P(0, 0)`` is not 0, it learns until the deviation stands where ``P(E, 0) = 0``. A small error
in the cells of the table does not exclude that: between the cells nothing is asked. So:

    |P(0, 0)| < 0.02        E P(E, 0) < 0  on 0 < |E| <= 1.5        -1.5 <= dP/dE(0, 0) <= -0.4       RMSE <= 0.65

all in levels. The first three say that the loop goes the right way; the last that the network knows the table. They
are ours, for the study ``sofnn_tangent``. The range of the slope is for a table of slope -1, as
Table 1 is; for another one it is 0.4 to 1.5 times its slope.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from leadscrew.neural.performance import LEVELS, MOST, TABLE, Performance, surface

ORIGIN = 0.02
"""``|P(0, 0)|`` has to be below."""
NEAR = 1.5
"""The sign of ``P(E, 0)`` is asked for up to this ``|E|``."""
STEEPEST, FLATTEST = 1.5, 0.4
"""The slope at the origin has to lie between these multiples of the table's, which is -1 for Table 1."""
WORST_RMSE = 0.65
"""The root mean square of the differences to the table's cells may be this."""
POINTS = 301


@dataclass(frozen=True)
class Safety:
    """What was found, in levels."""

    rmse: float
    largest: float
    """Largest difference to a cell of the table."""
    exact: float
    """Share of the cells that are exact after rounding."""
    within_one: float
    """Share of the cells that are within one level after rounding."""
    origin: float
    """``P(0, 0)``."""
    slope: float
    """``dP/dE`` at the origin."""
    wrong_way: float
    """Largest ``P(E, 0) sign(E)`` on ``0 < |E| <= 1.5``; positive where the network drives the wrong way."""
    wrong_at: float
    """The ``E`` where it is."""
    wanted_slope: float = -1.0
    """The table's own slope at the origin."""

    @property
    def slope_range(self) -> tuple[float, float]:
        """What the slope at the origin may be."""
        return STEEPEST * self.wanted_slope, FLATTEST * self.wanted_slope

    @property
    def right_way(self) -> bool:
        """The loop would be driven the right way: all but the RMSE."""
        return not [text for text in self.failures() if not text.startswith("RMSE")]

    @property
    def accepted(self) -> bool:
        """All four conditions hold."""
        return not self.failures()

    def failures(self) -> list[str]:
        """The conditions that do not hold, a sentence each; empty for a safe network."""
        texts = []
        if not abs(self.origin) < ORIGIN:
            texts.append(f"P(0, 0) = {self.origin:.3f}, expected below {ORIGIN:g} in size")
        if not self.wrong_way < 0.0:
            texts.append(f"P({self.wrong_at:.2f}, 0) has the sign of E, expected the other one up to |E| = {NEAR:g}")
        low, high = self.slope_range
        if not low <= self.slope <= high:
            texts.append(f"slope dP/dE = {self.slope:.2f} at the origin, expected {low:g} to {high:g}")
        if not self.rmse <= WORST_RMSE:
            texts.append(f"RMSE = {self.rmse:.3f} level, expected {WORST_RMSE:g} or less")
        return texts

    def as_dict(self) -> dict[str, Any]:
        """The same as plain data, for JSON."""
        return {
            **asdict(self),
            "right_way": self.right_way,
            "accepted": self.accepted,
            "failures": self.failures(),
        }


def slope_at_origin(net: Performance) -> float:
    """``dP/dE`` at ``E = EC = 0``, exactly."""
    z = np.tanh(np.asarray(net.hidden_bias, float))
    by_x = float(np.sum(np.asarray(net.out) * (1.0 - z * z) * np.asarray(net.hidden)[:, 0]))
    if net.linear:
        return by_x / MOST
    y = float(np.sum(np.asarray(net.out) * z) + net.out_bias)
    return by_x * (1.0 - float(np.tanh(y)) ** 2)


def safety(net: Performance, table: np.ndarray = TABLE) -> Safety:
    """The conditions, measured."""
    e, ec = np.meshgrid(LEVELS, LEVELS)
    differences = surface(net, e, ec) - table
    rounded = np.abs(np.rint(surface(net, e, ec)) - np.rint(table))
    ahead = np.linspace(0.0, NEAR, POINTS)[1:]
    e_near = np.concatenate([-ahead[::-1], ahead])
    pushed = surface(net, e_near, 0.0) * np.sign(e_near)
    worst = int(np.argmax(pushed))
    return Safety(
        rmse=float(np.sqrt(np.mean(differences**2))),
        largest=float(np.abs(differences).max()),
        exact=float(np.mean(rounded == 0.0)),
        within_one=float(np.mean(rounded <= 1.0)),
        origin=float(surface(net, 0.0, 0.0)),
        slope=slope_at_origin(net),
        wrong_way=float(pushed[worst]),
        wrong_at=float(e_near[worst]),
        wanted_slope=slope_of_table(table),
    )


def slope_of_table(table: np.ndarray) -> float:
    """``dP/dE`` of a table at the origin, from its cells to either side."""
    return float(table[6, 7] - table[6, 5]) / 2.0


def table_faults(table: np.ndarray) -> list[str]:
    """Why no network for this table can be safe, a sentence each; empty for a good one."""
    values = np.asarray(table, float)
    if values.shape != (13, 13):
        return [f"its shape is {values.shape}, expected (13, 13)"]
    if not np.isfinite(values).all() or np.abs(values).max() > MOST:
        return ["a value of it is outside -6 to 6"]
    texts = []
    if abs(values[6, 6]) >= ORIGIN:
        texts.append(f"it corrects {values[6, 6]:g} at E = 0, EC = 0, expected 0")
    for column, wrong in ((5, "-1"), (7, "1")):
        if not values[6, column] * LEVELS[column] < 0.0:
            texts.append(f"it corrects {values[6, column]:g} at E = {wrong}, EC = 0, expected the other sign than E")
    return texts


def crossing(net: Performance) -> float:
    """The ``E`` (levels) of the zero crossing of ``P(E, 0)`` at which a learning loop comes to rest, ``nan`` if none.

    It rests where ``P`` falls through 0; of several such places the nearest to 0 is taken.
    """
    e = np.linspace(-MOST, MOST, 4801)
    p = surface(net, e, 0.0)
    falls = np.flatnonzero((p[:-1] >= 0.0) & (p[1:] < 0.0))
    if falls.size == 0:
        return float("nan")
    at = e[falls] + (e[1] - e[0]) * p[falls] / (p[falls] - p[falls + 1])
    return float(at[np.argmin(np.abs(at))])
