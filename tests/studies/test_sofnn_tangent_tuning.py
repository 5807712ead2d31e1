"""Tuning with equal effort: what is kept is inside its boxes, and a search finds it again."""

import csv

import numpy as np
import pytest

from leadscrew.studies.sofnn_tangent.lines import PERIOD_S
from leadscrew.studies.sofnn_tangent.runs import SEED, Loops
from leadscrew.studies.sofnn_tangent.tuning import (
    BUDGET,
    LAWS,
    SEARCHES,
    TUNED_ON,
    as_row,
    at_ends,
    best,
    costs,
    found_anew,
    kept,
    of_row,
    spread,
    write,
)


def test_every_law_has_had_the_same_searches_and_lies_in_its_box():
    assert sorted((each.law, each.search) for each in kept()) == sorted((law, s) for law in LAWS for s in SEARCHES)
    for each in kept():
        for key, (low, high) in LAWS[each.law].box.items():
            assert low * (1 - 1e-5) <= each.values[key] <= high * (1 + 1e-5), (each.law, key)
    assert TUNED_ON != SEED, "judged on textures that no search has seen"


def test_no_law_was_held_back_by_an_end_of_its_range():
    """A filter of less than a tenth of a period is none, so that its lower end holds nothing back."""
    for law in LAWS:
        found = best(law)
        none = found.values.get("filter_s", 1.0) < 0.1 * PERIOD_S
        assert set(at_ends(found)) <= ({"filter_s"} if none else set()), law


def test_the_ends_and_the_middle_of_a_box():
    found = spread(np.array([[0.0, 1.0], [0.5, 0.5]]), {"a": (0.1, 10.0), "b": (2.0, 8.0)})
    assert found["a"] == pytest.approx([0.1, 1.0]) and found["b"] == pytest.approx([8.0, 4.0])
    assert spread(np.array([[1.0]]), {"kg": (0.05, 1000.0)})["kg"][0] <= 1000.0, "not a digit beyond its end"


def test_a_file_of_searches_is_read_as_it_was_written(tmp_path):
    write(list(kept()), tmp_path / "again.csv")
    with (tmp_path / "again.csv").open(newline="") as file:
        rows = [of_row(cells) for cells in csv.DictReader(file)]
    assert tuple(rows) == kept() and as_row(rows[0])["law"] == rows[0].law


@pytest.mark.slow
def test_the_kept_settings_cost_what_the_file_says():
    loops = Loops()
    for law in LAWS:
        found = best(law)
        again = costs(loops, law, {key: np.array([x]) for key, x in found.values.items()})
        assert again[0] == pytest.approx(found.cost, rel=2e-4), law
        box = LAWS[law].box
        assert again[0] < costs(loops, law, spread(np.full((1, len(box)), 0.5), box))[0], "better than the box's middle"


@pytest.mark.slow
def test_a_search_of_the_pid_finds_the_kept_gains_again():
    """The whole search on the same textures: the cost to four digits, the gains near those of the file."""
    loops, old = Loops(), next(each for each in kept() if (each.law, each.search) == ("pid", 1))
    new = found_anew(loops, "pid", 1, BUDGET)
    assert new.cost == pytest.approx(old.cost, rel=1e-3)
    middle = costs(loops, "pid", spread(np.full((1, 4), 0.5), LAWS["pid"].box))[0]
    assert new.cost < 0.75 * middle, "a quarter better than where it began"
    for key in ("kp", "ki"):
        assert new.values[key] == pytest.approx(old.values[key], rel=0.05)


@pytest.mark.slow
def test_a_short_search_of_the_observer_improves_on_where_it_began():
    loops = Loops()
    box = LAWS["observer"].box
    middle = costs(loops, "observer", spread(np.full((1, len(box)), 0.5), box))[0]
    assert found_anew(loops, "observer", 1, 60).cost < middle
