"""The study as a whole: its loops, its claims, its items and its pictures."""

import csv
import re

import pytest

from leadscrew.catalogue import study
from leadscrew.kernel.errors import LeadscrewError
from leadscrew.studies.fsmc_ballscrew.runs import Loops, tail_um
from leadscrew.studies.fsmc_ballscrew.scenarios import SINES
from tests.studies.contract import WholeStudy, plain
from tests.studies.whole import whole

STAGE = study("fsmc_ballscrew")


def test_every_controller_fits_into_every_scenario():
    for name in STAGE.controllers:
        for scenario in STAGE.scenarios:
            loop = STAGE.loop(name, scenario)
            assert loop.continuous == name.startswith(("paper.", "corrected.")), name


def test_loops_that_differ_in_values_share_a_program_and_give_their_own_bits():
    loops = Loops()
    first, second = (loops.get("ours.pd_dob_fixed", s) for s in SINES[1:])
    assert second.program is first.program
    alone = STAGE.loop("ours.pd_dob_fixed", "sine_fast").run(0.2, record="true_error")["true_error"]
    assert (second.run(0.2, record="true_error")["true_error"] == alone).all()


@pytest.mark.slow
def test_runs_made_ahead_are_the_runs_that_are_asked_for_later():
    ahead, later = Loops(), Loops()
    options = {"changes": {"plant.inertia": 3e-4}}
    ahead.ahead([("ours.pd_dob_fixed", "step_quintic", options), ("ours.pd_dob_fixed", "step_quintic", {})])
    for more in (options, {}):
        a, b = (loops.run("ours.pd_dob_fixed", "step_quintic", **more) for loops in (ahead, later))
        assert (a["true_error"] == b["true_error"]).all()
    kept = ahead.run("ours.pd_dob_fixed", "step_quintic")
    assert ahead.run("ours.pd_dob_fixed", "step_quintic") is kept


def test_the_default_controller_keeps_the_fast_sine_within_130_nm():
    largest, rms = tail_um(Loops().run("ours.pd_dob", "sine_fast"))
    assert largest < 0.13 and rms == pytest.approx(0.043, abs=0.001)


def test_a_bare_step_says_that_its_derivatives_do_not_exist():
    assert "derivatives do not exist" in STAGE.scenario("step_raw").doc


def test_values_out_of_range_are_refused_with_their_range():
    with pytest.raises(LeadscrewError, match=r"amplitude_mm = -1.*\(0, 500\]"):
        STAGE.scenario("sine_fast", {"amplitude_mm": -1.0})
    with pytest.raises(LeadscrewError, match=r"inertia"):
        STAGE.loop("ours.pd_dob", "sine_fast", {"plant.inertia": 0.0})


def test_every_item_of_the_paper_has_a_row_that_says_where_it_is_or_why_not():
    with (STAGE.folder / "paper_items.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    names = [row["item"] for row in rows]
    assert len(names) == len(set(names))
    wanted = {f"figure {n}" for n in range(1, 22)} | {f"equation {n}" for n in range(1, 18)} | {"table 1", "table 2"}
    assert wanted <= set(names)
    assert all(row["where"] or row["status"].startswith("not done: ") for row in rows)


@pytest.fixture(scope="module")
def result():
    return whole(STAGE.name)


@pytest.mark.xdist_group("whole fsmc_ballscrew")
class TestWhole(WholeStudy):
    study = STAGE
    plain_axes = frozenset({"fig16_circles", "fig16_circles_4khz", "fig18_stick_polar", "learned_circle"})
    missed = frozenset(
        {
            "beaten_gms_sine_slow",
            "beaten_gms_sine_wide",
            "beaten_gms_sine_fast",
            "circle_pd_dob_r100",
            "drive_moonshot_late",
        }
    )


@pytest.mark.slow
@pytest.mark.xdist_group("whole fsmc_ballscrew")
def test_order_verdicts_follow_from_the_orders(result):
    claims = plain(STAGE, result.claims)
    orders = {name: c for name, c in claims.items() if name.startswith("paper_order_")}
    assert len(orders) == 10
    for claim in orders.values():
        assert (claim.measured == claim.paper) == claim.verdict.startswith("reproduced"), claim.id
    halves = {name: c for name, c in claims.items() if re.match("paper_half_(sine|step)", name)}
    assert halves and all((c.measured > 1.6) == c.verdict.startswith("reproduced") for c in halves.values())


@pytest.mark.slow
@pytest.mark.xdist_group("whole fsmc_ballscrew")
def test_the_pictures_of_the_paper_are_there(result):
    names = [p.name for p in result.pictures]
    assert {f"fig{n}" for n in (1, 2, 3, 4)} <= {n.split("_")[0] for n in names}
    assert {"fig11_step", "fig17_stick_motion", "fig20_stick_slip", "fig21_radius"} <= set(names)


@pytest.mark.slow
@pytest.mark.xdist_group("whole fsmc_ballscrew")
def test_findings_carry_the_measured_numbers(result):
    claims = plain(STAGE, result.claims)
    text = " ".join(result.notes)
    assert f"{claims['beaten_nominal_sine_fast'].measured:.2g}" in text
    assert f"{1e3 * claims['paper_recovery_sine_slow'].measured:.0f} ms" in text and "nan" not in text
