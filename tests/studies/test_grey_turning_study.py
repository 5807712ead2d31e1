"""The turning study as a user meets it, its readings worked by hand, and its runs against a second program."""

import math

import numpy as np
import pytest
from turning_oracle import Fuzzy, Lathe, grey, run

from leadscrew import resolve
from leadscrew.controllers._grey_fuzzy.rule_tables import TABLES
from leadscrew.sensors._load_cell import load_cell
from leadscrew.studies import results
from leadscrew.studies.grey_turning import cuts, laws, protection, removal
from leadscrew.studies.grey_turning.cuts import BOTH, Case, Cuts, Row, better, compared, together
from leadscrew.studies.grey_turning.readings import SeedMean, read, seed_mean
from leadscrew.studies.grey_turning.tunings import FACTORS
from tests.budget import WHOLE
from tests.studies.turning_lab import lab

STUDY = resolve.study("grey_turning")
ON_THE_RING = 1171.875
"""Spindle speed at which a step of 1 ms is five of the 256 places a revolution: interpolation is then exact."""
S9 = (28.0, 15.4, 0.0214)


# ---- as a user meets it
def test_controllers_of_every_kind_and_every_scenario_make_a_loop():
    kinds = ("paper.gpfc_printed_s9", "corrected.tfc_s6", "ours.smith_f", "ours.tfc_ff", "ours.constant_force")
    pairs = [(name, "fig6_fixed_depth") for name in kinds] + [("corrected.tfc_s6", s) for s in STUDY.scenarios]
    for name, scenario in pairs:
        assert STUDY.loop(name, scenario).signals["output"] is not None, (name, scenario)


@pytest.mark.slow
def test_every_controller_fits_into_scenarios_of_all_kinds():
    for i, name in enumerate(STUDY.controllers):
        for j, scenario in enumerate(STUDY.scenarios):
            if WHOLE or (i + j) % 3 == 0:
                assert STUDY.loop(name, scenario).signals["output"] is not None, (name, scenario)


def test_loops_that_differ_in_values_share_a_program():
    first = lab().loop("corrected.tfc_s6", "fig6_fixed_depth")
    second = lab().loop("corrected.tfc_s9", "fig9_falling_depth", machine="plant_n")
    assert second.program is first.program and second.sheet["plant.depth.steps"].default == 3


def test_verdicts_of_the_key_claims_are_those_that_follow_from_their_numbers():
    found = results.evaluate(STUDY, key=True)
    verdicts = {c.id.removeprefix("grey_turning."): c.verdict for c in found.claims}
    assert verdicts["next_sample"] == "reproduced with a change"
    assert (
        verdicts["rise_fixed.tfc"] == verdicts["force_with_the_printed_sign"] == "fitted"
        and verdicts["rise_fixed.gpfc"] == "not reproduced"
    )
    assert verdicts["added_by_the_falling_depth"] == "not reproduced"


def test_every_equation_table_and_figure_of_the_paper_is_an_item():
    items = {line.split(",")[0].strip('"') for line in (STUDY.folder / "paper_items.csv").read_text().splitlines()}
    assert {"equation 1", "equations 2 to 8", "equations 13", "table 1", "figure 10a", "figures 10b"} <= items
    assert {f"equation {n}" for n in (9, 10, 11, 12, 15, 16, 17, 18)} <= items
    assert {f"figure {n}" for n in (1, 2, 3, 4, 5, 6, 7, 8, 9, 11)} <= items


# ---- readings worked by hand
def test_readings_of_forces_worked_by_hand():
    t = 0.02 * np.arange(150)
    ramp = np.minimum(100.0 * t / 0.2, 100.0)  # 10 N a sample, exact at the samples
    over = np.where(t >= 1.0, np.where(t < 1.1, 120.0, 94.0), ramp)
    found = read(np.array([ramp, over, 0.5 * ramp, np.full(150, np.nan)]), 100.0)
    assert found.overshoot[:3] == pytest.approx([0.0, 20.0, -50.0])
    assert found.rise_s[:2] == pytest.approx([0.16, 0.16]) and math.isnan(found.rise_s[2])
    assert found.rise_samples[:2] == pytest.approx([8, 8]) and math.isnan(found.rise_samples[2])
    assert found.steady[:3] == pytest.approx([0.0, 6.0, 50.0])
    climb = 0.02 * sum(100 - 10 * k for k in range(10))
    assert found.iae[:2] == pytest.approx([climb, climb + 0.02 * (5 * 20 + 95 * 6)])
    assert found.bad.tolist() == [False, True, True, True]


def test_rise_between_samples_and_in_whole_samples():
    found = read(np.array([[0.0, 20.0, 80.0, 95.0, 100.0] + 60 * [100.0]]), 100.0)
    assert found.rise_s[0] == pytest.approx(0.02 * ((2.0 + 10.0 / 15.0) - 0.5))
    assert found.rise_samples[0] == 2


def test_readings_of_a_case_are_those_worked_by_hand():
    y = np.array([[0.0, 15.0, 90.0, 135.0, 165.0, 150.0]])
    seen = Cuts(y, np.array([[0.0, 0.1, 0.3, 0.2, 0.2, 0.2]]), y, y)
    assert seen.rise_s.mean == pytest.approx(0.04)
    assert seen.steady((0.08, 0.12)).mean == pytest.approx(5.0)
    assert seen.activity("u", 0.0, 0.08) == pytest.approx(0.4 / 3.0)
    assert seen.highest(0.0, 0.08).mean == pytest.approx(-10.0)
    assert tuple(seed_mean(np.array([1.0, 3.0]))) == pytest.approx((2.0, 2.0**0.5, 2))


def test_a_difference_counts_from_three_standard_errors_on():
    a, b = SeedMean(1.0, 0.3, 9), SeedMean(1.5, 0.4, 16)  # standard errors 0.1 each: 0.424 are three of the difference
    assert better(a, b, 0.1) == 1 and better(b, a, 0.1) == -1
    assert better(a, SeedMean(1.4, 0.4, 16), 0.1) == 0
    assert better(SeedMean(1.0, 0.0, 1), SeedMean(1.05, 0.0, 1), 0.1) == 0


def test_gpfc_is_compared_with_the_tfc_of_the_same_factors():
    def row(*means):
        return Row(*(SeedMean(x, 0.1 * x, 25) for x in means), 0.0)

    rows = {"tfc_s6": row(4.0, 0.5, 1.0), "b_s6": row(2.0, 0.7, 1.01), "b_s9": row(0.0, 0.0, 0.0)}
    assert compared(rows, "s6") == {"overshoot": 1, "rise": -1, "steady": 0}


def test_a_pair_of_rules_and_factors_is_bad_by_overshoot_or_by_steady_error():
    found = cuts.Grid({"tfc": np.array([[31.0, 5.0, 5.0]])}, {"tfc": np.array([[0.0, 6.0, 4.0]])}, {})
    np.testing.assert_array_equal(found.bad("tfc"), [[True, True, False]])


def test_the_constant_feed_of_a_peak_lies_between_those_tried():
    """Peaks in proportion to the feed to the power 0.77, times inverse to it: then everything is a power law."""
    feeds = np.geomspace(33.0, 150.0, 6)
    tried = [removal.Account(2400.0 / v, 2.0 * v, 10.0 * v**0.77, 0.0) for v in feeds]
    found = removal.steady(tried, 10.0 * 60.0**0.77)
    assert found.feed_same_peak == pytest.approx(60.0) and found.time_same_peak_s == pytest.approx(40.0)
    assert removal.steady(tried, 1e6).feed_same_peak == pytest.approx(150.0)


# ---- the lathe against a second program
def both(name, fuzzy, rpm, lathe=None, machine="plant_f"):
    """Filtered force of our loop and of the other program, without noise."""
    loop = lab().loop(name, "noise_free", machine=machine)
    ours = loop.using({"plant.spindle_rpm": rpm, "plant.runout": 0.01}).run(1.5, record=("feedback",))["feedback"]
    return ours, run(fuzzy, 1.5, Lathe(rpm=rpm, **(lathe or {})))["y"]


@pytest.mark.slow
@pytest.mark.parametrize(("law", "reading"), [("tfc", ""), ("gpfc_b", "B"), ("gpfc_a", "A")])
def test_a_second_program_of_the_loop_gives_the_same_force(law, reading):
    ours, theirs = both(f"corrected.{law}_s9", Fuzzy(S9, reading), ON_THE_RING)
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-8)


def test_between_the_places_of_the_surface_the_force_is_right_to_twenty_millionths():
    ours, theirs = both("corrected.tfc_s9", Fuzzy(S9), 1200.0)
    assert 1e-8 < np.abs(ours - theirs).max() < 2e-5 * 150.0


@pytest.mark.slow
def test_the_slow_plant_is_that_of_the_second_program():
    slow = {"rate": 20.0, "dead_time_s": 0.02}
    ours, theirs = both("corrected.tfc_edge_n", Fuzzy((6.2, 0.96, 0.0029)), ON_THE_RING, slow, "plant_n")
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-8)


@pytest.mark.slow
def test_under_the_same_noise_a_second_program_gives_the_same_force():
    loop = lab().loop("corrected.gpfc_b_s6", "fig6_fixed_depth").using({"plant.spindle_rpm": ON_THE_RING})
    ours = loop.run(2.0, record=("feedback", "sensor", "actual"))
    noise = ours["sensor.raw"] - ours["actual.force"]
    assert noise.std() == pytest.approx(2.0, rel=0.25)
    theirs = run(Fuzzy((4.2, 1.35, 0.00307), "B"), 2.0, Lathe(rpm=ON_THE_RING), noise=noise)["y"]
    np.testing.assert_allclose(ours["feedback"], theirs, rtol=0, atol=1e-7)


def test_the_second_program_predicts_an_exact_growth_of_a_tenth_as_the_vectors_say():
    assert grey([100.0, 110.0, 121.0, 133.1, 146.41]) == pytest.approx(160.8769087394, rel=1e-10)
    assert grey([5.0, 1.0, -1.0, 1.0, -1.0]) is None


def test_cases_of_a_batch_are_the_runs_of_loops_of_their_own():
    case = Case(FACTORS["s9"], "b", {"sensor.noise_n": 0.0})
    batched = together(lab(), {"a": Case(FACTORS["s6"], "b"), "b": case}, 0.6, 2)["b"]
    alone = lab().loop("corrected.gpfc_b_s9", "fig6_fixed_depth").using({"sensor.noise_n": 0.0}).run(0.6)
    np.testing.assert_array_equal(batched.y[0], alone["feedback"])
    np.testing.assert_array_equal(batched.y[1], batched.y[0])


# ---- what the cuts must hold by physics
def test_the_printed_sign_runs_the_feed_to_its_limit():
    force = cuts.quiet(lab())["s9_printed"].y.max()
    assert force == pytest.approx(2256.3 * (150.0 / 1200.0) ** 0.77, rel=2e-3)


def test_between_the_falls_the_feed_is_what_equation_1_asks_for_and_at_last_it_cannot():
    found = cuts.fall(lab())["s9_b"]
    for depth, until in ((1.0, 2.0), (0.8, 4.0), (0.6, 6.0), (0.4, 8.0)):
        asked = 1200.0 * (150.0 / (2256.3 * depth)) ** (1.0 / 0.77)
        k = round(until / 0.02)
        assert found.feed[:, k - 20 : k].mean() == pytest.approx(asked, rel=0.02)
    assert found.y[:, -25:].mean() == pytest.approx(2256.3 * 0.2 * (150.0 / 1200.0) ** 0.77, rel=5e-3)


def test_the_largest_force_is_the_entry_and_every_fall_of_the_depth_lowers_it_first():
    for name in ("s9_tfc", "s9_b"):
        y = cuts.fall(lab())[name].y
        assert (y.argmax(axis=1) < 100).all()
        assert all(y.mean(axis=0)[k + 10] < y.mean(axis=0)[k] - 5.0 for k in (100, 200, 300, 400))


def test_the_chip_builds_up_over_one_revolution():
    assert laws.chip_build_up_s(lab()) == pytest.approx(60.0 / 1200.0, abs=1e-3)


def test_the_cell_filters_as_scipy_does():
    from scipy.signal import lfilter

    loop = lab().loop("corrected.tfc_s6", "fig6_fixed_depth", sensor=load_cell(noise_n=5.0))
    seen = loop.run(3.0, record=("sensor",))
    assert seen["sensor.force"] == pytest.approx(lfilter([0.2], [1.0, -0.8], seen["sensor.raw"]), abs=1e-9)


@pytest.mark.slow
def test_the_volume_of_a_bar_is_removed_whatever_the_controller():
    volume = math.pi * 50.0 * 10.0 * (1.0 + 0.8 + 0.6 + 0.4)
    for name, account in removal.turned(lab(), "falling").accounts.items():
        assert account.rate * account.time_s == pytest.approx(volume, rel=0.005), name


# ---- rough rules
WEAK = """
-3 -3 -3 -3 -3 -2 -2
-3 -3 -2 -2 -2 -1 -1
-2 -2 -1 -1 -1  0  0
-1 -1  0  0  0  1  1
 0  0  1  1  1  2  2
 1  1  2  2  2  3  3
 2  2  3  3  3  3  3"""
"""clip(round(i + 0.34 j), -3, 3), worked by hand."""


@pytest.mark.slow
@pytest.mark.parametrize(("law", "reading"), [("tfc", ""), ("b", "B")])
def test_a_second_program_finds_the_same_contrast_of_rough_rules(law, reading):
    rules = [[int(x) for x in row.split()] for row in WEAK.strip().splitlines()]
    np.testing.assert_array_equal(TABLES["weak_ec"], rules)
    theirs = run(Fuzzy(S9, reading, rules), 3.0, Lathe())["y"]
    late = 100.0 * np.abs(theirs[-50:] - 150.0).mean() / 150.0
    ours = cuts.fixed(lab(), f"weak_{law}").steady()
    assert abs(late - ours.mean) < 4.0 * ours.spread


def test_random_rules_err_by_one_set_and_their_factors_by_four_at_most():
    drawn = cuts.rough_draws(count=20)
    index = np.arange(-3, 4)
    off = drawn["controller.rules"] - np.clip(index[:, None] + index[None, :], -3, 3)
    assert (abs(off) <= 1).all() and off.any(axis=(1, 2)).all()
    for key, value in FACTORS["sbn"]._asdict().items():
        assert (abs(np.log(drawn[f"controller.{key}_scale"] / value)) <= np.log(4.0)).all()


@pytest.mark.slow
def test_noise_free_rows_of_the_scenarios_are_those_of_a_second_program():
    rows = cuts.rows_of(lab(), "no noise, no runout")
    for law, reading in zip(BOTH, ("", "B"), strict=True):
        y = run(Fuzzy(S9, reading), 3.0, Lathe(runout=0.0))["y"]
        assert rows[f"{law}_s9"].overshoot.mean == pytest.approx(100.0 * (y.max() / 150.0 - 1.0), abs=0.02)
        assert rows[f"{law}_s9"].steady.mean == pytest.approx(100.0 * np.abs(y[-50:] / 150.0 - 1.0).mean(), abs=0.02)


# ---- protection
@pytest.mark.slow
def test_a_guard_holds_after_the_crossing_and_a_cell_that_shows_0_n_is_caught():
    found = protection.spots(lab(), "plant N, a look every 20 ms")
    raw, mode = found.run["feedback.raw"], found.run["controller.guard.mode"]
    for k, begin in enumerate(found.start):
        crossed = begin + int(np.argmax(raw[k, begin:] > 180.0))
        held = begin + int(np.argmax(mode[k, begin:] > 0))
        assert found.late_ms()[k] == held - crossed + 20.0 and 20.0 <= found.late_ms()[k] < 40.0
    assert (protection.broken(lab())["shows 0 N"].held_s < 0.1).all()
