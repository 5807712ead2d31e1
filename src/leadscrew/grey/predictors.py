"""All predictors behind one function: ``predicted(kind, window, horizon, reference, shift)``.

Before five samples, and wherever a model cannot be fitted, the prediction is the last value. ``kind`` is one of the
numbers below, so that a batch may mix predictors in one compiled loop; :data:`KINDS` has them by name.
"""

from __future__ import annotations

from typing import Literal, get_args

from leadscrew.grey.gm11 import ahead, as_printed, derivative, exponential, fit
from leadscrew.grey.others import dgm, fir, line, residual, two_point, verhulst
from leadscrew.grey.window import LENGTH, lifted

LAST, GM, GM_CLAMPED, GM_GUARDED, GM_SHIFTED, LINE, TWO_POINT, DGM = 0, 1, 2, 3, 4, 5, 6, 7
PRINTED, VERHULST, RESIDUAL, FIR, EXPONENTIAL, OFF_BY_ONE, DERIVATIVE = 8, 9, 10, 11, 12, 13, 14

GUARD = 0.5
"""Development coefficient beyond which ``GM_GUARDED`` does not believe the model."""

Kind = Literal[
    "last", "gm11", "gm11_clamped", "gm11_guarded", "gm11_shifted",
    "line", "two_point", "dgm11", "gm11_printed", "verhulst",
    "gm11_residual", "fir", "gm11_exponential", "gm11_off_by_one", "gm11_derivative",
]  # fmt: skip

KINDS = {name: number for number, name in enumerate(get_args(Kind))}
"""Numbers of the predictors by name.

==== ================= ==============================================================================================
0    last              the last value
1    gm11              GM(1,1)
2    gm11_clamped      GM(1,1) held between 0 and twice the reference
3    gm11_guarded      GM(1,1); the last value where abs(c) > 0.5
4    gm11_shifted      GM(1,1) of the samples raised by ``shift``, which is taken off again
5    line              least squares line through the last four samples
6    two_point         line through the last two samples
7    dgm11             DGM(1,1): its own least squares, no bias on exponentials
8    gm11_printed      equation (11) as printed, of the wrong sign: a documented error
9    verhulst          grey Verhulst model
10   gm11_residual     GM(1,1) plus GM(1,1) of its residuals
11   fir               the fixed filter that GM(1,1) is near a set-point, one sample ahead whatever the horizon
12   gm11_exponential  GM(1,1) with the exact rate a = ln((2 + c) / (2 - c)) of its c
13   gm11_off_by_one   GM(1,1) one sample late: (9) and (10) differ by one index
14   gm11_derivative   the derivative of (9) in place of the difference
==== ================= ==============================================================================================
"""


def predicted(kind, window, horizon, reference, shift):
    """The signal ``horizon`` samples after the newest of the window.

    Args:
        kind: a number of :data:`KINDS`; any other one predicts the last value.
        window: :class:`~leadscrew.grey.window.Window`.
        horizon: samples, 1 for the next one.
        reference: what the signal should be, for ``gm11_clamped``; in the unit of the signal.
        shift: for ``gm11_shifted``; in the unit of the signal.
    """
    if kind == LAST or window.count < LENGTH:
        return window.y4
    if kind == LINE:
        return line(window, horizon)
    if kind == TWO_POINT:
        return two_point(window, horizon)
    if kind == FIR:
        return fir(window)
    if kind == DGM:
        return dgm(window, horizon)
    if kind == VERHULST:
        return verhulst(window, horizon)
    if kind == GM_SHIFTED:
        raised = lifted(window, shift)
        return ahead(raised, fit(raised), horizon) - shift
    grey = fit(window)
    if kind == PRINTED:
        return as_printed(window, grey, horizon)
    if kind == EXPONENTIAL:
        return exponential(window, grey, horizon)
    if kind == DERIVATIVE:
        return derivative(window, grey, horizon)
    if kind == OFF_BY_ONE:
        return ahead(window, grey, horizon - 1.0)
    value = ahead(window, grey, horizon)
    if kind == GM:
        return value
    if kind == GM_CLAMPED:
        return min(max(value, min(0.0, 2.0 * reference)), max(0.0, 2.0 * reference))
    if kind == GM_GUARDED:
        return window.y4 if abs(grey.c) > GUARD else value
    if kind == RESIDUAL:
        return value + residual(window, grey.c, grey.u, horizon)
    return window.y4
