"""What the paper says: areas of its Figure 4, its errata, its conclusions; every item has its place."""

import csv
import re

import numpy as np
import pytest

from leadscrew.studies.sofnn_tangent import study
from leadscrew.studies.sofnn_tangent.claims_errata import MISSING, QUANTITIES
from leadscrew.studies.sofnn_tangent.claims_paper import passed_areas, sets_of
from tests.studies.whole import claims_of, whole


def test_the_set_of_a_level_is_the_nearest_and_half_way_it_is_both():
    assert [sets_of(v) for v in (-2.0, 0.0, 2.71, 3.0, -2.63, -0.56, 9.0)] == [
        "NS", "ZO", "PS", "PS or PM", "NS", "ZO", "PB",
    ]  # fmt: skip


def test_areas_are_told_by_the_signs_of_deviation_and_rate():
    e = np.array([-5.0, -3.0, -1.0, 0.5, 0.8, 0.6, 0.2, -0.1])
    ec = np.array([-1.0, 0.5, 0.8, 0.9, 0.3, -0.2, -0.3, -0.3])
    assert passed_areas(e, ec) == ["I", "II", "III"]
    assert passed_areas(np.full(5, -1.0), np.full(5, 0.1)) == ["I"]
    assert passed_areas(np.full(5, -1.0), np.full(5, -0.1)) == []


def test_every_name_of_a_quantity_is_given_once():
    names = [name for given in QUANTITIES.values() for name in given]
    assert len(names) == len(set(names)) == 9 and len(set(MISSING)) == len(MISSING)


def test_every_numbered_part_of_the_paper_has_a_row():
    with (study.STUDY.folder / "paper_items.csv").open(newline="", encoding="utf-8") as file:
        items = [row["item"] for row in csv.DictReader(file)]
    assert len(items) == len(set(items))
    wanted = [f"figure {i}" for i in range(1, 8)] + [f"equation {i}" for i in range(1, 4)]
    wanted += [f"step {i}" for i in range(1, 8)] + [f"erratum {i}" for i in range(1, 20)]
    wanted += ["table 1", "area I", "area II", "area III", "conclusion 1", "conclusion 2"]
    assert set(wanted) <= set(items)


@pytest.mark.slow
@pytest.mark.xdist_group("whole sofnn_tangent")
def test_what_the_paper_says_is_judged_from_the_numbers():
    named = claims_of("sofnn_tangent")
    assert (
        named["paper_offline_training"].verdict == "cannot be checked"
        and named["paper_offline_training"].measured > 0.0
    )
    assert named["paper_compensated_share"].verdict == "cannot be checked"
    assert not [k for k, c in named.items() if "pid" in k and c.paper is not None]  # the paper never mentions one
    assert [named[f"area_{i}_network"].verdict for i in (1, 2, 3)] == ["reproduced"] * 3


@pytest.mark.slow
@pytest.mark.xdist_group("whole sofnn_tangent")
def test_every_erratum_of_this_room_is_shown():
    named = claims_of("sofnn_tangent")
    for number in (3, 8, 11, 12, 13, 14, 15, 18, 19):
        assert [k for k in named if k.startswith(f"erratum_{number}_")], number
    assert named["five_passes_without_threshold"].measured > 2.0 * 0.493
    read_off = ("erratum_13_symbols", "erratum_18_missing", "erratum_19_references")
    assert [named[k].target for k in read_off] == [None] * 3 and all(named[k].kind == "report" for k in read_off)


@pytest.mark.slow
@pytest.mark.xdist_group("whole sofnn_tangent")
def test_the_figures_of_the_paper_are_there():
    names = [p.name for p in whole("sofnn_tangent").pictures]
    assert [n for n in names if re.match(r"fig\d", n)] == [
        "fig4_step_areas", "fig5_trajectory", "fig6_without_compensation", "fig7_with_compensation",
    ]  # fmt: skip
