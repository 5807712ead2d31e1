"""Stability of loops with a static nonlinearity, as they are sampled, delayed and exported.

=====================================================  =================================================================
:mod:`leadscrew.analysis.stability.loop`               linear loops of transfer functions or of a built loop
:mod:`leadscrew.analysis.stability.lure`               a controller as a static map in front of a linear one
:mod:`leadscrew.analysis.stability.margins`            margins of gain, phase and delay, peaks of sensitivity
:mod:`leadscrew.analysis.stability.popov`              Popov's criterion, continuous
:mod:`leadscrew.analysis.stability.circle`             the circle criterion, continuous and sampled
:mod:`leadscrew.analysis.stability.tsypkin`            Tsypkin's criterion, sampled, monotone nonlinearities
:mod:`leadscrew.analysis.stability.jury_lee`           Jury and Lee's criterion, sampled, slopes with a bound
:mod:`leadscrew.analysis.stability.zames_falb`         Zames and Falb's criterion, sampled, odd and monotone
:mod:`leadscrew.analysis.stability.driven`             the loop under load and on the move: the sector of the slope
:mod:`leadscrew.analysis.stability.lmi`                proofs by matrix inequalities, Zames and Falb's too
:mod:`leadscrew.analysis.stability.harmonic_balance`   limit cycles: describing function, and all harmonics
:mod:`leadscrew.analysis.stability.cycles`             a limit cycle, and what a prediction found
:mod:`leadscrew.analysis.stability.switching`          gains that switch: the worst pattern
:mod:`leadscrew.analysis.stability.certificate`        what a criterion says, with grade, margin, grid and warnings
=====================================================  =================================================================
"""

import sys
from types import ModuleType
from typing import TYPE_CHECKING, Any

from leadscrew.lazy import doors

if TYPE_CHECKING:
    from leadscrew.analysis.stability.certificate import Certificate
    from leadscrew.analysis.stability.circle import circle
    from leadscrew.analysis.stability.cycles import CyclePrediction, LimitCycle
    from leadscrew.analysis.stability.driven import driven
    from leadscrew.analysis.stability.harmonic_balance import describing_function, harmonic_balance, limit_cycles
    from leadscrew.analysis.stability.jury_lee import jury_lee
    from leadscrew.analysis.stability.linear import LinearLoop
    from leadscrew.analysis.stability.lmi import largest_proved, lmi_circle, lmi_popov, lmi_tsypkin, lmi_zames_falb
    from leadscrew.analysis.stability.loop import continuous_loop, reference_loops, sampled_loop
    from leadscrew.analysis.stability.lure import Lure, lure
    from leadscrew.analysis.stability.margins import Margins, margins
    from leadscrew.analysis.stability.popov import popov
    from leadscrew.analysis.stability.switching import worst_switching
    from leadscrew.analysis.stability.tsypkin import tsypkin
    from leadscrew.analysis.stability.zames_falb import zames_falb

__all__ = [
    "Certificate", "CyclePrediction", "LimitCycle", "LinearLoop", "Lure", "Margins", "circle", "continuous_loop",
    "describing_function", "driven", "harmonic_balance", "jury_lee", "largest_proved", "limit_cycles", "lmi_circle",
    "lmi_popov", "lmi_tsypkin", "lmi_zames_falb", "lure", "margins", "popov", "reference_loops", "sampled_loop",
    "tsypkin", "worst_switching", "zames_falb",
]  # fmt: skip

__getattr__, __dir__ = doors(
    globals(),
    {
        "certificate": "Certificate",
        "circle": "circle",
        "cycles": "CyclePrediction LimitCycle",
        "harmonic_balance": "describing_function limit_cycles harmonic_balance",
        "driven": "driven",
        "jury_lee": "jury_lee",
        "linear": "LinearLoop",
        "lmi": "largest_proved lmi_circle lmi_popov lmi_tsypkin lmi_zames_falb",
        "loop": "continuous_loop reference_loops sampled_loop",
        "lure": "Lure lure",
        "margins": "Margins margins",
        "popov": "popov",
        "switching": "worst_switching",
        "tsypkin": "tsypkin",
        "zames_falb": "zames_falb",
    },
)


class _Package(ModuleType):
    """The package, whose ``circle`` is the function, not the module of that name, whichever is imported first."""

    def __setattr__(self, name: str, value: Any) -> None:
        if isinstance(value, ModuleType) and name in __all__:
            value = getattr(value, name)
        super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package
