"""Claims about backlash: the classic and the modern model, and either inside the loop, the paper's Figure 19."""

from __future__ import annotations

import math

from leadscrew.analysis.circular.quantities import quantities
from leadscrew.plants.backlash_two_mass import damping_ratio, restitution_of
from leadscrew.report.claim import Claim, Group, Kind, Sense, Verdict
from leadscrew.studies.fsmc_ballscrew import backlash_runs as b
from leadscrew.studies.fsmc_ballscrew import impacts as m
from leadscrew.studies.fsmc_ballscrew.runs import Loops, tail_um

SINES = {"sine_wide": ("wide", "5 sin t mm"), "sine_fast": ("fast", "sin 2 pi t mm")}
SECONDS = {"sine_wide": 7.9, "sine_fast": 2.25}
"""Two half turns after the first reversal; a turn and a quarter after the first second."""
DIGEST_CROSSING_MS = {"sine_wide": 29.2, "sine_fast": 10.5}
DIGEST_SWING_UM = {("sine_wide", 0.9): 0.28, ("sine_fast", 0.9): 0.60, ("sine_wide", 0.05): 0.19,
                   ("sine_fast", 0.05): 0.23}  # fmt: skip
DIGEST_SETTLED_MS = {("sine_wide", 0.9): 47.0, ("sine_fast", 0.9): 57.0, ("sine_wide", 0.05): 30.0,
                     ("sine_fast", 0.05): 13.0}  # fmt: skip
USUAL = restitution_of(-math.log(0.05) / math.hypot(math.pi, math.log(0.05)))
"""What a flank that only pushes parts with if it is damped by the formula of one that also pulls, for 0.05."""
HOLDS_UM = 0.01
"""A step of the table that is smaller counts as compensated: one count."""
ISO = "7.2, Figure 19"


def claim(
    name: str, source: str, statement: str, measured: float | str, unit: str, target: float | str | None = None,
    tolerance: float = 0.0, reason: str = "", paper: float | str | None = None, verdict: Verdict = "cannot be checked",
    sense: Sense = "=", kind: Kind | None = None, group: Group = "ours",
) -> Claim:  # fmt: skip
    """One row; without a target it only reports, without a word of the paper it cannot be checked."""
    value = measured if isinstance(measured, str) else float(measured)
    return Claim(
        f"fsmc_ballscrew.{name}", source, group, "reconstructed plant", statement, paper, value, unit, sense, target,
        tolerance, kind or ("report" if target is None else "required"),
        verdict if paper is not None else "cannot be checked", reason,
    )  # fmt: skip


def backlash_claims(loops: Loops) -> list[Claim]:
    """All of them."""
    return [*_impacts(loops), *_inside(loops), *_circle(loops), *_two_masses(loops)]


def _impacts(loops: Loops) -> list[Claim]:
    rows = []
    for name, (key, words) in SINES.items():
        hard, soft = m.impact(loops, name, 0.9), m.impact(loops, name, USUAL)
        pure, pressed = (1e3 * m.crossing_of_parabola(name, m.GAP_M + more) for more in (0.0, m.pressed_m()))
        found = 1e3 * hard.crossing_s
        rows += [
            claim(f"backlash_parabola_{key}", "2.1", f"sqrt(2 b / (R w^2)) for {words}, b = 2 um", pure, "ms",
                  {"wide": 28.3, "fast": 10.07}[key], {"wide": 0.05, "fast": 0.005}[key],
                  "the screw leaves its reversal on a parabola; the table stands"),
            claim(f"backlash_crossing_{key}", "2.1", f"time to cross the gap after a reversal of {words}", found, "ms",
                  pressed, 0.15, "the target is the parabola with the 0.2 um by which the guide's 20 N press the "
                  f"flank; the digest's {DIGEST_CROSSING_MS[name]:g} ms is what a guide friction smoothed over 10 "
                  "um/s gives, which lets go before the reversal"),
        ]  # fmt: skip
        rows += [*_beyond(name, key, words, 0.9, hard), *_beyond(name, key, words, 0.05, soft)]
        longer = hard.settled_s > soft.settled_s
        rows.append(claim(f"backlash_vibrates_{key}", "2.1, Figure 2", f"settling after a reversal of {words}: "
                          "almost elastic impact over a soft one", hard.settled_s / soft.settled_s, "1", 1.2, 0.0,
                          f"{1e3 * hard.settled_s:.1f} against {1e3 * soft.settled_s:.1f} ms",
                          "impact can cause transient vibrations",
                          "reproduced" if longer else "not reproduced", ">="))  # fmt: skip
        phase, flies = m.change_of_flank_without_friction(loops, name)
        rows.append(claim(f"backlash_free_{key}", "2.1", "phase after the largest speed at which a table without guide "
                          f"friction meets the other flank, {words}", phase, "degrees", flies, 0.2, "it flies on when "
                          "the screw slows down, so the flank changes near the largest speed; where the screw turns "
                          f"(90 degrees) it does with guide friction only, {found:.1f} ms later",
                          "the deadband is covering the point in which the velocity reduced to zero",
                          "reproduced with change"))  # fmt: skip
    rows += [
        claim("backlash_usual_damping", "2.1, Figure 2", "restitution of a flank that only pushes, damped by the usual "
              "formula for 0.05", USUAL, "1", 0.214, 5e-4, "zeta = -ln e / sqrt(pi^2 + ln^2 e) is for a flank that "
              "also pulls"),
        claim("backlash_own_damping", "2.1, Figure 2", "the same, damped as the plant does it",
              restitution_of(damping_ratio(0.05)), "1", 0.05, 1e-9,
              "solved for a flank that only pushes"),
    ]  # fmt: skip
    return rows


def _beyond(name: str, key: str, words: str, asked: float, run: m.Impact) -> list[Claim]:
    """What the table does against the classic play, beside the digest's numbers."""
    e = asked if asked > 0.5 else USUAL
    tag = "hard" if asked > 0.5 else "soft"
    swing, settled = DIGEST_SWING_UM[name, asked], DIGEST_SETTLED_MS[name, asked]
    bounces = tag == "hard" and key == "fast"
    kind: Kind = "report" if bounces else "required"
    why = "the restitution that the digest's damping for 0.05 has" if tag == "soft" else "as asked for"
    if bounces:
        why = "with a guide friction smoothed over 10 um/s it is the digest's 0.60 um"
    since = 1e3 * (run.settled_s - run.crossing_s)
    source = "2.1, Figure 2"
    return [
        claim(f"backlash_swing_{tag}_{key}", source, f"table off the classic play after the impact, {words}, e = "
              f"{e:.2g}, peak to peak", run.swing_um, "um", swing, 0.01, why, kind=kind),
        claim(f"backlash_settled_{tag}_{key}", source, f"until that stays within 0.05 um, {words}, e = {e:.2g}",
              1e3 * run.settled_s, "ms", settled, 1.5, f"from the reversal, {since:.1f} ms from the impact", kind=kind),
        claim(f"backlash_contacts_{tag}_{key}", source, f"contacts after one reversal, {words}, e = {e:.2g}",
              run.contacts, "1", reason="the digest counts 30 to 41 in two turns, that is eight reversals, for e = "
              "0.9; that many are not reproduced" if tag == "hard" else why),
    ]  # fmt: skip


def _inside(loops: Loops) -> list[Claim]:
    """The classic play in the loop."""
    rows = []
    for name, (key, words) in SINES.items():
        rate = m.SINES[name][1]

        def of(controller: str, lag: float, name: str = name, rate: float = rate) -> b.Reversed:
            return b.reversed_by(b.backlash_run(loops, controller, name, "play", lag, SECONDS[name]), rate)

        motor, fuzzy = of("ours.pd_dob", b.MOTOR), of("ours.fsmc_4khz", b.TABLE)
        rows.append(claim(f"backlash_motor_step_{key}", ISO, f"error of the table on the way of {words}, motor encoder",
                          motor.offset_um, "um", 0.5 * b.GAP_UM, 0.005, "half of the 2 um of play, for good, under "
                          "ours.pd_dob"))  # fmt: skip
        rows.append(claim(f"backlash_table_step_{key}", ISO, f"the same with a linear encoder, {words}",
                          fuzzy.offset_um, "um", HOLDS_UM, 0.0, "under ours.fsmc_4khz: one count of the scale",
                          "detected and compensated",
                          "reproduced" if fuzzy.offset_um <= HOLDS_UM else "not reproduced", "<="))  # fmt: skip
        nominal = tail_um(loops.run("ours.fsmc_4khz", name))[0]
        times = fuzzy.height_um / nominal
        rows.append(claim(f"backlash_table_peaks_{key}", ISO, "peak with a linear encoder over that without play, "
                          f"{words}", times, "1", 1.5, 0.0, f"{fuzzy.height_um:.3f} against {nominal:.3f} um under "
                          "ours.fsmc_4khz", "some peaks will outbreak in the reversal points",
                          "reproduced" if times > 1.5 else "not reproduced", ">="))  # fmt: skip
        for who, lag, tag, what in (
            ("ours.fsmc_4khz", b.TABLE, "fsmc", "linear encoder"),
            ("ours.pd_dob_fixed", b.TABLE, "pd_dob_fixed", "linear encoder"),
            ("ours.pd_dob", 1e-3, "pd_dob_dual", "both encoders, 1 ms"),
        ):
            found = of(who, lag)
            comes = not math.isnan(found.duration_s)
            rows.append(claim(f"backlash_peak_{tag}_{key}", ISO, f"peak after a reversal of {words}, {what}, {who}",
                              found.height_um, "um",
                              reason="the play is crossed before anything can be felt of it"))  # fmt: skip
            rows.append(claim(f"backlash_duration_{tag}_{key}", ISO, f"time until within {b.BACK_UM:g} um, {words}, "
                              f"{what}, {who}", 1e3 * found.duration_s if comes else "never", "ms",
                              reason="from the reversal of the command" if comes
                              else f"{who} is off by more without any play",
                              paper="a certain amount of time",
                              verdict="reproduced" if comes else "cannot be checked"))  # fmt: skip
    loop = b.backlash_loop(loops, "ours.pd_dob", "sine_wide", "play", b.TABLE)
    tame = loop.using({"controller.kp_slow": 0.0, "controller.kd_slow": 1.0})
    fast, wide, gentle = (
        b.reversed_by(run, rate)
        for run, rate in (
            (b.backlash_run(loops, "ours.pd_dob", "sine_fast", "play", b.TABLE, 2.25), 2.0 * math.pi),
            (b.backlash_run(loops, "ours.pd_dob", "sine_wide", "play", b.TABLE, 7.9), 1.0),
            (b.played(tame, 7.9), 1.0),
        )
    )
    rows += [
        claim("backlash_scheduled_wide", ISO, "ours.pd_dob on a linear encoder, 5 sin t mm", _stands(wide), "",
              "diverges", 0.0, f"{wide.diverged}; the gains raised for bristles that hold "
              "(kd_slow 16.7 N m s/rad) meet a motor that runs freely in the gap", sense="yes/no"),
        claim("backlash_scheduled_fast", ISO, "ours.pd_dob on a linear encoder, sin 2 pi t mm", _stands(fast), "",
              "holds", 0.0, "the reversal is over before the schedule is up", sense="yes/no"),
        claim("backlash_scheduled_gentle", ISO, "the same on 5 sin t mm with kp_slow 0 and kd_slow 1", _stands(gentle),
              "", "holds", 0.0, f"peak {gentle.height_um:.2f} um", sense="yes/no"),
    ]  # fmt: skip
    return rows


def _stands(found: b.Reversed) -> str:
    return "diverges" if found.diverged else "holds"


def _circle(loops: Loops) -> list[Claim]:
    """Both axes with the play, R = 1 mm at 1 Hz."""
    rows = []
    for controller, lag, key, words in (
        ("ours.pd_dob", b.MOTOR, "motor", "motor encoders, ours.pd_dob"),
        ("ours.fsmc_4khz", b.TABLE, "table", "linear encoders, ours.fsmc_4khz"),
        ("ours.pd_dob", 1e-3, "dual", "both encoders, ours.pd_dob"),
    ):
        run = b.backlash_run(loops, controller, "sine_fast", "play", lag, SECONDS["sine_fast"])
        found = quantities(b.circle(run, 1.0))
        assert found.ccw is not None and found.both is not None
        here = key == "motor"
        more = "the play on both axes, and what friction leaves" if here else "peaks in place of steps"
        rows += [
            claim(f"backlash_circle_g_{key}", ISO, f"circular deviation G of a circle of 1 mm at 1 Hz, {words}",
                  found.ccw.circular, "um", b.GAP_UM if here else None, 0.03, more),
            claim(f"backlash_circle_h_{key}", ISO, f"circular hysteresis H of the same, {words}", found.both.hysteresis,
                  "um", b.GAP_UM if here else None, 0.06, more),
        ]  # fmt: skip
    return rows


def _two_masses(loops: Loops) -> list[Claim]:
    """The modern backlash in the loop."""

    def of(controller: str, lag: float) -> b.Reversed:
        return b.reversed_by(b.backlash_run(loops, controller, "sine_fast", "two_mass", lag, 2.25), 2.0 * math.pi)

    motor, dual = of("ours.pd_dob", b.MOTOR), of("ours.pd_dob", 0.03)
    pressed = 0.5 * b.GAP_UM + 1e6 * m.pressed_m()
    least = 1e3 * b.least_lag_s()
    calm, swings = (
        b.swing_um(b.backlash_run(loops, "ours.pd_dob", "sine_fast", "two_mass", part * 1e-3 * least, 2.25))
        for part in (1.0, 2.0 / 3.0)
    )
    fall = [who for who in ("ours.pd_dob", "ours.pd_dob_fixed") if of(who, b.TABLE).diverged]
    both = "ours.pd_dob on both encoders"
    return [
        claim("backlash_modern_motor_step", ISO, "two masses, motor encoder: error of the table on the way of sin 2 "
              "pi t",
              motor.offset_um, "um", pressed, 0.005, "half of the play, and the 0.2 um by which the guide presses the "
              "joint"),
        claim("backlash_modern_table", ISO, "two masses, linear encoder: how many of ours.pd_dob and ours.pd_dob_fixed "
              "diverge", len(fall), "1", 2.0, 0.0, "the table swings at 201 Hz on the joint, hardly damped; both have "
              "more bandwidth than that and take the table for the motor"),
        claim("backlash_modern_dual_step", ISO, f"two masses, {both} with 30 ms: step that stays", dual.offset_um, "um",
              HOLDS_UM, 0.0, "the table's scale has the last word", sense="<="),
        claim("backlash_modern_dual_peak", ISO, f"two masses, {both} with 30 ms: peak after a reversal",
              dual.height_um, "um", reason="more than the play: the table bounces"),
        claim("backlash_modern_dual_duration", ISO, f"two masses, {both} with 30 ms: time until within {b.BACK_UM:g} "
              "um",
              1e3 * dual.duration_s, "ms", reason="three times the lag"),
        claim("backlash_modern_least_lag", ISO, "least lag of the table's reading, M / c", least, "ms", None, 0.0,
              "derived (Routh) for a motor that follows at once"),
        claim("backlash_modern_calm", ISO, f"two masses, {both} with that lag: swing of the table at full speed", calm,
              "um", 0.1, 0.0, "calm, as derived", sense="<="),
        claim("backlash_modern_swings", ISO, "the same with two thirds of that lag", swings, "um", 1.0, 0.0,
              "a limit cycle of the table in its gap", sense=">="),
    ]  # fmt: skip


__all__ = ["backlash_claims"]
