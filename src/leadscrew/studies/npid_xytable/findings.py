"""What the study found, in words around the numbers that it measured."""

from __future__ import annotations

from collections.abc import Sequence

from leadscrew.report.claim import Claim

TEXT = """
With the error in mm, as printed, the gain never leaves 1: NPID is the plain PID. Everything else here has the error
in um inside the gain, the one change that makes Table I mean something.

Under that change and random phases of the forces NPID cuts the fifteen rows by {random_mean_1:.3g} % in the mean at 1
mm ({random_mean_0:.3g} % without motion, {random_mean_15:.3g} % at 15 mm); the paper says 8 to 40 %. It makes hardly
a row worse, where 4 of the paper's 15 are: those need special phases, or scatter.

The mean reductions of Table II are {table2_mean_1000:.2f}, {table2_mean_2000:.3g} and {table2_mean_3000:.3g} % once
its five wrong percentages are worked out anew. Its lines are odd harmonics of {table2_base_hz:.3g} Hz at every
spindle speed: of the motion's reversals, not of the cutting force.

The printed plant never meets the negative real axis. An intercept of -0.4 needs 1.289 ms of dead time. With it
Popov's criterion proves K up to {sector_lc_popov_0:.4g}, not 2.5; only with K >= 1, which holds for a cosh, does it
reach {sector_lc_popov_1:.4g}.

Chatter is decided by the slope of the gain's curve, up to {slope_at_e_max:.3g}, not by the gain, 2.35: it begins
where the slope at the working point passes the gain margin of {margin_gm:.3g}, and retuning to 2.35 leaves
{chatter_size_10:.2g} um of it under a load of 10 um. Under 12 um rest is stable, and {chatter_size_12:.2g} um are left
only after a kick. Harmonic balance predicts the size to {chatter_m6_balance_size:.2g} %, a describing function to
{chatter_m6_describing_size:.2g} %.

A linear PID with integral action (Ms 1.59) is below both printed columns on all fifteen rows, at least
{m1_ours_pid_ms_159_least:.3g} % below PID; the best one of Ms 1.6 at least {m1_ours_pid_best_160_ff_least:.3g} %.
Price: near 33 Hz the first lets {let_through_33_hz:.2g} times as much through.

Resonators leave {m2_ours_resonant_box:.2g} um at most in Table II's rows on the twelve plants of the box, and an rms
error of {m3_rms_3000:.2g} um with the spindle's lines; {m7_box_rms:.2g} um where the spindle speed is 2 % off and
they find it themselves. A speed that swings by 2 % in 10 s they do not follow.

A nonlinear law that is proved under every load, as robust at every error and as quiet at rest as the best linear PID,
is at least {m4_rows:.2g} % below it on every row at 1 mm while the spindle cuts, and only {m4_rows_no_spindle:.2g} %
without the spindle's lines: it works by the size of the error. At 15 mm it makes a third harmonic of the following
error, and its smallest row is {m4_rows_15mm:.2g} %; with 90 % feed-forward to both laws {m4_rows_ff_15mm:.2g} %. All
this holds at a quiet operating point, 0.5 mV at rest; where the drive may be louder a linear PID is better than
either.

Against 150 mV of friction a learned feed-forward keeps {m5_friction_rms:.2g} um rms on 15 mm,
{m5_friction_rms_corners:.2g} um with friction and presliding 20 % and the gain 10 % off. Believing half or double the
presliding travel it does not keep 1 um.

A mode of 40 to 150 Hz between motor and table makes the four PIDs tried unstable that read the scale at the table
(Table I, 2.265 times it, both retuned ones); a notch, or the motor's encoder, is the way out.

Where our numbers are not the digest's: NPID's rows fall by {compared_corrected_npid_um_mean:.3g} % in the mean over
ninety runs (59 over six), and the worst row of NPID in the box is {box_corrected_npid_um_worst:.3g} um (0.861), both
by the draw of phases; its rows in mm at 15 mm change by up to {unit_rows_15mm:.2g} % (0.15); at rest under 12 um
chatter and quiet stand side by side, where the digest saw no hysteresis; the retuned PID of Ms 1.59 is no cascade, as
the digest has it.
"""
"""A paragraph a finding; names in braces are claims."""


def findings(claims: Sequence[Claim]) -> list[str]:
    """The findings for the report, a paragraph each."""
    measured = {c.id.removeprefix("npid_xytable."): c.measured for c in claims}
    return [" ".join(part.split()).format(**measured) for part in TEXT.strip().split("\n\n")]
