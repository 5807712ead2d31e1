"""The lathe study as a user meets it: its numbers, figures and items, and its moves in a loop that is not ours."""

import lathe_oracle as oracle
import numpy as np
import pytest
from plain_loop import PERIOD, run_plain

from leadscrew import resolve
from leadscrew.plants._lathe_servo import lathe_servo
from leadscrew.sensors._counts import encoder_count, grating_count
from leadscrew.studies import results
from leadscrew.studies.vud_lathe import laws
from leadscrew.studies.vud_lathe.claims import CORRECTED, OLD, PAPER, PD, metric
from leadscrew.studies.vud_lathe.scenarios import ON_THE_ENCODER, PRINTED_SECONDS, STEPS
from leadscrew.util.errors import DataError, NameUnknown, ValueRefused
from tests.budget import in_every_run
from tests.studies.lathe_lab import lab

STUDY = resolve.study("vud_lathe")


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


def test_the_verdicts_of_the_key_claims_are_those_that_follow_from_their_numbers():
    found = results.evaluate(STUDY, key=True)
    verdicts = {c.id.removeprefix("vud_lathe."): c.verdict for c in found.claims}
    assert verdicts["speed_of_the_printed_law"] == "not reproduced"
    assert verdicts["error_after_2_s.m170"] == "reproduced with a change"
    assert verdicts["old_servo_accuracy"] == "fitted"


def test_every_equation_step_and_figure_of_the_paper_is_an_item():
    items = {line.split(",")[0] for line in (STUDY.folder / "paper_items.csv").read_text().splitlines()}
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
