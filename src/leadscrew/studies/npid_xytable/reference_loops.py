"""Linear loops of the XY table with the gains of Table I: those of the paper's stability analysis, and of ours."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import lru_cache

from leadscrew.analysis.stability.linear import LinearLoop
from leadscrew.analysis.stability.loop import continuous_loop, pid_polynomials, sampled_loop
from leadscrew.kernel.block import Block
from leadscrew.kernel.loop import Loop
from leadscrew.plants import xy_table
from leadscrew.references import sine
from leadscrew.studies.npid_xytable.tunings import table_pid

TABLE_I = (table_pid.params.kp, table_pid.params.ki, table_pid.params.kd)
"""Kp, Ki, Kd of the XY table, Table I of Abdullah et al."""
FINEST = 10_000
"""Most steps in a period for a delay."""
PLANT = ((69380.0,), (1.0, 144.8, 166.3))
"""The XY table, equation (1), mm/V."""


def table_i_loop(dead_time: float = 0.0, filter_s: float = 0.0, name: str = "") -> LinearLoop:
    """The continuous loop of Table I with a dead time and a lag of the derivative, both in s."""
    return continuous_loop(*pid_polynomials(*TABLE_I, filter_s), *PLANT, dead_time, name)


def table_i_sampled(
    delay: float, period: float = 0.5e-3, controller: Block | None = None, name: str = ""
) -> LinearLoop:
    """The sampled loop of the XY table with an exact delay of any length, s: Table I unless given another controller.

    The period is cut into as many steps as the delay asks for, up to 10,000: a delay is exact to 1/10,000 of a period.
    """
    share = Fraction(delay / period).limit_denominator(FINEST)
    return sampled_loop(
        Loop(
            reference=sine, controller=controller or table_pid, plant=xy_table, period=period, metrics={}, name=name,
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
