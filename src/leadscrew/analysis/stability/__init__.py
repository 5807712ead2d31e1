"""Stability of loops with a static nonlinearity, as they are sampled, delayed and exported.

=====================================================  =================================================================
:mod:`leadscrew.analysis.stability.loop`               linear loops of transfer functions or of a built loop
:mod:`leadscrew.analysis.stability.lure`               a controller as a static map in front of a linear one
:mod:`leadscrew.analysis.stability.margins`            margins of gain, phase and delay, peaks of sensitivity
:mod:`leadscrew.analysis.stability.criteria`           circle, Tsypkin, Jury-Lee, Zames-Falb, Popov on a frequency grid
:mod:`leadscrew.analysis.stability.lmi`                the same as matrix inequalities; under command and load
:mod:`leadscrew.analysis.stability.harmonic_balance`   limit cycles: describing function, and all harmonics
:mod:`leadscrew.analysis.stability.switching`          gains that switch: the worst pattern
:mod:`leadscrew.analysis.stability.certificate`        the result: statement, grade, margin, grid and warnings
:mod:`leadscrew.analysis.stability.certification`      a whole loop: every criterion that applies, one verdict
=====================================================  =================================================================
"""

from leadscrew.util.lazy_exports import exports

__getattr__, __dir__, __all__ = exports(__name__, __file__)
