"""The proved law: the loop that is proved is the loop that runs; the search measures what it should."""

import numpy as np
import pytest

from leadscrew.analysis.stability.lmi import driven
from leadscrew.analysis.stability.margins import margins
from leadscrew.controllers._npid_split import parted
from leadscrew.studies.npid_xytable import search
from leadscrew.studies.npid_xytable import split_law as split
from leadscrew.studies.npid_xytable.controllers import BOUNDS, CONTROLLERS
from leadscrew.studies.npid_xytable.cutting import lines_um
from leadscrew.studies.npid_xytable.equal import peaks
from leadscrew.studies.npid_xytable.rejection import let_through, opened
from leadscrew.studies.npid_xytable.table2 import PID_UM
from leadscrew.studies.npid_xytable.tunings import table_pid
from tests.studies.npid_lab import lab

pytestmark = pytest.mark.slow


TUNED = CONTROLLERS["ours.npid_split_rest"]


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


@pytest.mark.parametrize("bound", BOUNDS)
def test_tuned_laws_keep_their_ms_at_every_error_and_are_proved_on_all_the_box(bound):
    """The search has them in closed form, on a grid; here from the steps that run, by exact arithmetic."""
    law = CONTROLLERS[f"ours.npid_split_{bound}"]
    for share in split.SHARES:
        assert margins(split.frozen(law, share)).ms <= 1.602
    assert margins(opened(CONTROLLERS[f"ours.pid_{bound}"])).ms <= 1.602
    for plant in ({}, *split.box_plants()):
        assert driven(split.around_large(law, plant), (0.0, 1.0)).grade == "certificate"
        assert opened(CONTROLLERS[f"ours.pid_{bound}"], plant).stable(1.0)


@pytest.mark.parametrize("bound", BOUNDS)
@pytest.mark.parametrize("law", ["pid_low_pass", "pid_lag"])
def test_laws_behind_filters_keep_their_ms_and_are_stable_on_all_the_box(law, bound):
    """The search has the filters in closed form; here the loops are those of the steps that run."""
    block = CONTROLLERS[f"ours.{law}_{bound}"]
    nominal, box = peaks(law, block.params)
    loops = [opened(block, plant) for plant in split.box_plants()]
    assert margins(opened(block)).ms == pytest.approx(nominal, rel=2e-3) and nominal <= 1.602
    assert all(loop.stable(1.0) for loop in loops)
    assert max(margins(loop).ms for loop in loops) == pytest.approx(box, rel=5e-3)


def test_the_closed_form_of_ms_is_the_largest_over_the_shares():
    p = TUNED.params
    ends = np.array([[*p.quiet]]).T, np.array([[*p.firm]]).T
    largest = max(margins(split.frozen(TUNED, share)).ms for share in np.linspace(0.0, 1.0, 41))
    assert search.largest_ms(ends)[0] == pytest.approx(largest, rel=2e-3)


def test_a_plant_that_is_unstable_or_unproved_is_seen():
    kept, firm = ([[0.5], [60.0], [0.003], [1e-3]], [[0.9], [140.0], [0.0045], [2e-4]])
    assert search.unproved((np.array(kept), np.array(firm)))[0] <= 0.0
    wild = np.array([[8.0], [60.0], [0.003], [1e-3]])
    assert not opened(table_pid(kp=8.0, ki=60.0, kd=0.003, filter_s=1e-3)).stable(1.0)
    assert search.unproved((wild, wild))[0] > 1.0
    steep = 4.0 * np.array(kept)
    steep[3] /= 4.0
    assert search.unproved((np.array(kept), steep))[0] > 0.0


def test_the_rows_of_the_search_are_those_of_a_linear_loop_in_closed_form():
    """Of a linear loop the rows scale with the gain from the disturbance, whatever the phases."""
    block = CONTROLLERS["ours.pid_work"]
    settings = {key: np.array([getattr(block.params, key)]) for key in search.PATH}
    row, du = search.at_work(lab(), table_pid, settings, 1.0)
    ratio = let_through(opened(block)) / let_through(opened(table_pid))
    assert row[0] == pytest.approx(np.mean(list(PID_UM.values()) * ratio), rel=0.03)
    assert search.rest_du_mv(lab(), table_pid, settings)[0] == pytest.approx(du[0], rel=0.1)


def test_a_short_search_finds_a_quieter_law_within_its_bounds():
    found = search.searched(lab(), "pid", rest_mv=1.0, budget=400, seed=3)
    assert found.holds and found.rest_mv <= 1.0 and found.ms <= 1.602
    assert found.row_um < 0.6 * np.mean(list(PID_UM.values())), "less than Table I's PID has"


@pytest.mark.slow
def test_the_law_makes_a_third_harmonic_of_a_large_following_error_and_a_linear_pid_makes_none():
    large, small, linear = (
        lines_um(lab(), *pair)
        for pair in (("ours.npid_split", "sine_15mm"), ("ours.npid_split", "sine_1mm"), ("ours.pid_rest", "sine_15mm"))
    )
    assert large[0] > 0.1 and small[0] < 0.25 * large[0] and (linear < 1e-6).all()
