"""The lathe study as a user meets it: claims judged without our loop, figures drawn, the paper's items all covered."""

import csv
import io
import json
from types import SimpleNamespace

import lathe_oracle as oracle
import numpy as np
import pytest
from plain_loop import PERIOD, run_plain

from leadscrew.kernel.errors import DataError, NameUnknown, ValueRefused
from leadscrew.plants.lathe_servo import lathe_servo
from leadscrew.sensors.encoder_count import encoder_count
from leadscrew.sensors.grating_count import grating_count
from leadscrew.studies.vud_lathe import figures, runs, tables
from leadscrew.studies.vud_lathe.claims import all_claims
from leadscrew.studies.vud_lathe.claims_arithmetic import arithmetic_claims
from leadscrew.studies.vud_lathe.claims_data import data_claims
from leadscrew.studies.vud_lathe.rules import SETS
from leadscrew.studies.vud_lathe.scenarios import SCENARIOS
from leadscrew.studies.vud_lathe.study import STUDY


class PlainRun(SimpleNamespace):
    """Looks like a run of the loop; its metrics are worked out here, from the whole signal."""

    def __getitem__(self, name):
        return self.signals[name]


def plain(controller, scenario, seconds, speed=289.0):
    target, block = SCENARIOS[scenario].params.target_mm, runs.CONTROLLERS[controller]
    sensor = encoder_count if block.name in runs.ON_THE_ENCODER else grating_count
    plant = lathe_servo(full_duty_speed_mm_s=speed)
    run = run_plain(block, plant, sensor, target, round(seconds / PERIOD))
    x = run.signals["actual.position"]
    run.signals["command"] = np.full_like(x, target)
    metrics = {
        "settling_1pct": oracle.settled(x, target, 0.01 * abs(target)),
        "settling_2um": oracle.settled(x, target, 0.002),
        "overshoot": max(0.0, (np.sign(target) * (x - target)).max()),
        "error_after_2s": np.abs(x - target)[2000:4000].max(),
    }
    return PlainRun(time=run.time, signals=run.signals, metrics=metrics)


@pytest.fixture(scope="module")
def plain_runs():
    steps = [(s, c, t) for s, c, t in runs.plan() if s not in runs.GENTLE]
    done = {f"{s}/{c}": plain(c, s, t) for s, c, t in steps}
    for s in runs.GENTLE:
        for c in ("corrected.vud_beta_e", "ours.pd"):
            done[f"{s}/{c}"] = done[f"{runs.STEPS[1]}/{c}"]
    return done


@pytest.fixture(scope="module")
def claims(plain_runs):
    swept = [plain("corrected.vud_beta_e", runs.STEPS[1], 2.5, speed).metrics for speed in (259.0, 334.0)]
    sweep = SimpleNamespace(metrics={k: np.array([m[k] for m in swept]) for k in swept[0]})
    return {c.id.removeprefix("vud_lathe."): c for c in all_claims(plain_runs, sweep, tables.moves())}


def test_every_required_claim_is_met_and_says_why(claims):
    missed = [c.id for c in claims.values() if c.kind == "required" and c.passed is not True]
    assert missed == []
    assert all(c.reason and c.source and c.statement for c in claims.values())
    assert json.loads(json.dumps([c.as_dict() for c in claims.values()], allow_nan=False))
    assert len(claims) == len({c.id for c in claims.values()}) > 70


def test_the_report_says_plainly_that_the_printed_law_does_not_reproduce(claims):
    assert claims["printed_creep"].verdict == claims["printed_1pct_m170"].verdict == "not reproduced"
    assert claims["printed_creep"].measured == pytest.approx(6.04, abs=0.02)
    assert claims["printed_error_m50"].measured == pytest.approx(37222, abs=1)
    assert claims["table2_complete"].measured == "no"
    assert claims["order_vud_beta_e_m170"].measured == "VUD first"


def test_claims_that_need_no_simulation_are_all_met():
    assert [c.id for c in (*arithmetic_claims(), *data_claims(tables.moves())) if c.passed is False] == []


def test_every_figure_draws_with_labelled_axes(plain_runs):
    example = (SETS.contracted(0.2873), SETS.contracted(0.1484))
    for picture in figures.pictures(plain_runs, tables.moves(), example):
        figure = picture.draw()
        if picture.name in ("universes", "phase", "fig12_error"):
            figure.savefig(io.BytesIO(), dpi=25)
        labels = [text for axes in figure.axes for text in (axes.get_xlabel(), axes.get_ylabel()) if text]
        assert picture.caption and figure.axes[-1].get_xlabel() and figure.axes[0].get_ylabel()
        assert all("(" in text for text in labels)


def test_every_item_of_the_paper_is_covered_or_says_why_not():
    with (STUDY.folder / "paper_items.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["item", "section", "kind", "what", "covered_by", "where", "status"]
    for row in rows:
        assert row["status"].startswith(("done", "not done: ")) and row["what"] and row["section"] and row["kind"]
        assert row["where"] or row["status"].startswith("not done: ")
    items = {row["item"] for row in rows}
    assert {f"equation {n}" for n in range(1, 22)} <= items
    assert {f"step {n}" for n in range(1, 6)} <= items
    numbered = {f"figure {n}" for n in range(1, 11)} | {"figure 11 a", "figure 11 b", "figure 12"}
    assert numbered | {"table 1", "table 2"} <= items


def test_table_1_is_read_whole_with_the_sign_that_its_rates_must_have():
    found = tables.moves()
    assert list(found) == ["r=-190", "r=-50", "r=50", "r=190"]
    assert [len(m.time_s) for m in found.values()] == [21] * 4
    assert found["r=50"].rate[1] == -0.420 and found["r=50"].printed_rate[1] == 0.420
    for move in found.values():
        change = np.diff(move.error)
        assert np.sign(move.rate[1:10]).tolist() == np.sign(change[:9]).tolist()


def test_a_table_with_a_duty_beyond_one_or_a_target_twice_is_refused(tmp_path):
    text = tables.TABLE_1.read_text()
    path = tmp_path / "mine.csv"
    path.write_text(text.replace("0.497,1.000", "0.497,1.900", 1))
    with pytest.raises(DataError, match=r"mine\.csv, row 3, column 'rho': 1\.9 is outside"):
        tables.moves(path)
    path.write_text(text + "\n".join(text.splitlines()[1:4]) + "\n")
    with pytest.raises(DataError, match="r=-190 appears in two places"):
        tables.moves(path)


def test_scenarios_and_controllers_are_found_by_name_and_wrong_ones_get_a_hint():
    assert STUDY.scenario("fig11a_step_m50").params.target_mm == -50.0
    assert STUDY.scenario("trapezoid_m50", {"target_mm": -20.0}).params.target_mm == -20.0
    with pytest.raises(NameUnknown, match=r"corrected\.vud_beta_e"):
        STUDY.controller("vud_beta_e")
    with pytest.raises(ValueRefused, match=r"target_mm = 500.*\[-190, 190\]"):
        STUDY.scenario("step_p190", {"target_mm": 500.0})


def test_the_loop_gives_what_the_plain_loop_gives(plain_runs):
    loop = STUDY.loop("corrected.vud_beta_e", "fig11a_step_m50")
    run = loop.run(2.0, record=("actual.position", "controller.alpha_e"), engine="python")
    expected = plain_runs["fig11a_step_m50/corrected.vud_beta_e"]
    for name in ("actual.position", "controller.alpha_e"):
        assert run[name] == pytest.approx(expected[name][:2000], abs=1e-9)


def test_a_machine_like_command_ends_at_the_same_target():
    loop = STUDY.loop("ours.pd", "s_curve_m50")
    run = loop.run(1.0, record=("command", "actual.position"), engine="python")
    assert run["command"][-1] == -50.0
    assert run["actual.position"][-1] == pytest.approx(-50.0, abs=0.31e-3)
    assert np.abs(run["command"] - run["actual.position"]).max() < 3.0
