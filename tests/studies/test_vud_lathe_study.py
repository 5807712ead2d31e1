"""The lathe study as a user meets it: its numbers, figures and items, and its moves in a loop that is not ours."""

import csv
from pathlib import Path

import lathe_oracle as oracle
import matplotlib.pyplot as plt
import numpy as np
import pytest
from plain_loop import PERIOD, run_plain

from leadscrew import catalogue
from leadscrew.kernel.errors import DataError, NameUnknown, ValueRefused
from leadscrew.plants.lathe_servo import lathe_servo
from leadscrew.sensors.encoder_count import encoder_count
from leadscrew.sensors.grating_count import grating_count
from leadscrew.studies import results
from leadscrew.studies.vud_lathe import laws
from leadscrew.studies.vud_lathe.claims import CORRECTED, OLD, PAPER, PD, metric
from leadscrew.studies.vud_lathe.scenarios import ON_THE_ENCODER, PRINTED_SECONDS, STEPS
from tests.budget import in_every_run
from tests.fuzzy.formats_systems import shared
from tests.studies.lathe_lab import lab

STUDY = catalogue.study("vud_lathe")


@pytest.mark.parametrize("controller", in_every_run([PAPER, CORRECTED, OLD, PD], [CORRECTED, OLD]))
@pytest.mark.parametrize("step", STEPS.values(), ids=STEPS)
def test_the_metrics_of_both_steps_are_those_of_a_plain_python_loop(controller, step):
    block, target = STUDY.controller(controller), -step.way_mm
    sensor = encoder_count if block.name in ON_THE_ENCODER else grating_count
    seconds = PRINTED_SECONDS if controller == PAPER else 4.0
    x = run_plain(block, lathe_servo, sensor, target, round(seconds / PERIOD)).signals["actual.position"]
    assert metric(lab(), controller, step, "settling_1pct") == oracle.settled(x, target, 0.01 * step.way_mm)
    assert metric(lab(), controller, step, "settling_2um") == oracle.settled(x, target, 0.002)
    error = 1000.0 * np.abs(x - target)[2000:].max()
    assert metric(lab(), controller, step, "error_after_2s") == pytest.approx(error, rel=1e-6, abs=1e-4)


def test_the_key_claims_have_their_expected_numbers_and_the_verdicts_that_follow():
    found = results.evaluate(STUDY, key=True)
    assert found.missed == [] and 10 <= len(found.claims) <= 12 and all(c.key for c in found.claims)
    verdicts = {c.id.removeprefix("vud_lathe."): c.verdict for c in found.claims}
    assert verdicts["speed_of_the_printed_law"] == "not reproduced"
    assert verdicts["error_after_2_s.m170"] == "reproduced with a change"
    assert verdicts["old_servo_accuracy"] == "fitted"
    assert len(found.conclusion) == 3 and not any("nan" in sentence for sentence in found.conclusion)


@pytest.mark.slow
@pytest.mark.xdist_group("whole vud_lathe")
def test_every_number_of_the_whole_study_is_expected_and_met():
    done = []
    found = results.evaluate(STUDY, lambda what, share: done.append(share))
    assert done == sorted(done) and done[-1] == 1.0
    assert found.missed == []
    assert set(found.values()) == set(results.expected(STUDY.folder))
    assert [c.id for c in found.claims if not c.note and c.verdict != "reproduced"] == []
    for picture in found.figures:
        drawn = picture.draw(found.lab)
        labels = [t for axes in drawn.axes for t in (axes.get_xlabel(), axes.get_ylabel()) if t]
        assert labels and all("(" in t for t in labels), picture.name
        plt.close(drawn)


def test_every_number_beside_one_of_the_paper_is_what_it_was_before_this_form():
    """``baseline/vud_lathe.csv`` says where each number of the study's first form is now, or why it is gone."""
    now = results.expected(STUDY.folder)
    with (Path(__file__).with_name("baseline") / "vud_lathe.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    with shared("baseline/vud_lathe.csv").open(newline="", encoding="utf-8") as file:
        before = {r["id"].removeprefix("vud_lathe."): r["measured"] for r in csv.DictReader(file) if r["paper"]}
    assert {r["before"] for r in rows} == set(before)
    for row in rows:
        was, is_now = before[row["before"]], row["now"] and now[row["now"]][0]
        if not row["now"]:
            assert row["dropped because"]
        elif is_now == "inf":
            assert was in ("no", ""), row
        else:
            assert is_now == was or float(is_now) == pytest.approx(float(was), rel=1e-9, abs=1e-12), row


def test_items_of_the_paper_and_claims_name_each_other():
    with (STUDY.folder / "paper_items.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    contents = STUDY.contents()
    claimed = {item for c in contents.claims for item in c.items}
    by_kind = {kind: {r["item"] for r in rows if r["covered_by"] == kind} for kind in {r["covered_by"] for r in rows}}
    assert claimed == by_kind["claim"]
    shown = {e.name for e in contents.experiments} | {f.name for f in contents.figures}
    for row in rows:
        assert row["what"] and row["section"] and row["kind"]
        if row["covered_by"] in ("figure", "experiment"):
            assert set(row["where"].split("; ")) <= shown, row["item"]
        if row["covered_by"] in ("code", "data"):
            files = [part.partition(":")[0] for part in row["where"].split("; ")]
            assert all(any((root / f).exists() for root in (STUDY.folder, *STUDY.folder.parents[:2])) for f in files), (
                row
            )
        assert row["status"].startswith("not done: ") == (row["covered_by"] == "none"), row
    items = {row["item"] for row in rows}
    assert {f"equation {n}" for n in range(1, 22)} | {f"step {n}" for n in range(1, 6)} <= items
    assert {f"figure {n}" for n in range(1, 11)} | {"figure 11 a", "figure 11 b", "figure 12"} <= items


def test_table_1_is_read_whole_with_the_sign_that_its_rates_must_have():
    found = laws.moves()
    assert list(found) == ["r=-190", "r=-50", "r=50", "r=190"]
    assert [len(m.time_s) for m in found.values()] == [21] * 4
    assert found["r=50"].rate[1] == -0.420 and found["r=50"].printed_rate[1] == 0.420
    for move in found.values():
        change = np.diff(move.error)
        assert np.sign(move.rate[1:10]).tolist() == np.sign(change[:9]).tolist()


def test_a_table_with_a_duty_beyond_one_or_a_target_twice_is_refused(tmp_path):
    text = laws.TABLE_1.read_text()
    path = tmp_path / "mine.csv"
    path.write_text(text.replace("0.497,1.000", "0.497,1.900", 1))
    with pytest.raises(DataError, match=r"mine\.csv, row 3, column 'rho': 1\.9 is outside"):
        laws.moves(path)
    path.write_text(text + "\n".join(text.splitlines()[1:4]) + "\n")
    with pytest.raises(DataError, match="r=-190 appears in two places"):
        laws.moves(path)


def test_scenarios_and_controllers_are_found_by_name_and_wrong_ones_get_a_hint():
    assert STUDY.scenario("trapezoid_m50", {"target_mm": -20.0}).params.target_mm == -20.0
    with pytest.raises(NameUnknown, match=r"corrected\.vud_beta_e"):
        STUDY.controller("vud_beta_e")
    with pytest.raises(ValueRefused, match=r"target_mm = 500.*\[-190, 190\]"):
        STUDY.scenario("step_p190", {"target_mm": 500.0})


def test_a_machine_like_command_ends_at_the_same_target():
    run = STUDY.loop("ours.pd", "s_curve_m50").run(1.0, record=("command", "actual.position"), engine="python")
    assert run["command"][-1] == -50.0
    assert run["actual.position"][-1] == pytest.approx(-50.0, abs=0.31e-3)
    assert np.abs(run["command"] - run["actual.position"]).max() < 3.0
