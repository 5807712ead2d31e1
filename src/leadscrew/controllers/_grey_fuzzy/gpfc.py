"""The grey prediction fuzzy controller (GPFC): the rules of the TFC on the predicted error and its predicted change.

    yhat = prediction of y(k+1) from y(k-4) ... y(k)            GM(1,1), (2) to (12)
    ehat(k+1)  = r(k) - yhat
    echat(k+1) = ehat(k+1) - ehat(k)                            reading B, predicted_error, the analogue of (14)
    echat(k+1) = ehat(k+1) - e(k)                               reading A, measured_error
    u(k) = clip(u(k-1) + rules(ehat, echat), lower, upper)      as in leadscrew.controllers._grey_fuzzy.tfc

The paper says that the predicted error and change replace the measured ones, not which difference it takes: both
readings are here. Predictors: :mod:`leadscrew.grey.predictors`; ``gm11_clamped`` (held to 0 .. 2 r) is the default and
``gm11_printed`` the printed equation (11), whose sign is wrong. Before five samples the prediction is the
last sample; the change is 0 in the first period.

Near the set-point GM(1,1) is the fixed filter ``y(k) + y(k-1)/2 - y(k-3)/2``, so the law is linear there,

    A:  u = Ki sum e - (Kp + Ki) (y(k-1) + y(k-2)) / 2 + const
    B:  u = Ki sum e - Ki (y(k-1) + y(k-2)) / 2 - Kp (y(k) + y(k-1)/2 - y(k-3)/2) + const

a PI with another action of the output: A acts late and averaged, B adds a derivative.

Source: the paper of the study ``grey_turning``, sections 3 and 4; scaling factors as in the TFC, the study's.

Bumpless start, incremental only: the window is filled with the feedback of the moment.
"""

from __future__ import annotations

from typing import Annotated, Literal, NamedTuple

from leadscrew.controllers._grey_fuzzy.rule_tables import STANDARD
from leadscrew.controllers._grey_fuzzy.surface import (
    ChangeScale,
    ErrorScale,
    Inference,
    Lower,
    OutputScale,
    Positional,
    Rules,
    Surface,
    Upper,
    before_output,
    driven,
    ready_surface,
)
from leadscrew.grey.predictors import GM_CLAMPED, Kind, predicted
from leadscrew.grey.window import Window, filled, pushed
from leadscrew.kernel.block import controller
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit

Predictor = Annotated[Kind | int, Doc("prediction of the force, see leadscrew.grey.predictors")]
Reading = Annotated[
    Literal["predicted_error", "measured_error"] | int, Doc("from which error the predicted change counts")
]


class GpfcParams(NamedTuple):
    """Scaling factors, rules, limits, and the prediction."""

    error_scale: ErrorScale = 4.2
    change_scale: ChangeScale = 1.35
    output_scale: OutputScale = 0.00307
    rules: Rules = STANDARD
    inference: Inference = 0
    positional: Positional = False
    lower: Lower = 0.0
    upper: Upper = 1.0
    predictor: Predictor = GM_CLAMPED
    reading: Reading = 0
    horizon: Annotated[float, Gt(0), Le(20), Doc("periods ahead that are predicted")] = 1.0
    shift: Annotated[float, Unit("N"), Ge(0), Doc("added to the samples before GM(1,1), for the shifted one")] = 0.0


class Plan(NamedTuple):
    """The parameters as the step reads them."""

    surface: Surface
    predictor: int
    reading: int
    horizon: float
    shift: float


class GpfcState(NamedTuple):
    """What the controller remembers, and what it saw."""

    window: Window = Window()
    prediction: Annotated[float, Unit("N"), Doc("predicted output of the plant, yhat")] = 0.0
    error: Annotated[float, Unit("N"), Doc("predicted error, ehat")] = 0.0
    change: Annotated[float, Unit("N"), Doc("predicted change of the error, echat")] = 0.0
    output: Annotated[float, Unit("V"), Doc("output; increments add to it")] = 0.0
    started: Annotated[float, Doc("0 before the first period, then 1")] = 0.0


def ready(params: GpfcParams, dt: float) -> Plan:
    """The parameters as the step reads them."""
    return Plan(ready_surface(params), int(params.predictor), int(params.reading), params.horizon, params.shift)


def align(params, command, feedback, output):
    """The state from which the next output is ``output``: the window full of the feedback."""
    window = filled(feedback)
    seen = predicted(params.predictor, window, params.horizon, command, params.shift)
    change = feedback - seen if params.reading == 1 else 0.0
    before = before_output(params.surface, command - seen, change, output)
    return GpfcState(window, seen, command - seen, change, before, 1.0)


@controller(GpfcParams, GpfcState, prepare=ready, align=align, unit="V", drive="voltage", full_scale=1.0)
def gpfc(p, s, command, feedback, dt):
    """Fuzzy controller with 49 rules on the error that a grey model predicts, and its change; a voltage."""
    window = pushed(s.window, feedback)
    seen = predicted(p.predictor, window, p.horizon, command, p.shift)
    error = command - seen
    change = (error - (command - feedback if p.reading == 1 else s.error)) * s.started
    output = driven(p.surface, s.output, error, change)
    return GpfcState(window, seen, error, change, output, 1.0), output
