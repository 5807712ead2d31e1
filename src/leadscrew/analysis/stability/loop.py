"""Linear loops: from transfer functions (:func:`continuous_loop`) or from a built loop (:func:`sampled_loop`).

The loops of the XY table study's stability tables are in :func:`reference_loops`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from leadscrew.analysis.stability.linear import LinearLoop
from leadscrew.analysis.stability.sampled import sampled_loop
from leadscrew.kernel.errors import ValueRefused

if TYPE_CHECKING:
    from leadscrew.kernel.block import Block

TABLE_I = (1.32, 0.000825, 0.006805)
"""Kp, Ki, Kd of the XY table, Table I of Abdullah et al."""
FINEST = 10_000
"""Most steps in a period for a delay."""
PLANT = ((69380.0,), (1.0, 144.8, 166.3))
"""The XY table, equation (1), mm/V."""


def continuous_loop(
    controller_num: Sequence[float],
    controller_den: Sequence[float],
    plant_num: Sequence[float],
    plant_den: Sequence[float],
    dead_time: float = 0.0,
    name: str = "",
) -> LinearLoop:
    """The continuous loop of two transfer functions in ``s`` (highest power first) and a dead time in s.

    Raises:
        ValueRefused: a loop that is not proper, has a zero denominator, or feeds through with a dead time.
    """
    num = np.trim_zeros(np.polymul(controller_num, plant_num), "f")
    den = np.trim_zeros(np.polymul(controller_den, plant_den), "f")
    if len(den) == 0:
        raise ValueRefused(f"loop {name!r}: its denominator is zero")
    if len(num) > len(den):
        raise ValueRefused(
            f"loop {name!r}: its numerator's degree {len(num) - 1} exceeds the denominator's {len(den) - 1}; give the "
            "derivative a filter"
        )
    a, b, c, d = realised(num, den)
    return LinearLoop(a, b, c, d, None, float(dead_time), name)


def realised(num: np.ndarray, den: np.ndarray) -> tuple[np.ndarray, ...]:
    """Controllable companion form in time units that make the denominator's coefficients alike."""
    order = len(den) - 1
    num, den = np.asarray(num, dtype=float) / den[0], np.asarray(den, dtype=float) / den[0]
    num = np.concatenate([np.zeros(order + 1 - len(num)), num])
    d = num[0]
    rest = num[1:] - d * den[1:]
    sizes = [abs(den[k]) ** (1.0 / k) for k in range(1, order + 1) if den[k] != 0.0]
    fast = max(sizes, default=1.0)
    scaled = fast ** np.arange(1, order + 1)
    a = np.eye(order, k=-1)
    a[0, :] = -den[1:] / scaled
    b = np.zeros((order, 1))
    if order:
        b[0, 0] = fast
    return fast * a, b, (rest / scaled)[None, :], np.array([[d]])


def pid_polynomials(kp: float, ki: float, kd: float, filter_s: float = 0.0) -> tuple[list[float], list[float]]:
    """Numerator and denominator of ``kp + ki/s + kd s/(1 + filter_s s)``; without ``ki`` there is no pole at 0."""
    if ki == 0.0:
        return [kd + kp * filter_s, kp], [filter_s, 1.0]
    return [kd + kp * filter_s, kp + ki * filter_s, ki], [filter_s, 1.0, 0.0]


def table_i_loop(dead_time: float = 0.0, filter_s: float = 0.0, name: str = "") -> LinearLoop:
    """The continuous loop of Table I with a dead time and a lag of the derivative, both in s."""
    return continuous_loop(*pid_polynomials(*TABLE_I, filter_s), *PLANT, dead_time, name)


def table_i_sampled(
    delay: float, period: float = 0.5e-3, controller: Block | None = None, name: str = ""
) -> LinearLoop:
    """The sampled loop of the XY table with an exact delay of any length, s: Table I unless given another controller.

    The period is cut into as many steps as the delay asks for, up to 10,000: a delay is exact to 1/10,000 of a period.
    """
    from leadscrew.controllers._pid import pid
    from leadscrew.kernel.loop import Loop
    from leadscrew.plants._xy_table import xy_table
    from leadscrew.references._sine import sine

    share = Fraction(delay / period).limit_denominator(FINEST)
    return sampled_loop(
        Loop(
            reference=sine, controller=controller or pid, plant=xy_table, period=period, metrics={}, name=name,
            substeps=share.denominator, computation_delay=float(share) * period,
        )
    )  # fmt: skip


@lru_cache(maxsize=1)
def _reference_loops() -> dict[str, LinearLoop]:
    found = {
        "Lc": table_i_loop(1.2888e-3),
        "Lc_1200us": table_i_loop(1.2e-3),
        "Lc_1280us": table_i_loop(1.28e-3),
        "Lc_filter_200us": table_i_loop(1.086e-3, 0.2e-3),
        "Lc_filter_500us": table_i_loop(0.909e-3, 0.5e-3),
        "Lc_filter_1000us": table_i_loop(0.769e-3, 1e-3),
        "no_delay": table_i_loop(),
        "L_star": table_i_sampled(0.775e-3),
        "L0": table_i_sampled(0.0),
        "L_500us": table_i_sampled(0.5e-3),
        "L_1000us": table_i_sampled(1.0e-3),
        "L_4khz": table_i_sampled(1.0e-3, 0.25e-3),
    }
    return {name: replace(loop, name=name) for name, loop in found.items()}


def reference_loops() -> dict[str, LinearLoop]:
    """The loops of the study's stability tables, all with the gains of Table I.

    ``Lc``: continuous, 1.2888 ms of dead time, which puts the crossing at -0.4. ``L_star``: sampled at 2 kHz, backward
    difference, 0.775 ms of delay, the main test loop; ``L0`` the same without delay. The others: other delays
    (``Lc_1200us``, ``L_500us``), a filtered derivative and less dead time (``Lc_filter_500us``), no delay, and 4 kHz
    with 4 periods.
    """
    return dict(_reference_loops())


__all__ = [
    "LinearLoop", "continuous_loop", "pid_polynomials", "reference_loops", "sampled_loop", "table_i_loop",
    "table_i_sampled",
]  # fmt: skip
