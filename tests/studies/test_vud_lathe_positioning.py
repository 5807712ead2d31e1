"""The study's positioning tests against what the screw's equations say, and against plain runs."""

import numpy as np
import pytest

from leadscrew import resolve
from leadscrew.studies.lab import Lab
from leadscrew.studies.vud_lathe import iso_230_2 as ours
from leadscrew.studies.vud_lathe.scenarios import MACHINES, STEPS
from tests.studies.lathe_lab import lab


@pytest.fixture(scope="module")
def tests():
    return {
        "encoder": ours.run_test(lab(), "encoder"),
        "compensated": ours.run_test(lab(), "encoder", compensated=True),
        "grating": ours.run_test(lab(), "grating"),
        "encoder_pd": ours.run_test(lab(), "encoder", "ours.pd"),
    }


def screw_um(x, warming_k):
    """The screw's error at a nominal position, the play left out."""
    p = MACHINES["screw"].plant.params
    slope = p.lead_error + p.expansion * warming_k
    return 1000.0 * (x * slope + p.cyclic_error_mm * np.sin(2.0 * np.pi * x / p.lead_mm))


@pytest.mark.slow
def test_behind_the_encoder_the_mean_deviation_is_the_screws_error(tests):
    passes = np.array([[0.0, 10 * ours.READ_S], [20 * ours.READ_S, 30 * ours.READ_S]])
    starts = (passes[0] + 20 * ours.READ_S * np.arange(ours.RUNS)[:, None]).ravel()
    warming = ours.WARMING_K * np.mean(1.0 - np.exp(-starts / ours.WARMING_S))
    expected = screw_um(np.array(ours.TARGETS_MM), warming)
    # The axis may stop anywhere within a count of 1 um.
    assert tests["encoder"].both.mean == pytest.approx(expected, abs=0.6)
    play_um = 1000.0 * MACHINES["screw"].plant.params.backlash_mm
    for name in ("encoder", "encoder_pd"):
        assert np.abs(tests[name].both.reversal_at).max() < play_um + 1.0


@pytest.mark.slow
def test_the_warming_alone_spreads_the_runs_behind_the_encoder(tests, monkeypatch):
    spread = [x.std(axis=1, ddof=1) for x in (tests["encoder"].up_um, tests["encoder"].down_um)]
    at = np.abs(ours.TARGETS_MM)
    assert all(np.corrcoef(at, s)[0, 1] > 0.95 for s in spread)
    monkeypatch.setattr(ours, "WARMING_K", 0.0)
    cold = ours.run_test(Lab(resolve.study("vud_lathe")), "encoder")
    assert cold.both.repeatability < 1.2 * cold.both.reversal + 0.5 < tests["encoder"].both.repeatability
    assert cold.compensated().both.accuracy < 0.2 * tests["encoder"].compensated().both.accuracy


@pytest.mark.slow
def test_the_first_approach_is_that_of_a_plain_run():
    loop = lab().loop(ours.CONTROLLER, STEPS["m50"].scenario, machine="screw", sensor="grating")
    plain = loop.using({"reference.target": -ours.OVERRUN_MM, "plant.warming_K": 0.0})
    run = plain.run(ours.READ_S + 0.001, record=("actual.position",))
    live = plain.start()
    live.advance(round(ours.READ_S / loop.period), every=0)
    assert ours.table_mm(live) == run["actual.position"][-1]


def test_every_target_is_approached_from_both_sides_with_an_overrun_at_the_ends():
    places = [x for _, _, x in ours.way()]
    before = places[-1:] + places[:-1]
    for (number, upwards, x), last in zip(ours.way(), before, strict=True):
        assert upwards == (x > last)
        assert number < 0 or x == ours.TARGETS_MM[number]
    assert sorted(n for n, _, _ in ours.way()) == sorted([-1, -1, *range(9), *range(9)])


@pytest.mark.slow
def test_what_the_standard_asks_for_is_met(tests):
    assert all(test.notes() == [] for test in tests.values())


def test_the_table_of_the_first_test_takes_away_all_but_the_scatter(tests):
    before, after = tests["encoder"], tests["compensated"]
    assert after.both.accuracy == pytest.approx(before.compensated().both.accuracy, rel=0.1)
    assert after.both.systematic < 0.1 * before.both.systematic
