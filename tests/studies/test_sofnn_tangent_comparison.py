"""The comparison of sofnn_tangent: what is read off a run, the plain fuzzy controller, the table and its claims."""

import math

import numpy as np
import pytest

from leadscrew.studies.sofnn_tangent.changing import answer, changes_of
from leadscrew.studies.sofnn_tangent.claims_plant import integrated_anew
from leadscrew.studies.sofnn_tangent.comparison import DIGEST, PID, Standing, comparison_of, names_of
from leadscrew.studies.sofnn_tangent.figures_comparison import comparison_pictures
from leadscrew.studies.sofnn_tangent.fixed_fuzzy import system
from leadscrew.studies.sofnn_tangent.runs import Cells, Loops


@pytest.fixture(scope="module")
def loops():
    return Loops()


def test_a_step_response_worked_by_hand():
    """Half a second of rest, then -4, -2, -1, 0.5, -0.1 deg and rest: settled after the fourth sample."""
    e = np.concatenate([np.full(50, 9.0), [-4.0, -2.0, -1.0, 0.5, -0.1], np.zeros(20)])
    found = answer(e)
    assert found.iae == pytest.approx(7.6 * 0.01) and found.settling_s == pytest.approx(0.04)
    assert found.overshoot == 0.5 and found.last == 0.0


def test_a_deviation_that_stays_never_settles():
    assert math.isinf(answer(np.concatenate([np.zeros(50), np.full(50, -4.13)])).settling_s)


@pytest.mark.slow
def test_mamdani_inference_is_max_min_and_the_centroid_of_241_points():
    """By NumPy, from the memberships on: 7 x 7 rules, the output set of the rule is the clipped sum of the two."""
    made, rng = system(), np.random.default_rng(5)
    points = rng.uniform(-7.0, 7.0, (40, 2))
    centres = np.arange(-6.0, 7.0, 2.0)
    grid = -6.0 + 12.0 * (np.arange(241) + 0.5) / 241

    def sets(x):
        return np.maximum(0.0, 1.0 - np.abs(np.clip(x, -6.0, 6.0) - centres) / 2.0)

    shapes = np.array([np.maximum(0.0, 1.0 - np.abs(grid - c) / 2.0) for c in centres])
    for e, de in points:
        heights = np.zeros(7)
        for i, a in enumerate(sets(e)):
            for j, b in enumerate(sets(de)):
                out = min(max(i + j - 3, 0), 6)
                heights[out] = max(heights[out], min(a, b))
        whole = np.minimum(shapes, heights[:, None]).max(axis=0)
        assert made.many([[e, de]]).item() == pytest.approx(float(grid @ whole / whole.sum()), abs=1e-9)


def test_the_allowance_for_chance_is_three_deviations_of_the_difference_of_two_means():
    """Runs 1 2 3 4 5 and 2 2 2 2 2: variances 2.5 and 0, pooled 1.25; 3 sqrt(2/5) sqrt(1.25) and half a digit."""
    one, two = (np.array([[values]], dtype=float) for values in ([1, 2, 3, 4, 5], [2, 2, 2, 2, 2]))
    standing = Standing(Cells(one, one, one), Cells(two, two, two))
    assert standing.allowed().item() == pytest.approx(3.0 * math.sqrt(0.4 * 1.25) + 0.005)
    assert standing.mean == 3.0


def test_the_allowance_of_a_mean_of_cells_knows_which_of_them_share_a_texture():
    """Two lines that scatter alike, in two materials: ours are independent in these, the digest's the same.

    Variances 2.5 and 0 of five runs and three, pooled with 4 and 2 degrees of freedom 5/3; 5/6 for the mean of two.
    """
    one, other = np.full((2, 2, 5), [1.0, 2.0, 3.0, 4.0, 5.0]), np.zeros((2, 2, 3))
    standing = Standing(Cells(one, one, one), Cells(other, other, other))
    assert standing.deviation() == pytest.approx(np.full((2, 2), math.sqrt(5 / 3)))
    assert standing.allowed_mean() == pytest.approx(3.0 * math.sqrt(5 / 6 / 5 + 5 / 3 / 5) + 0.005)
    assert standing.allowed_mean(others=3) == pytest.approx(3.0 * math.sqrt(5 / 6 / 5 + 5 / 3 / 3) + 0.005)
    turned = np.stack([one[0], one[0, :, ::-1]])
    still = Standing(Cells(turned, turned, turned), Cells(other, other, other))
    assert still.allowed_mean() == pytest.approx(0.005), "lines that scatter against each other leave nothing"


@pytest.mark.slow
def test_the_plant_follows_scipy_and_eulers_rule_would_not(loops):
    exact, euler = integrated_anew(loops, samples=30)
    assert exact < 1e-8 < 1e-2 < euler


@pytest.mark.slow
def test_the_table_has_every_controller_and_is_the_same_again(loops):
    made = comparison_of(loops)
    assert set(loops.controllers) < set(made.cells) and set(DIGEST) < set(made.cells)
    assert all(cells.rms.shape == (3, 3, 5) for cells in made.cells.values())
    again = loops.cells(loops.controllers[PID])
    assert np.array_equal(again.rms, made.cells[PID].rms), "the same controller meets the same textures and noises"


@pytest.mark.slow
def test_a_change_of_material_leaves_the_first_half_as_it_was(loops):
    """Until half the way a run with a change is a run without one, and so RMS of the half is below the cell's peak."""
    halves = changes_of(loops).material[PID, "flower"]
    plain = loops.run(PID, "flower_fabric")["actual.deviation"]
    changed = loops.run(PID, "flower_change")["actual.deviation"]
    n = (len(plain) - 2) // 2
    assert np.array_equal(plain[:n], changed[:n]) and not np.array_equal(plain[n + 5 :], changed[n + 5 :])
    assert halves.before[0] == pytest.approx(np.sqrt(np.mean(plain[1 : n + 1] ** 2)), rel=0.01)


@pytest.mark.slow
def test_the_pictures_name_every_row(loops):
    drawn = {picture.name: picture.draw() for picture in comparison_pictures(loops)}
    labels = [text.get_text() for text in drawn["comparison_cells"].axes[0].get_yticklabels()]
    assert len(labels) == len(names_of(loops)) == len(set(labels))
    assert all(figure.axes for figure in drawn.values())
