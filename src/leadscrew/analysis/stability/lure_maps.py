"""The maps of the library's nonlinear controllers, for :func:`leadscrew.analysis.stability.lure.lure`.

===========  ================================================  =============================
npid         ``K = cosh(alpha min(|e|, e_max))``, clip or not  slope up to cosh x + x sinh x
npid_slope   ``1 + (k - 1)(1 - es/|e| atan(|e|/es))``          slope up to ``k``
npid_after   ``K`` of npid, behind the PID                     no static map
npid_split   ``large = e - es atan(e / es)``, a path of its    slope in [0, 1]
             own beside the PID of the small errors
===========  ================================================  =============================
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from leadscrew.analysis.stability.lure import ErrorMap
from leadscrew.controllers import _npid as npid
from leadscrew.controllers import _npid_after as npid_after
from leadscrew.controllers import _npid_slope as npid_slope
from leadscrew.controllers import _npid_split as npid_split
from leadscrew.controllers._npid_split import NPIDSplitParams, NPIDSplitState, paths
from leadscrew.kernel.block import Block, make
from leadscrew.kernel.errors import ValueRefused

LARGEST = 100.0
"""Of ``alpha e_max``: the gain is 1e43 there."""


def known() -> dict[type, Callable[[Any], ErrorMap]]:
    """The maps by the type of the controller's parameters."""

    def cosh(p: Any) -> ErrorMap:
        x = p.alpha * p.e_max
        if x > LARGEST:
            raise ValueRefused(
                f"alpha e_max = {x:g} (npid): cosh of it has no number; at most {LARGEST:g}. Is e_max in the unit of "
                "the error inside the gain?"
            )
        top, steepest = math.cosh(x), math.cosh(x) + x * math.sinh(x)
        clipped = bool(p.clip_error)
        note = (
            "the error itself is clipped: phi stays where it is beyond e_max, so the lower bound of the sector is 0, "
            "and a table that falls behind by more than e_max is pulled back with a constant effort only"
        )
        return ErrorMap(
            lambda e: npid.curve(p, e) / e if e else 1.0,
            lambda e: npid.slope(p, e),
            (0.0 if clipped else 1.0, top),
            (0.0 if clipped else 1.0, steepest),
            {"alpha": 0.0, "clip_error": False},
            p.e_max / p.error_unit_per_mm,
            p.error_unit_per_mm,
            notes=(note,) if clipped else (),
        )

    def limited(p: Any) -> ErrorMap:
        return ErrorMap(
            lambda e: npid_slope.curve(p, e) / e if e else 1.0,
            lambda e: npid_slope.slope(p, e),
            (1.0, p.k),
            (1.0, p.k),
            {"k": 1.0},
            p.es_um * npid_slope.MM_PER_UM,
            1.0 / npid_slope.MM_PER_UM,
        )

    def behind(p: Any) -> ErrorMap:
        note = (
            "the gain stands behind the PID: it is taken as a gain that varies in time between its bounds, for which "
            "the circle criterion holds, and Popov, Tsypkin and Jury-Lee do not; under a load or a following error "
            "nothing is proved beyond that the loop stays bounded"
        )
        return ErrorMap(
            lambda e: npid_after.gain(p, e),
            lambda e: npid_after.slope(p, e),
            (1.0, math.cosh(p.alpha * p.e_max)),
            None if p.alpha > 0.0 else (1.0, 1.0),
            {"alpha": 0.0},
            p.e_max / p.error_unit_per_mm,
            p.error_unit_per_mm,
            dependent=True,
            notes=(note,),
        )

    def parted(p: Any) -> ErrorMap:
        knee = p.es_um * npid_split.MM_PER_UM
        return ErrorMap(
            lambda e: 1.0 - npid_split.parted(p, e) / e if e else 0.0,
            lambda e: (e / knee) ** 2 / (1.0 + (e / knee) ** 2),
            (0.0, 1.0),
            (0.0, 1.0),
            scale_mm=knee,
            error_unit_per_mm=1.0 / npid_split.MM_PER_UM,
            notes=("the map is the part of the error that goes to the firm path; the quiet path is closed beside it",),
            shared=lambda share: _shared(p, share),
        )

    return {
        npid.NPIDParams: cosh,
        npid_slope.NPIDSlopeParams: limited,
        npid_after.NPIDAfterParams: behind,
        npid_split.NPIDSplitParams: parted,
    }


class Shared(NamedTuple):
    """Both paths, and which part of the error the firm one gets."""

    law: NPIDSplitParams
    share: float


def _shared(p: Any, share: float) -> Block:
    """The two paths of ``npid_split`` with a fixed share of the error for the firm one."""

    def shared(p, s, command, feedback, dt):
        error = command - feedback
        return paths(p.law, s, (1.0 - p.share) * error, p.share * error, dt)

    return make("controller", shared, Shared(p, share), NPIDSplitState(), name="npid_split with fixed shares")
