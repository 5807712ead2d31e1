"""The traditional fuzzy controller (TFC): 49 rules on the error and its change, in scaling factors.

    e(k)  = r(k) - y(k)                                   (13)
    ec(k) = e(k) - e(k-1),   ec(0) = 0                    (14)
    u(k)  = clip(u(k-1) + rules(e, ec), lower, upper)     incremental, (15) to (18)
    u(k)  = clip(rules(e, ec), lower, upper)              positional

The rules: :mod:`leadscrew.controllers._grey_fuzzy.surface`. Incremental for plants that hold their output by themselves
(force by the feed, spindle speed); positional where the plant integrates (depth by the radial speed). Clamping the
output is the anti-windup. ``S2`` refers to one period: keep it when the period stays.

Inside the rules the incremental law is a PI, ``du = Kp (e(k) - e(k-1)) + Ki e(k)`` with ``Kp = S3 / S2`` and
``Ki = S3 / S1`` a sample; outside, the increment saturates at 6 S3 and the approach takes about ``S1 / S2`` periods.

Source: the paper of the study ``grey_turning``, section 4. The paper prints no scaling factors: those here and in
:data:`~leadscrew.studies.grey_turning.tunings.TUNINGS` are the study's.

Bumpless start, incremental only: the output before is set so that the next one is the last one.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

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
from leadscrew.kernel.block import controller
from leadscrew.kernel.parameters import Doc, Unit


class TfcParams(NamedTuple):
    """Scaling factors, rules and limits."""

    error_scale: ErrorScale = 4.2
    change_scale: ChangeScale = 1.35
    output_scale: OutputScale = 0.00307
    rules: Rules = STANDARD
    inference: Inference = 0
    positional: Positional = False
    lower: Lower = 0.0
    upper: Upper = 1.0


class TfcState(NamedTuple):
    """What the controller remembers, and what it saw."""

    error: Annotated[float, Unit("N"), Doc("error, e")] = 0.0
    change: Annotated[float, Unit("N"), Doc("change of the error in one period, ec")] = 0.0
    output: Annotated[float, Unit("V"), Doc("output; increments add to it")] = 0.0
    started: Annotated[float, Doc("0 before the first period, then 1")] = 0.0


def ready(params: TfcParams, dt: float) -> Surface:
    """The parameters as the step reads them."""
    return ready_surface(params)


def align(params, command, feedback, output):
    """The state from which the next output is ``output``."""
    error = command - feedback
    return TfcState(error, 0.0, before_output(params, error, 0.0, output), 1.0)


@controller(TfcParams, TfcState, prepare=ready, align=align, unit="V", drive="voltage", full_scale=1.0)
def tfc(p, s, command, feedback, dt):
    """Fuzzy controller with 49 rules on the error and its change, in scaling factors; a voltage."""
    error = command - feedback
    change = (error - s.error) * s.started
    output = driven(p, s.output, error, change)
    return TfcState(error, change, output, 1.0), output
