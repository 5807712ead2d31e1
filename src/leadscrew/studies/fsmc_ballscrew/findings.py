"""What the study found, in words around the numbers that it measured."""

from __future__ import annotations

from collections.abc import Sequence

from leadscrew.report.claim import Claim


def findings(claims: Sequence[Claim]) -> list[str]:
    """The findings for the report, one sentence or two each."""
    m = {c.id.removeprefix("fsmc_ballscrew."): c.measured for c in claims}

    def um(name: str, digits: int = 3) -> str:
        return f"{float(m[name] or 0.0):.{digits}g}"

    def three(pattern: str, digits: int = 2) -> str:
        return " / ".join(um(pattern.format(s), digits) for s in ("sine_slow", "sine_wide", "sine_fast"))

    return [
        "The paper's order of errors, SMC > CSMC > FSMC, holds with the conventional surface e' + lam e. With the "
        "integral surface that the paper prints, SMC leaves no steady error and beats CSMC in every scenario.",
        f"CSMC is {um('paper_half_sine_wide')} times as good as that SMC on 5 sin t, as its bound says. FSMC takes the "
        f"error after a step away (to {um('paper_step_fsmc', 2)} um); CSMC does not within seconds "
        f"({um('paper_step_csmc')} um are left after a smooth step, and decay over minutes).",
        f"The control of FSMC at rest is not zero: the bristles are bent by {um('paper_rest_fsmc')} N m. Only with "
        f"f_hat "
        "from the measured speed is its mean zero, in a limit cycle.",
        f"The error after a reversal is damped in {1e3 * float(m['paper_recovery_sine_wide'] or 0.0):.0f} and "
        f"{1e3 * float(m['paper_recovery_sine_fast'] or 0.0):.0f} ms on the two larger sines; on 0.01 sin t, which "
        f"never "
        f"leaves the creeping range, in {1e3 * float(m['paper_recovery_sine_slow'] or 0.0):.0f} ms: not within 0.1 s.",
        f"The printed gains must be sampled every {um('sampling_limit_smc')} us (SMC), {um('sampling_limit_csmc', 2)} "
        f"us "
        f"(CSMC) and {um('sampling_limit_fsmc', 2)} us (FSMC) or faster. The paper names no sample rate.",
        "Rules as printed act along s - s_c, on the error and its integral; the derivation asks for s + s_c. Both "
        "work, "
        "with unequal scales. With equal ones the corrected rules have a dead corner, in which the stage drifts away "
        "by "
        f"{um('fuzzy_dead_corner_equal_sine_wide', 2)} um, so the fuzzy law is not stable for being built on a stable "
        f"one.",
        f"At 4 kHz with a scale of 10 nm the largest errors on the three sines are "
        f"{three('sampled_fsmc_4khz_{}_max')} um "
        f"under the tuned fuzzy law, {three('sampled_pd_dob_{}_limit')} um under a scheduled PD with a disturbance "
        f"observer, and {three('beaten_nominal_{}')} um when that learns its friction model on the way; with friction "
        f"20 % off {three('beaten_friction_p20_{}')} and {three('beaten_friction_m20_{}')} um. Under Maxwell-slip "
        f"friction it keeps {three('beaten_gms_{}')} um: a miss, where half a count of the scale alone is worth "
        f"{um('beaten_gms_bound', 2)} um.",
        f"These numbers are of a rigid stage and an ideal drive. A sample of delay defeats them "
        f"({m['drive_delay_survivors_pd_dob_robust']:.0f} of 8 runs hold; with look-ahead and lower gains 8 of 8, at "
        f"{um('drive_holds_delay', 2)} um), an axial mode of 266 Hz more so ({um('drive_holds_all', 2)} um with "
        "everything that a drive adds).",
        f"One move of 7.5 s tells sigma_0, sigma_1, F_S and v_s to {um('selftuned_test_stiffness', 1)}, "
        f"{um('selftuned_test_damping', 1)}, {um('selftuned_test_static', 1)} and "
        f"{um('selftuned_test_stribeck_speed', 1)} %. From sines alone F_S and v_s cannot be told, and the fit says "
        f"so.",
        "Circles shrink with the feed only under FSMC; under SMC and CSMC they grow. The cause is Table 2: the "
        "believed "
        "viscous friction is three times the true one.",
        f"Stick-slip can be seen in the simulation, below {um('creep_threshold_fsmc', 2)} um/s, contrary to the text.",
        f"A bar of 0.1 um could not have told the three controllers apart: it misreads G(b) by up to "
        f"{um('bar_g_error', 2)} um, and their true circles differ by {um('bar_tells_apart', 1)} um.",
    ]
