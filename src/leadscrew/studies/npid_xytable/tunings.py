"""Gains of the study ``npid_xytable``, by the names of its controllers: for the table at 2 kHz with 0.775 ms of delay.

``paper.*`` is as printed: the error inside the gain in mm, where the gain never leaves 1. ``corrected.*`` has it in um,
the one change that makes Table I mean something. ``ours.*`` are for comparison. A command and a feedback in mm, an
output in V.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from leadscrew.controllers import (
    adaptive_resonant,
    cascade_ppi,
    dead_zone_inverse,
    input_dob,
    inverse_feed_forward,
    learned_feed_forward,
    npid,
    npid_after,
    npid_slope,
    npid_split,
    pid,
    repetitive,
    resonant,
    tracking_differentiator,
)
from leadscrew.controllers._response import PlantModel
from leadscrew.kernel.block import Block

XY_TABLE = PlantModel(69380.0, 144.8, 166.3, 0.775e-3)
"""What our controllers believe of the table: equation (1), and a dead time that the paper does not give."""
INVERSE: dict[str, Any] = {
    "gain": XY_TABLE.gain,
    "damping": XY_TABLE.damping,
    "stiffness": XY_TABLE.stiffness,
    "ahead_s": 1.025e-3,
}
"""The same for feed-forward; the middle of the held output lies the dead time and half a period behind the sample."""

table_pid = replace(pid(kp=1.32, ki=0.000825, kd=0.006805), unit="V", drive="voltage", full_scale=10.0)
"""The PID with the gains of Table I: Ki / Kp = 1/1600 s, nearly a PD."""
table_cascade = replace(
    cascade_ppi(kpos=193.97439, kvp=0.006805, kvi=4.2531388e-6), unit="V", drive="voltage", full_scale=10.0
)
"""Table I as a cascade: the same output, term by term."""

SCALED = 2.265
"""What the gains of Table I may all be multiplied by under the circle criterion in L*."""
PID_159 = table_pid(kp=1.17, ki=175.5, kd=0.00433)
"""A PID with a peak of sensitivity of 1.59."""
PID_185 = table_pid(kp=1.6533, ki=248.0, kd=0.00533)
"""A PID with a peak of sensitivity of 1.85, that of Table I."""


def fed_forward(inner: Block, share: float = 1.0) -> Block:
    """The controller with feed-forward of the table as it is believed."""
    return inverse_feed_forward(inner, share=share, **INVERSE)


TUNINGS: dict[str, Block] = {
    "paper.pid": table_pid,
    "ours.pid_ms_159": PID_159,
    "ours.pid_ms_185": PID_185,
    "paper.npid_mm": npid(error_unit_per_mm=1.0),
    "paper.npid_mm_clipped": npid(error_unit_per_mm=1.0, clip_error=True),
    "corrected.npid_um": npid,
    "corrected.npid_um_clipped": npid(clip_error=True),
    "ours.pid_scaled": table_pid(
        kp=SCALED * table_pid.params.kp, ki=SCALED * table_pid.params.ki, kd=SCALED * table_pid.params.kd
    ),
    # The gains of Table I under 2.2, which lies below the 2.265 of the circle criterion for that loop; the gains of
    # pid_ms_159 with a gain margin of 3.70 / 1.5. es_um is one count of the scale in both: a table at rest shows errors
    # of a count or less, and they are to see a gain near 1. With half of it or less the output at rest changes by 25 to
    # 50 % more from period to period than under the plain PID, with one count by 13 % (second tuning).
    "ours.npid_slope": npid_slope,
    "ours.npid_slope_159": npid_slope(kp=1.17, ki=175.5, kd=0.00433, k=1.5, es_um=0.5),
    "ours.npid_after": npid_after,
    # For a scale of 0.5 um, rounded by hand: Ms <= 1.6 at every error, 0.5 mV of change from sample to sample at rest.
    # `leadscrew design rejection npid_split` tunes the law.
    "ours.npid_split": npid_split,
    # All of the feed-forward around the printed gains, 90 % around ours. best: of all plain PIDs with a peak of
    # sensitivity of 1.60 or 1.85 the one that lets the least of a disturbance through at the five lines of Table II
    # (their mean); noise and other lines are not weighed.
    "ours.pid_ff": fed_forward(table_pid),
    "ours.npid_ff": fed_forward(npid),
    "ours.pid_159_ff": fed_forward(PID_159, 0.9),
    "ours.pid_185_ff": fed_forward(PID_185, 0.9),
    "ours.pid_best_160_ff": fed_forward(table_pid(kp=1.0576, ki=241.8, kd=0.0052865), 0.9),
    "ours.pid_best_185_ff": fed_forward(table_pid(kp=1.3893, ki=428.3, kd=0.0066635), 0.9),
    # Of all cascades with a peak of sensitivity of 1.59 the one that lets the least of a disturbance through at the
    # five lines of Table II (their mean). Both zeros of its PID coincide: the search ends at the edge of what a cascade
    # can be. pid_ms_159 has complex zeros, and no cascade is equal to it.
    "ours.cascade": fed_forward(table_cascade(kpos=154.57, kvp=0.003881, kvi=0.59988), 0.9),
    "ours.pid_dob_60": input_dob(table_pid, bandwidth=60.0, model=XY_TABLE),
    "ours.pid_dob_100": input_dob(table_pid, bandwidth=100.0, model=XY_TABLE),
    "ours.pid_dob_150": input_dob(table_pid, bandwidth=150.0, model=XY_TABLE),
    # With feed-forward the spindle lines are placed by inner.spindle_hz.
    "ours.resonant": resonant(table_pid, strength=2.0, model=XY_TABLE),
    "ours.resonant_box": resonant(PID_159, model=XY_TABLE),
    "ours.resonant_full": fed_forward(resonant(PID_159, model=XY_TABLE), 0.9),
    "ours.resonant_full_185": fed_forward(resonant(PID_185, model=XY_TABLE), 0.9),
    # resonant_full that finds the spindle's speed within 3 % of inner.spindle_hz.
    "ours.resonant_adaptive": fed_forward(adaptive_resonant(resonant(PID_159, model=XY_TABLE), model=XY_TABLE), 0.9),
    # For a motion of 0.7 Hz; its contraction is 0.30 at most.
    "ours.repetitive": fed_forward(repetitive(PID_159), 0.9),
    # 20 mV of friction believed.
    "ours.learned": learned_feed_forward(PID_185),
    # For a scale of 0.5 um: h so large that the peak of sensitivity grows from 1.59 to 1.83, that of Table I; r so
    # large that the sudden start of a 1 mm sine of 0.7 Hz does no harm.
    "ours.pid_td": tracking_differentiator(PID_159, r_mm_s2=5000.0, h_s=0.00065),
    "ours.pid_dead_zone": dead_zone_inverse(table_pid, width=0.02, softness=1e-3),
}
"""By name; what a search has tuned is in the folder ``tuned``."""
