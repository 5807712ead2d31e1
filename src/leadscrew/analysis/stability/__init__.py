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

from leadscrew.util.lazy_exports import exports

__getattr__, __dir__, __all__ = exports(__name__, __file__)
