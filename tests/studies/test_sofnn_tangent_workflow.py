"""The study's workflow without a sensor: its claims, its table made again, its pictures."""

import numpy as np
import pytest

from leadscrew.studies.sofnn_tangent import workflow
from leadscrew.studies.sofnn_tangent.lines import MATERIAL_NAMES


def test_a_piece_of_the_table_comes_out_again():
    found = workflow.trip("rrect", "leather", "scanner", workflow.SEEDS[1], 3)
    kept = workflow.kept_table()["rrect", "leather", "scanner"][1]
    assert kept == pytest.approx([*found.errors, found.largest, found.clipped], abs=2e-4)


@pytest.mark.slow
def test_the_last_run_of_each_case_of_the_table_comes_out_again():
    made = workflow.measured_table(seeds=workflow.SEEDS[-1:])
    kept = workflow.kept_table()
    assert 9 * len(made) == 9 * 5 * 3 * 3 == sum(map(len, kept.values()))
    for drawing, material, scan, seed, *numbers in made:
        row = kept[drawing, material, scan][workflow.SEEDS.index(int(seed))]
        np.testing.assert_allclose(np.array(numbers, dtype=float), row, atol=2e-3)


def test_ratios_of_single_runs_lie_around_that_of_their_means():
    each = workflow.each_ratio(("leaf.svg",), ("leather",), "exact")[0, 0]
    assert each.shape == (9,) and each.min() < workflow.ratios(("leaf.svg",), ("leather",), "exact")[0, 0] < each.max()
    assert each.max() > 1.0 / 3.0  # single runs miss the third


def test_the_table_has_every_drawing_in_every_material_with_every_scan():
    keys = set(workflow.kept_table())
    assert keys == {(d, m, s) for d in ("wave", "flower", "rrect", "leaf.svg", "petal.dxf") for m in MATERIAL_NAMES
                    for s in ("exact", "scanner", "shape")}  # fmt: skip
