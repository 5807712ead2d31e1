"""The Monte Carlo in turning: what is drawn, how runs are judged and compared, and that all see the same noise."""

import math

import numpy as np
import pytest
from scipy.stats import kstest

from leadscrew.controllers.force.power_law_inversion import power_law_inversion
from leadscrew.kernel.errors import NameUnknown
from leadscrew.studies.grey_turning.montecarlo import COMMON, FEEDS, KF, MACHINES, Judged, draws, judge, judged
from leadscrew.studies.grey_turning.montecarlo_runs import (
    SCENARIO,
    MonteCarlo,
    compared,
    force_controllers,
    rough_draws,
    share,
    table,
    told,
)
from leadscrew.studies.grey_turning.runs import Loops


@pytest.fixture(scope="module")
def loops():
    return Loops()


@pytest.mark.parametrize("plant", ["plant_f", "plant_n"])
def test_every_draw_is_inside_the_ranges_of_the_digest_and_can_reach_the_force(plant):
    found = draws(plant, 2000)
    for key, (low, high) in (COMMON | MACHINES[plant]).items():
        assert low <= found[key].min() < low + 0.05 * (high - low) and high - 0.05 * (high - low) < found[key].max()
        assert found[key].max() <= high
    kf, p, depth = (found[f"plant.{k}"] for k in ("law.kf", "law.exponent", "depth.start"))
    assert (abs(np.log(kf / KF)) <= 0.4).all()
    force_at = [kf * depth * (feed / 1200.0) ** p for feed in FEEDS]
    assert (force_at[0] <= 150.0 * (1 + 1e-12)).all() and (force_at[1] >= 150.0 * (1 - 1e-12)).all()
    for key in ("sensor.noise_n", "plant.servo.rate", "plant.stiffness"):  # the rejection does not touch these
        low, high = (COMMON | MACHINES[plant])[key]
        assert kstest((found[key] - low) / (high - low), "uniform").pvalue > 1e-3


def test_fewer_draws_are_the_first_of_more_and_another_seed_gives_others():
    many, few, other = draws("plant_f", 50), draws("plant_f", 7), draws("plant_f", 7, seed=10)
    for key, values in few.items():
        assert np.array_equal(values, many[key][:7]) and not np.array_equal(values, other[key])


def test_an_unknown_plant_is_named_with_the_nearest():
    with pytest.raises(NameUnknown, match=r"plant_m.*plant_"):
        draws("plant_m")


def test_readings_of_forces_worked_by_hand():
    t = 0.02 * np.arange(150)
    ramp = np.minimum(100.0 * t / 0.2, 100.0)  # 10 N a sample, exact at the samples
    over = np.where(t >= 1.0, np.where(t < 1.1, 120.0, 94.0), ramp)
    found = judged(t, np.array([ramp, over, 0.5 * ramp, np.full(150, np.nan)]), command=100.0)
    assert found.overshoot[:3] == pytest.approx([0.0, 20.0, 0.0])
    assert found.rise_s[:2] == pytest.approx([0.16, 0.16]) and math.isnan(found.rise_s[2])
    assert found.rise_samples[:2] == pytest.approx([8, 8]) and math.isnan(found.rise_samples[2])
    assert found.steady[:3] == pytest.approx([0.0, 6.0, 50.0])
    climb = 0.02 * sum(100 - 10 * k for k in range(10))
    assert found.iae[:2] == pytest.approx([climb, climb + 0.02 * (5 * 20 + 95 * 6)])
    assert found.bad.tolist() == [False, True, True, True]


def test_rise_between_samples_and_in_whole_samples():
    y = np.array([[0.0, 20.0, 80.0, 95.0, 100.0] + 60 * [100.0]])
    found = judged(0.02 * np.arange(65), y, command=100.0)
    assert found.rise_s[0] == pytest.approx(0.02 * ((2.0 + 10.0 / 15.0) - 0.5))
    assert found.rise_samples[0] == 2


def test_a_share_has_the_interval_of_wilson():
    p, n, z = 10 / 300, 300, 1.959963984540054
    middle, half = p + z * z / (2 * n), z * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    found = share(np.arange(n) < 10)
    assert (found.low, found.high) == pytest.approx(
        ((middle - half) / (1 + z * z / n), (middle + half) / (1 + z * z / n))
    )
    assert found.value == p and "10 of 300" in str(found)


def test_a_comparison_of_four_draws_worked_by_hand():
    no = np.zeros(4, dtype=bool)
    one = Judged(*(np.array(v, dtype=float) for v in ([1, 1, 3, 1], [0.2, 0.21, 0.2, 0.2], [10, 11, 10, 10],
                 [1, 1, 1, 3], [8, 9, 12, 8])), no)  # fmt: skip
    other = Judged(*(np.array(v, dtype=float) for v in ([2, 2, 2, 2], [0.2, 0.2, 0.2, 0.3], [10, 11, 10, 15],
                   [2, 2, 2, 2], [10, 10, 10, 10])), np.array([True, False, False, False]))  # fmt: skip
    found = compared(one, other)
    shares = (found.overshoot, found.steady, found.all_three, found.all_three_between, found.faster, found.iae)
    assert [s.hits for s in shares] == [3, 3, 2, 1, 1, 3]
    assert [s.hits for s in found.bad] == [1, 0] and found.iae_change.value == pytest.approx(-15.0)


def test_random_rules_err_by_one_set_and_are_antisymmetric_where_told():
    even, odd = (
        rough_draws(count=20)["controller.rules"],
        rough_draws(antisymmetric=False, count=20)["controller.rules"],
    )
    index = np.arange(-3, 4)
    standard = np.clip(index[:, None] + index[None, :], -3, 3)
    for tables in (even, odd):
        assert (abs(tables - standard) <= 1).all() and (tables != standard).any(axis=(1, 2)).all()
    assert np.array_equal(even, -even[:, ::-1, ::-1]) and not np.array_equal(odd, -odd[:, ::-1, ::-1])


@pytest.mark.slow
def test_a_draw_of_the_batch_is_that_single_cut(loops):
    block = loops.controllers["corrected.gpfc_b_s9"]
    loop, drawn = loops.get(block, SCENARIO), draws("plant_f", 20)
    together = MonteCarlo(loops).block(block, "plant_f", 20)
    alone = loop.using({k: float(v[17]) for k, v in drawn.items()}).run(3.0, record=("feedback",), run=17)
    single = judged(alone.time, alone["feedback"])
    assert single.overshoot[0] == together.overshoot[17] and single.iae[0] == together.iae[17]


@pytest.mark.slow
def test_controllers_are_compared_under_the_same_noise(loops):
    from leadscrew.controllers.grey_fuzzy import gpfc
    from leadscrew.controllers.grey_fuzzy.tunings import FACTORS, at
    from leadscrew.grey.predictors import LAST

    made = MonteCarlo(loops)
    plain = made.of("corrected.tfc_s9", count=24)
    same = made.block(at(gpfc, FACTORS["s9"], predictor=LAST), "plant_f", 24)  # without prediction it is the TFC
    assert np.array_equal(plain.overshoot, same.overshoot) and np.array_equal(plain.iae, same.iae)


@pytest.mark.slow
def test_a_controller_that_reads_the_programme_is_told_the_depth_that_is_cut(loops):
    loop, drawn = loops.get(power_law_inversion, SCENARIO), draws("plant_f", 3)
    done = loop.batch(0.1, told(loop, drawn), record=("command.depth", "feedback"))
    assert np.array_equal(done["command.depth"][:, 0], drawn["plant.depth.start"])
    assert judge(done).bad.shape == (3,)


@pytest.mark.slow
def test_the_table_of_all_controllers_names_each_with_intervals(loops):
    made = MonteCarlo(loops)
    names = force_controllers(loops)
    assert not any("spindle" in n or "depth_" in n for n in names) and "corrected.tfc_s6" in names
    shown = table({n: made.of(n, count=24) for n in names[:2]})
    assert all(n in shown for n in names[:2]) and shown.count(" to ") == 8


@pytest.mark.slow
def test_other_draws_lie_below_the_digest_too(loops):
    from leadscrew.studies.grey_turning.claims_montecarlo import SAME_FACTORS
    from leadscrew.studies.grey_turning.montecarlo_runs import ran

    loop = loops.get(loops.controllers["corrected.tfc_s6"], SCENARIO)
    seen = share(ran(loop, draws("plant_f", 1200, seed=77)).bad)
    assert seen.low > 0.10 and 100.0 * seen.high < SAME_FACTORS["s6"].bad_tfc


@pytest.mark.slow
def test_the_claim_counts_the_bad_shares_below_the_digest(loops, monkeypatch):
    from leadscrew.studies.grey_turning import claims_montecarlo as claims

    def made(bad):
        three = [np.array([1.0, 2.0, 3.0])] * 5
        each = Judged(*three, np.array(bad))
        kept = MonteCarlo(loops)
        monkeypatch.setattr(kept, "of", lambda *_: each)
        return claims._below_digest(kept)

    none, every = made([False] * 3), made([True] * 3)
    assert (none.measured, none.unit) == (11.0, "of 12")  # one of the digest's is 0 %
    assert every.measured == 0.0 and "above it 12" in every.reason and "above it 0" in none.reason


@pytest.mark.slow
def test_reading_a_is_inside_the_ranges_of_the_digest_under_all_six_sets(loops):
    from leadscrew.studies.grey_turning.claims_montecarlo import SAME_FACTORS

    made = MonteCarlo(loops)
    for factors, digest in SAME_FACTORS.items():
        found = made.pair(f"corrected.gpfc_a_{factors}", f"corrected.tfc_{factors}", digest.plant)
        assert found.overshoot.high >= 0.36 and found.steady.low <= 0.42


@pytest.mark.slow
def test_the_bench_times_the_monte_carlo_in_a_process_of_its_own():
    from leadscrew.bench import turning

    fresh, again = turning.rows(quick=True)
    assert fresh["value"] >= again["value"] > 0.0 and "2 controllers, 300 draws" in fresh["what"]
    assert fresh["passed"] is None and "load" in fresh["remark"] and "s of processor time" in again["remark"]
