"""Predictors at equal tuning effort: the cost, its noise, the kept factors, and the intervals of the changes."""

import math

import numpy as np
import pytest

from leadscrew.controllers._grey_fuzzy import tfc
from leadscrew.studies.grey_turning import engineers_choice as choice
from leadscrew.studies.grey_turning import equal_effort as effort
from leadscrew.studies.grey_turning.equal_effort import (
    COSTS,
    FACTORS,
    HELD_OUT,
    NAMES,
    PLANTS,
    SCENARIO,
    TUNED_ON,
    Judgement,
    difference,
    judgement,
    lowest,
    search,
    tuned,
    variant,
)
from tests.studies.turning_lab import lab

RECORDED = ("feedback", "actual.force")


def cost_by_hand(run, penalty):
    """J of one run, sample by sample."""
    total, most = 0.0, 0.0
    for t, force, y in zip(run.time, run["actual.force"], run["feedback"], strict=True):
        total += 0.5 * t * (abs(force - 150.0) + abs(y - 150.0)) * 0.02
        most = max(most, y)
    return total + penalty * max(0.0, 100.0 * (most / 150.0 - 1.0) - 1.0)


def loop_of(row):
    loop = lab().loop(variant(row.name, row.plant), SCENARIO, machine=row.plant)
    return loop.using({f"controller.{k}": v for k, v in zip(FACTORS, row.factors, strict=True)})


def test_a_cost_weighs_errors_by_time_ends_with_its_cut_and_has_its_own_penalty():
    t = 0.02 * np.arange(150)
    force = np.full((1, 150), 150.0)
    y = np.where(t < 1.5 - 1e-9, 150.0, 153.0)[None]  # 2 % of overshoot from 1.5 s on, errors of 3 N
    late = t[75:100].sum() * 0.5 * 3.0 * 0.02
    expected = {"short": 0.0, "": late + 0.5, "overshoot": late + 5.0, "long": t[75:].sum() * 0.5 * 3.0 * 0.02 + 0.5}
    for name, value in expected.items():
        assert effort.costs(t, force, y, COSTS[name])[0] == pytest.approx(value), name


def test_judged_noise_is_not_the_noise_that_was_tuned_on():
    assert not set(HELD_OUT) & set(TUNED_ON) and len(set(HELD_OUT)) == 40 and len(TUNED_ON) == 2


def test_every_variant_has_three_searches_a_plant_inside_the_box_and_the_lowest_is_judged():
    rows = tuned()
    assert {(r.plant, r.name, r.search) for r in rows} == {(p, n, s) for p in PLANTS for n in NAMES for s in (1, 2, 3)}
    assert len(rows) == 6 * len(NAMES)
    for row in rows:
        for value, low, high in zip(row.factors, effort.LOW, effort.HIGH, strict=True):
            assert 1.02 * low < value < 0.98 * high
    for under in list(COSTS)[1:]:
        found = tuned(under)
        assert len(found) == 18 and len(lowest(found)) == 6
        for one in lowest(found):
            assert one.cost == min(r.cost for r in found if (r.plant, r.name) == (one.plant, one.name))


@pytest.mark.slow
def test_candidates_beside_each_other_have_the_noise_of_the_run_that_is_told():
    row = tuned()[0]
    block = variant(row.name, row.plant)
    told = lab().loop(block, SCENARIO, machine=row.plant, sensor=effort.repeated_cell)
    done = told.batch(0.5, {"sensor.which": np.array([3, 5, 3])}, record=("feedback",))["feedback"]
    plain = lab().loop(block, SCENARIO, machine=row.plant)
    for k, which in enumerate((3, 5, 3)):
        assert np.array_equal(done[k], plain.run(0.5, record=("feedback",), replicate=which)["feedback"])
    assert not np.array_equal(done[0], done[1])


@pytest.mark.slow
@pytest.mark.parametrize("under", list(COSTS))
def test_the_kept_factors_cost_what_their_searches_said(under):
    cost = COSTS[under]
    for row in [row for row in tuned(under) if row.search == 1]:
        runs = [loop_of(row).run(cost.horizon_s, record=RECORDED, replicate=k) for k in TUNED_ON]
        assert np.mean([cost_by_hand(run, cost.penalty) for run in runs]) == pytest.approx(row.cost, rel=1e-3), row


@pytest.mark.slow
def test_without_prediction_the_variant_is_the_fuzzy_controller_of_the_paper():
    row = tuned()[0]
    assert row.name == "tfc"
    one = judgement(lab(), [row], COSTS[""])[row.plant, "tfc"]
    loop = lab().loop(tfc(**dict(zip(FACTORS, row.factors, strict=True))), SCENARIO, machine=row.plant)
    done = loop.batch(COSTS[""].horizon_s, runs=40, first=HELD_OUT[0], record=RECORDED)
    assert np.array_equal(one.held_out[0], effort.costs_of(done, COSTS[""]))
    assert one.trained == pytest.approx(row.cost, rel=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["gm_h2", "gpfc_a", "residual", "smith"])
def test_variants_judged_beside_each_other_are_judged_as_alone(name):
    rows = [r for r in tuned() if r.search == 1]
    together = judgement(lab(), rows, COSTS[""])
    for plant in PLANTS:
        row = next(r for r in rows if (r.plant, r.name) == (plant, name))
        done = loop_of(row).batch(COSTS[""].horizon_s, runs=40, first=HELD_OUT[0], record=RECORDED)
        assert np.array_equal(together[plant, name].held_out[0], effort.costs_of(done, COSTS[""]))


def test_a_paired_change_has_students_interval():
    other = Judgement(np.array([[4.0, 5.0, 6.0, 5.0]]), 5.0)
    one = Judgement(np.array([[3.0, 4.5, 5.0, 4.5], [4.0, 4.5, 5.0, 4.5]]), 4.5)
    changes = np.array([-0.5, -0.5, -1.0, -0.5]) / 5.0 * 100.0
    half = 3.182446305284263 * changes.std(ddof=1) / math.sqrt(4)  # t of 97.5 %, 3 degrees of freedom
    assert difference(one, other) == pytest.approx((changes.mean(), changes.mean() - half, changes.mean() + half))


@pytest.mark.slow
@pytest.mark.parametrize("plant", PLANTS)
def test_the_search_can_be_done_again_and_ends_where_the_kept_one_did(plant):
    start = search(lab(), plant, "gpfc_b", 1, budget=8)
    once, again = (search(lab(), plant, "gpfc_b", 1, budget=60) for _ in range(2))
    assert once == again and once.cost < start.cost
    kept = next(r for r in tuned() if (r.plant, r.name, r.search) == (plant, "gpfc_b", 1))
    assert search(lab(), plant, "gpfc_b", 1).cost == pytest.approx(kept.cost, rel=0.01)


# ---- what an engineer would use
def test_lathes_of_the_table_lie_in_the_ranges_of_the_searches_and_none_was_seen_by_one():
    from leadscrew.tune.space import Space
    from leadscrew.tune.tuner import held_out_plants

    found = choice.lathes()
    space = Space.of({key: (float(v.min()), float(v.max())) for key, v in found.items()})
    assert found["plant.law.kf"].min() >= 1600.0 and found["plant.law.kf"].max() <= 3200.0 and len(space) == 8
    for part in (1, 2):  # plants of the search, and held out in its file
        for seen in held_out_plants(space, 64, choice.SEED, part).values():
            assert not np.isin(found["plant.law.kf"], seen).any()


def test_the_cost_of_a_cut_is_the_area_of_the_true_error_and_a_price_for_what_exceeds_ten_percent():
    loop = lab().loop("corrected.tfc_s9", "fig6_fixed_depth")
    run = loop.run(1.0, record=("actual.force",))
    force = run["actual.force"]
    over = 100.0 * (force.max() / 150.0 - 1.0)
    assert over > 80.0
    assert run.metrics["cut_cost"] == pytest.approx(0.02 * np.abs(force - 150.0).sum() + over - 10.0, rel=1e-12)


def test_every_controller_of_the_table_was_tuned_with_one_budget_seed_and_goal_for_the_same_lathes():
    from leadscrew import controller_file

    files = [choice.Path(choice.__file__).parent / "tuned" / f"{n[5:-6]}.toml" for n in choice.CHOICE]
    told = [controller_file.read(file).tuning for file in files]
    same = ("budget", "evaluations", "seed", "minimise", "subject_to", "over", "scenarios", "plants", "held_out_plants")
    assert all(one[key] == told[0][key] for one in told for key in same) and len(files) == 11
    assert not any(one.get("notes") for one in told), "no gain lies at an end of its range"
