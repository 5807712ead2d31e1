"""The proved law: the loop that is proved is the loop that runs, the comparison is fair, the searches find it."""

import numpy as np
import pytest

from leadscrew.analysis.stability.driven import driven
from leadscrew.analysis.stability.margins import margins
from leadscrew.controllers.npid_split import parted
from leadscrew.studies.npid_xytable import split_law as split
from leadscrew.studies.npid_xytable.cutting import Trial, lines_um, tried
from leadscrew.studies.npid_xytable.rejection import opened
from leadscrew.studies.npid_xytable.table2 import SPEEDS
from tests.studies.npid_lab import lab

pytestmark = pytest.mark.slow


def gains(block):
    p = block.params
    return np.array([p.kp, p.ki, p.kd, p.filter_s])


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_the_lure_loop_closed_with_a_share_is_the_loop_of_both_paths(share):
    mine = np.sort_complex(split.around_large(split.SPLIT).closed_poles(share))
    theirs = np.sort_complex(split.frozen(split.SPLIT, share).closed_poles(1.0))
    mine, theirs = (x[np.abs(x) > 1e-6] for x in (mine, theirs))
    for pole in theirs:
        assert np.abs(mine - pole).min() < 1e-6


def test_the_loop_that_is_proved_moves_as_the_one_that_runs():
    lure = split.around_large(split.SPLIT)
    run = lab().loop(split.SPLIT, "step_10um").run(0.05)
    law, x, errors = split.SPLIT.params, np.zeros(len(lure.a)), []
    quiet = split.frozen(split.SPLIT, 0.25).b - 0.25 * lure.b  # the quiet path's column, for the command
    for _ in range(len(run["true_error"])):
        e = 1e-2 - float(lure.c[0] @ x)
        errors.append(e)
        x = lure.a @ x + lure.b[:, 0] * (e - parted(law, e)) + quiet[:, 0] * 1e-2
    np.testing.assert_allclose(run["true_error"], errors, atol=1e-12)


@pytest.mark.slow
def test_the_law_is_as_robust_at_every_error_as_the_linear_pid_and_is_proved_on_all_the_box():
    bound = margins(opened(split.LINEAR)).ms
    for share in split.SHARES:
        found = margins(split.frozen(split.SPLIT, share))
        assert found.ms <= bound and found.gm >= 2.0
    for plant in ({}, *split.box_plants()):
        assert driven(split.around_large(split.SPLIT, plant), (0.0, 1.0)).grade == "certificate"


def test_the_law_is_as_quiet_at_rest_as_the_linear_pid_and_both_are_twelve_times_quieter_than_table_i():
    from leadscrew.controllers.pid import pid

    linear, table_i = split.rest_du_mv(lab(), [split.LINEAR, pid])
    assert split.rest_du_mv(lab(), [split.SPLIT])[0] <= linear
    assert table_i > 12.0 * linear


def test_the_formula_of_the_rows_agrees_with_a_run():
    found = tried(lab(), split.LINEAR, draws=1, encoder=False)
    np.testing.assert_allclose(found.rows, split.linear_rows(gains(split.LINEAR)), rtol=0.02)


def test_the_interval_of_a_reduction_holds_what_it_should():
    draw, draws, rest = np.random.default_rng(3), 20, np.zeros(60)
    speeds = np.repeat(SPEEDS, draws)
    hits = []
    for _ in range(200):
        theirs = draw.uniform(1.0, 1.2, (60, 5))
        ours = 0.6 * theirs * (1.0 + 0.1 * draw.normal(size=(60, 5)))
        found = split.reduction(*(Trial(speeds, rows, rest, rest, rest, rest) for rows in (ours, theirs)))
        hits.append(np.append(np.abs(found.rows - 40.0) < found.row_off, abs(found.mean - 40.0) < found.mean_off))
    part = np.mean(hits, axis=0)
    assert np.mean(part[:-1]) == pytest.approx(0.95, abs=0.02) and part[-1] == pytest.approx(0.95, abs=0.05)
    assert found.draws == draws and f"{found.rows.min():.1f} ± {found.row_off[found.least]:.1f} %" in found.words


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_no_linear_pid_under_the_same_bounds_is_found_that_is_better_than_the_one_kept(seed):
    ms, du = split.peak(gains(split.LINEAR)), float(split.rest_du_mv(lab(), [split.LINEAR])[0])
    best = split.best_linear(lab(), ms, du, seed=seed)
    kept, found = (split.linear_rows(gains(b)).mean() for b in (split.LINEAR, best))
    assert found > 0.99 * kept
    assert found < 1.03 * kept  # the search does reach it
    assert split.peak(gains(best)) < 1.01 * ms and split.rest_du_mv(lab(), [best])[0] < 1.01 * du


@pytest.mark.slow
def test_the_search_for_the_law_improves_a_worse_start_under_the_bounds():
    start = split.split_of(split.gains_of(split.SPLIT) * np.array([1, 0.8, 1, 1, 0.9, 0.7, 0.9, 1, 1.3]))
    found = split.searched(lab(), start, tries=60)
    assert split.split_peak(split.gains_of(found)) < 1.01 * split.MS and split.split_room(split.gains_of(found)) > 1.08
    before, after = (tried(lab(), b, draws=1).rows.mean() for b in (start, found))
    assert after < before


@pytest.mark.slow
def test_the_law_makes_a_third_harmonic_of_a_large_following_error_and_a_linear_pid_makes_none():
    large, small, linear = (
        lines_um(lab(), *pair)
        for pair in (("ours.npid_split", "sine_15mm"), ("ours.npid_split", "sine_1mm"), ("ours.pid_quiet", "sine_15mm"))
    )
    assert large[0] > 0.1 and small[0] < 0.25 * large[0] and (linear < 1e-6).all()
