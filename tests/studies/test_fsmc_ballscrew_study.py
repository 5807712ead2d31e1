"""The ball-screw study as a user meets it: names, refusals, verdicts, items."""

import pytest

from leadscrew import resolve
from leadscrew.studies import results
from leadscrew.util.errors import LeadscrewError

STAGE = resolve.study("fsmc_ballscrew")


def test_every_controller_fits_into_every_scenario():
    for name in STAGE.controllers:
        for scenario in STAGE.scenarios:
            loop = STAGE.loop(name, scenario)
            assert loop.continuous == name.startswith(("paper.", "corrected.")), name


def test_values_out_of_range_are_refused_with_their_range():
    with pytest.raises(LeadscrewError, match=r"amplitude_mm = -1.*\(0, 500\]"):
        STAGE.scenario("sine_fast", {"amplitude_mm": -1.0})
    with pytest.raises(LeadscrewError, match=r"inertia"):
        STAGE.loop("ours.pd_dob", "sine_fast", {"plant.inertia": 0.0})


def test_the_verdicts_of_the_key_claims_are_those_that_follow_from_their_numbers():
    found = results.evaluate(STAGE, key=True)
    verdicts = {c.id.removeprefix("fsmc_ballscrew."): c.verdict for c in found.claims}
    assert verdicts["order_of_errors.sine_fast"] == "reproduced with a change"
    assert verdicts["csmc_eliminates_it"] == verdicts["stable_by_the_letter"] == "not reproduced"


def test_every_equation_table_and_figure_of_the_paper_is_an_item():
    items = {line.split(",")[0] for line in (STAGE.folder / "paper_items.csv").read_text().splitlines()}
    assert {f"figure {n}" for n in range(1, 22)} | {f"equation {n}" for n in range(1, 18)} <= items
    assert {"table 1", "table 2"} <= items


def test_the_friction_estimate_from_the_commanded_speed_is_named_as_our_reading():
    assert any("commanded speed" in a.value and a.why.startswith("Our reading") for a in STAGE.assumed)
    for name in ("paper.smc", "paper.csmc", "paper.fsmc", "corrected.smc", "corrected.fsmc"):
        assert STAGE.loop(name, "sine_fast").parameters["controller.friction_from"] == "commanded"
