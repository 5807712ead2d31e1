"""The proof of a nonlinear law in two paths, :obj:`leadscrew.controllers.npid_split`.

With the quiet path closed, the rest is a Lur'e loop around ``large``, the part of the error that goes to the difference
of the paths; its slope lies in [0, 1] (:func:`around_large`).
"""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

import numpy as np

from leadscrew.analysis.stability.certificate import Certificate
from leadscrew.analysis.stability.linear import LinearLoop
from leadscrew.analysis.stability.lmi import driven
from leadscrew.controllers._npid_split import NPIDSplitParams, NPIDSplitState, npid_split, paths
from leadscrew.kernel.block import Block, controller
from leadscrew.kernel.parameters import Ge, Le
from leadscrew.studies.lab import Lab, measure
from leadscrew.studies.npid_xytable.controllers import CONTROLLERS
from leadscrew.studies.npid_xytable.cutting import BOX
from leadscrew.studies.npid_xytable.rejection import opened

SPLIT = npid_split
SHARES = np.linspace(0.0, 1.0, 11)
"""Slopes of ``large`` at which the loop is linearised."""


class SharedParams(NamedTuple):
    """The two paths, and which share of the error the firm one gets."""

    law: NPIDSplitParams = NPIDSplitParams()
    share: Annotated[float, Ge(0), Le(1)] = 0.5


@controller(SharedParams(), NPIDSplitState())
def shared(p, s, command, feedback, dt):
    """The two paths with fixed shares of the error: what npid_split is around one error."""
    error = command - feedback
    return paths(p.law, s, (1.0 - p.share) * error, p.share * error, dt)


def frozen(block: Block, share: float, changes: dict[str, float] | None = None) -> LinearLoop:
    """The loop of an npid_split where the slope of ``large`` is ``share``."""
    return opened(shared.using(**_law(block), share=float(share)), changes)


def around_large(block: Block, changes: dict[str, float] | None = None) -> LinearLoop:
    """The loop from ``large`` (and its ``-small``) to the position: quiet path closed, ``e = -G large(e)``.

    From the loops at shares of 1/4 and 3/4: their input columns are linear in the share.
    """
    low, high = frozen(block, 0.25, changes), frozen(block, 0.75, changes)
    if not (np.array_equal(low.a, high.a) and np.array_equal(low.c, high.c)):
        raise ValueError("the loop's states depend on the share")
    firm_less_quiet = 2.0 * (high.b - low.b)
    quiet = low.b - 0.25 * firm_less_quiet
    return LinearLoop(low.a - quiet @ low.c, firm_less_quiet, low.c, low.d, low.dt, name="L* with npid_split",
                      notes=low.notes, from_blocks=True)  # fmt: skip


def box_plants() -> list[dict[str, float]]:
    """The twelve plants of the robustness box, each as changes of parameters."""
    return [dict(zip(BOX, map(float, values), strict=True)) for values in zip(*BOX.values(), strict=True)]


def _law(block: Block) -> dict[str, Any]:
    p = block.params
    both = {"quiet": p.quiet, "firm": p.firm}
    found = {f"law.{path}.{name}": value for path, own in both.items() for name, value in own._asdict().items()}
    return {**found, "law.es_um": p.es_um}


@measure
def proofs(lab: Lab) -> list[Certificate]:
    """ours.npid_split_rest under every command: on the nominal plant, on the four of the box with the largest gain."""
    law = CONTROLLERS["ours.npid_split_rest"]
    return [driven(around_large(law, plant), (0.0, 1.0)) for plant in ({}, *box_plants()[-4:])]
