"""The random plants of turning: what is drawn, how runs are compared, and that all controllers see the same noise."""

import math

import numpy as np
import pytest
from scipy.stats import kstest

from leadscrew.studies.grey_turning.random_plants import (
    COMMON,
    FEEDS,
    KF,
    MACHINES,
    SCENARIO,
    better_in_all,
    drawn,
    draws,
    known,
    share,
)
from leadscrew.studies.grey_turning.readings import Reading, read
from leadscrew.util.errors import NameUnknown
from tests.studies.turning_lab import lab


@pytest.mark.parametrize("plant", ["plant_f", "plant_n"])
def test_every_draw_is_inside_the_ranges_and_can_reach_the_force(plant):
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


def test_fewer_draws_are_the_first_of_more_another_seed_gives_others_and_an_unknown_plant_is_named():
    many, few, other = draws("plant_f", 50), draws("plant_f", 7), draws("plant_f", 7, seed=10)
    for key, values in few.items():
        assert np.array_equal(values, many[key][:7]) and not np.array_equal(values, other[key])
    with pytest.raises(NameUnknown, match=r"plant_m.*plant_"):
        draws("plant_m")


def test_a_share_has_the_interval_of_wilson():
    p, n, z = 10 / 300, 300, 1.959963984540054
    middle, half = p + z * z / (2 * n), z * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    found = share(np.arange(n) < 10)
    ends = ((middle - half) / (1 + z * z / n), (middle + half) / (1 + z * z / n))
    assert (found.low, found.high) == pytest.approx(ends)
    assert found.percent == pytest.approx(100.0 * p) and "10 of 300" in str(found)


def test_a_comparison_of_four_draws_worked_by_hand():
    def reading(overshoot, samples, steady, iae):
        return Reading(
            *(np.array(v, dtype=float) for v in (overshoot, samples, samples, steady, steady, iae)), np.zeros(4)
        )

    one = reading([1, 1, 3, 1], [10, 11, 10, 10], [1, 1, 1, 3], [8, 9, 12, 8])
    other = reading([2, 2, 2, 2], [10, 11, 10, 15], [2, 2, 2, 2], [10, 10, 10, 10])
    assert better_in_all(one, other).hits == 2


@pytest.mark.slow
def test_a_draw_of_the_batch_is_that_single_cut():
    loop, varied = lab().loop("corrected.gpfc_b_s9", SCENARIO), draws("plant_f", 20)
    together = drawn(lab(), "corrected.gpfc_b_s9", count=20)
    alone = loop.using({k: float(v[17]) for k, v in varied.items()}).run(3.0, record=("feedback",), replicate=17)
    single = read(alone["feedback"])
    assert single.overshoot[0] == together.overshoot[17] and single.iae[0] == together.iae[17]


@pytest.mark.slow
def test_controllers_are_compared_under_the_same_noise():
    from leadscrew.grey.predictors import LAST

    plain = drawn(lab(), "corrected.tfc_s9", count=24)
    same = drawn(lab(), "corrected.gpfc_b_s9", count=24, predictor=LAST)  # without prediction it is the TFC
    assert np.array_equal(plain.overshoot, same.overshoot) and np.array_equal(plain.iae, same.iae)


@pytest.mark.slow
def test_a_controller_that_reads_the_programme_is_told_the_depth_that_is_cut():
    loop, varied = lab().loop("ours.inversion", SCENARIO), draws("plant_f", 3)
    done = loop.batch(0.1, known(loop, varied), record=("command.depth",))
    assert np.array_equal(done["command.depth"][:, 0], varied["plant.depth.start"])
    known_, unknown = (drawn(lab(), "ours.constant_force", count=3, depth_known=k).iae for k in (True, False))
    assert not np.array_equal(known_, unknown)


@pytest.mark.slow
def test_the_bench_times_the_random_plants_in_a_process_of_its_own():
    from leadscrew.bench import turning

    fresh, again = turning.rows(quick=True)
    assert fresh["value"] >= again["value"] > 0.0 and "2 controllers, 300 draws" in fresh["what"]
    assert fresh["passed"] is None and "load" in fresh["remark"] and "s of processor time" in again["remark"]
