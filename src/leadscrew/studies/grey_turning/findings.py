"""What the study found, in words around the numbers that it measured."""

from __future__ import annotations

from collections.abc import Sequence

from leadscrew.report.claim import Claim

TEXT = """
Rules, scaling factors, servo and sampling time are missing in the text that we have. Factors and servo were fitted to
the paper's own numbers, so meeting these proves nothing; the random plants, the ablation on noise that no tuning has
seen, and the errata are not fitted to anything.

Equation (11) has the wrong sign: used as printed the force runs to {literal_11_force:.3g} N. Its index fits the
newest sample in place of the next one, and then the effect is lost: {index_late_sbn:.2g} % of overshoot against
{index_right_sbn:.2g} %.

Near a set-point GM(1,1) with five samples is a fixed filter, y + (y1 - y3) / 2 with a noise gain of
{grey_noise_gain:.4g}, and inside its rules the fuzzy controller is a linear PI. Grey prediction then adds a
derivative. What is left of it in the large is a brake in the start-up, because a concave rise is over-predicted.

One shared set of factors gives {falling_overshoot_tfc:.3g} and {falling_overshoot_b:.3g} % of overshoot where the
paper has 48.6 and 12.7 %. It is the entry into the cut at 1 mm, in 5.1 and 5.2 alike, and no effect of the falling
depth: after a step the force dips, {falling_dip_8:.2g} to {falling_dip_4:.3g} %. The steady error is halved only from
1.5 to 2 s; once both have settled it is {falling_steady_tfc_30_40:.2g} and {falling_steady_b_30_40:.2g} %.

The rise time of 5.1 is not reproduced at equal factors ({fixed_rise_tfc:.2g} and {fixed_rise_b:.2g} s, 0.5 and 0.3 in
the paper), and the steady errors of 1.7 and 1.0 % only at the edge of a limit cycle, where ten percent of loop gain
change everything. A 12-bit converter does not explain them: {dac_steady_tfc:.2g} %.

Without the digital filter prediction harms: the GPFC overshoots and errs more than the TFC under the same factors.
With a feed force of half the main force the GPFC of Figure 9 overshoots by {feed_force_ratio_overshoot_b:.2g} %: the
fit hangs on a ratio of 1.

The voltage is smoother with prediction during the entry ({falling_activity_first_tfc:.3g} to
{falling_activity_first_b:.3g} mV a sample) and rougher in the steady state ({activity_steady_s9_tfc:.3g} to
{activity_steady_s9_b:.3g}).

Tuned alike and judged on forty noise seeds that no tuning has seen, grey prediction is worth {ablation_f_gpfc_b:.2g}
% of the cost on plant F and {ablation_n_gpfc_b:.2g} % on plant N, the line through two samples
{ablation_f_two_point:.3g} and {ablation_n_two_point:.2g} %, a Smith predictor {ablation_f_smith:.3g} and
{ablation_n_smith:.3g} %. How much hangs on the cost: with ten times the penalty on overshoot GM(1,1) is worth
{ablation_f_gpfc_b_overshoot:.2g} and {ablation_n_gpfc_b_overshoot:.2g} %, which the scatter hides; the line through
two samples gains under all four costs.

Roughly chosen factors are what prediction helps with: of 300 random plants at half of the factors of Figure 9
{a10_bad_tfc:.3g} % are bad without it and {a10_bad_gpfc:.2g} % with it. Wrong rules it does not repair: of 250 random
tables {mc_rules_bad_tfc:.3g} % are bad without and {mc_rules_bad_gpfc:.3g} % with it.

A controller that inverts the power law, estimates its constant from the encoders, corrects for compliance and knows
the programmed depth has {m1_overshoot:.3g} % of overshoot, rises in {m1_rise:.3g} s, keeps the stairs to
{m2_filtered:.2g} % (true force {m2_true:.2g} %), and on 300 random plants 90 % of the overshoots are below
{m3_p90:.2g} %, with an integral of the error {m3_iae:.3g} % from that of the best fuzzy controller. It has to know
how the radial axis moves, and needs a carriage encoder of a micrometre: counts of 10 um cost {travel_count_10um:.2g}
% of true overshoot. In iron its true force peaks {iron_true_overshoot:.2g} % above the set-point.

Constant force pays on a falling depth where it is well controlled: a constant feed of the same peak force takes
{removal_tuned_pays:.3g} times as long, and {removal_falling_tfc_s9:.2g} times as long as the TFC that has the paper's
48.6 % of overshoot, which is therefore slower than a constant feed. Where unannounced shoulders rise it does not pay
({removal_shoulders:.2g}): the shallow cut has been fed fast, and the force follows the depth at once.

The guard takes the voltage from the drive {guard_hold_20ms:.2g} ms after the raw force passes its limit (plant N:
{guard_hold_20ms_n:.2g} ms), and every cut goes on afterwards. It cannot take back the chip that is under way, so a
hard spot that doubles the force still peaks at {hard_spot_peak_guarded:.3g} %. A load cell whose zero or scale has
moved is not seen by any check. A loop that overshoots by 48 % latches any guard of 120 %.

The published fit of the turning tests, R2 = 0.932, is that of the logarithm of the specific force; on the eight cuts
ours is off by {force_fit_error:.3g} % rms, as a least-squares fit of them must be less than theirs; a cut that it has
not seen by 8.9 %. Their force is not in proportion to the depth, as equation (1) has it.

Where our numbers are not the digest's: its gain margins are those of a rigid tool; its grid of thirty rough cases is
not named, so ours has others ({rough_grid_bad_tfc:.2g} bad without and {rough_grid_bad_b:.2g} with prediction, it has
27 and 18); GM(1,1) two samples ahead is better than no prediction on plant F too in our search
({ablation_f_gm_h2:.2g} %, +4.6 there), whose cost is another.
"""
"""A paragraph a finding; names in braces are claims."""


def findings(claims: Sequence[Claim]) -> list[str]:
    """The findings for the report, a paragraph each."""
    measured = {c.id.removeprefix("grey_turning."): c.measured for c in claims}
    return [" ".join(part.split()).format(**measured) for part in TEXT.strip().split("\n\n")]
