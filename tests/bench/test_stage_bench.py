"""The bench of the stage measures what it says: the same loop by hand in C, in SciPy and in ours; judged rows."""

import numpy as np
import pytest

from leadscrew.bench import FIELDS, PARTS, stage
from leadscrew.bench.stage import BEST, NAMES, NM, OURS, SMOOTH, TARGETS, TRUTH, angles, every, rodas
from leadscrew.bench.yardstick import NoCompilerError
from tests.tools import missing


@pytest.fixture(scope="module", params=SMOOTH)
def by_hand(request):
    """The C of one sine."""
    try:
        return stage.ByHand(request.param)
    except NoCompilerError as why:
        missing("gcc", str(why))


def apart(found, truth):
    return NM * np.abs(found - truth[: len(found)]).max()


def test_the_c_by_hand_runs_our_loop(by_hand):
    """RK4 in C and ours are the same method in another order of summation: they agree to femtometres."""
    ours = angles(by_hand.sine, every("rk4", 1.0), 0.3)
    assert apart(by_hand.run("rk4", 1.0, len(ours)), ours) < 1e-6


@pytest.mark.parametrize(
    ("form", "us", "low", "high"),
    [
        ("euler", 2.0, 15.0, 30.0), ("euler", 0.5, 0.4, 0.8), ("rk4", 2.0, 4.0, 6.0), ("rk4", 1.0, 0.0, 1e-4),
        ("implicit", 1.0, 0.9, 1.5), ("split", 1.0, 300.0, 2000.0), ("exponential", 12.5, 0.0, 0.7),
    ],
)  # fmt: skip
def test_each_form_in_c_errs_as_much_as_its_kind_does(by_hand, form, us, low, high):
    """Nanometres; measured once: 22, 0.5, 4.9, 1e-5, 1.0 to 1.4, 1450 to 1720, and 0.5 to 0.6."""
    truth = angles(by_hand.sine, TRUTH)
    assert low <= apart(by_hand.run(form, us, len(truth)), truth) <= high


@pytest.mark.slow
@pytest.mark.parametrize(("method", "rtol", "within_nm"), [("LSODA", 1e-9, 0.01), ("Radau", 1e-5, 0.01)])
def test_scipy_runs_the_same_loop(method, rtol, within_nm):
    truth = angles("sine_fast", TRUTH, 0.02)
    assert apart(stage.scipy_run("sine_fast", method, rtol, len(truth)).angles, truth) < within_nm


@pytest.mark.slow
def test_the_rows_of_a_sine_say_speed_and_error_and_judge_both():
    sine = "sine_fast"
    truth = angles(sine, TRUTH)
    ns = {s.name: 250.0 for s in OURS} | {every("rk4", 1.0).name: 10_000.0}
    rows = stage.our_rows(sine, ns, truth)
    assert all(tuple(r) == FIELDS and r["name"] == NAMES[sine] for r in rows)
    fast = next(r for r in rows if r["what"] == f"ours, {rodas(1e-3).name}")
    assert (fast["value"], fast["target"], fast["passed"]) == (1000.0, ">= 500 x real time", True)
    error = next(r for r in rows if r["what"] == f"error of {rodas(1e-3).name}")
    assert 0.0 < error["value"] <= 0.5
    assert error["error"] == pytest.approx(1e-6 * error["value"])
    assert error["passed"]
    assert rows[-1]["ratio"] == 40.0
    assert rows[-1]["passed"]
    slow = stage.our_rows(sine, dict.fromkeys(ns, 1000.0), truth)
    assert [r["passed"] for r in slow if r["target"].startswith(">=")] == [False, False, False]
    assert len(TARGETS) == 2


def test_without_a_compiler_the_c_rows_say_why():
    rows = stage.c_rows("sine_fast", {}, np.zeros(1), "no gcc on the path")
    assert [(r["value"], r["passed"], r["remark"]) for r in rows] == [(None, None, "left out: no gcc on the path")]


@pytest.mark.slow
def test_a_batch_counts_its_steps():
    rows = stage.batch_rows(quick=True)
    assert [r["what"].rsplit(",", 1)[0] for r in rows[::2]] == [BEST.name, "SDIRK3, scalar, 50 us", "RK4, 1 us"]
    assert all(r["value"] > 1e5 for r in rows)
    assert all(r["passed"] is (r["value"] >= 1e9) for r in rows[1::2])


def test_the_bench_has_the_part():
    assert "stiff friction" in PARTS
