"""What the study found, in words around the numbers that it measured."""

from __future__ import annotations

from collections.abc import Sequence

from leadscrew.report.claim import Claim

TEXT = """
The paper gives no process, no rules, no units of ec, no path, no baseline and no number of an error. Everything here
is a reconstruction; agreement with its Figures 5 to 7 cannot be checked, and "better effect" depends on what stands
for what it leaves out: from {bilinear_reduction_none:.3g} % below no compensation to nothing at all.

Learned with rounded levels, as printed, the network learns nothing: up to {rounding_dead_zone:.2g} degrees of
deviation have no correction, and the result is that of fixed rules. Between the levels it works, at the printed
scales with {literal_reduction_none:.3g} % less deviation than without compensation and {literal_reduction_fixed:.3g}
% less than fixed rules, which can take away {fixed_cap:.3g} % at most. On the place of the cut it is worth more,
{contour_favours:.3g} %, because it takes away the mean angle.

The RMSE against Table 1 is no test of a performance network. The network of the smallest RMSE has the wrong slope at
the origin: the loop runs to {bad_slope_mean:.3g} degrees, on the wave {bad_slope_diverges:.2g} times as far as
without compensation. The safety test refuses it. A network with biases holds a deviation of {biased_up:.2g} or
{biased_down:.2g} degrees for good.

Tuned with the same effort and judged on textures that no tuning has seen: disturbance observer {equal_observer:.3f},
the paper's form {equal_paper:.3f}, PID {equal_pid:.3f}, self-organising network {equal_sofnn:.3f}, the table on the
rules without networks {equal_sofc:.3f}, fixed rules {equal_fixed:.3f} degrees. The paper's form gets there with
scales a thousand times from the printed ones, where one column of its seven is all of its rules that is used; with
corrections of the same form, the table on the rules without networks has {sofc_added:.3f} to {sofc_stored:.3f} times
the deviation of the network. The observer's cut lies {contour_observer:.2g} times as far from its line as the PID's.

Rules over error and rate are an integrator and no memory: held after five pieces they keep {recall_share_median:.2g}
% of what learning had gained. {recall_few_rules:.0f} of the 49 rules change by more than 0.05 level. The same 49
rules over the curvature ahead keep {m4_kept:.3g} %, and serve on lines that they have not seen, at {m4_transfer:.2g}
degrees at worst.

Equation (3) read literally is a comb integrator. It bears a camera 0 to 24 samples late at the printed scales
({delay_24_wave:.3f} degrees with m = 4, {delay_24_wave_6:.3f} with the digest's m = 6, which misses its 0.85),
because the Kalman filter's gain leaves the teeth of the comb a loop gain below one. At six times the gain it needs
the right delay, as a PID does.

The inner loop of step 7 is redundant, and its threshold is a dead zone: J < 0.001 makes the deviation
{threshold_is_a_dead_zone:.3g} times as large.

Forgetting without excitation blows up every form of the covariance (10^{forgetting_trace:.3g} after 20,000 updates).
A random walk with a cap holds; over 100,000 samples nothing leaves its bounds.

While the camera is lost for a second the learning stops and the offset goes back. Not told, the tuned network is
{loss_rms_tuned:.2g} times as far off; a PID, which is never told, stands at {loss_pid:.2g} degrees. Seen again, the
offset comes back as slowly as it went: its largest step is {sight_pnn:.2g} times that without a loss.

Fabric becomes foam on the way: the paper's network is {change_literal_gain:.3g} % better than fixed rules at least,
and no better than a PID. The tuned network gets worse with every repeated step ({step_tuned_gets_worse:.2g} times at
the fourth).

What beats all of this knows the line. Adaptive feed-forward of the curvature: {feed_forward_piece_1:.2f} degrees on
the first piece, {feed_forward_piece_3:.2f} on the third. Learning from piece to piece composes with the paper's
network: {m1_piece_3:.2f} by the third piece and {m1_piece_6:.2f} by the sixth, {m1_mismatch_6:.2f} where the process
breaks the model's rules; the texture alone leaves {texture_floor_foam:.2f} in foam and {texture_floor_leather:.2f} in
leather. A prior from other materials and other lines helps the first piece ({m2_prior_rms:.2f} degrees), and gains
nothing where the process breaks the model ({m2_mismatch_prior_rms:.3f}, asked 0.40).

No sensor is needed for that: cut, measure the cut line, write the program again. The second piece has {m6_flower:.2f}
to {m6_wave:.2f} of the first one's error; from scans with noise, placed by two marks, {m6_scan_worst:.2f} in the
worst drawing and material, which misses the third; single runs from exact cut lines reach {m6_worst_run:.2f}. A scan
without marks cannot tell a constant angle from a turned sheet.
"""
"""One finding a paragraph."""


def findings(claims: Sequence[Claim]) -> list[str]:
    """The findings for the report, with the measured numbers in them."""
    measured = {c.id.removeprefix("sofnn_tangent."): c.measured for c in claims}
    return [" ".join(paragraph.split()).format(**measured) for paragraph in TEXT.strip().split("\n\n")]
