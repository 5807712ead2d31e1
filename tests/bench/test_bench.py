"""The bench measures what it says: the same loop on both sides, and rows that a table can be made of."""

import ctypes
import json

import numpy as np
import pytest

from leadscrew.bench import FIELDS, PARTS, functions, loops, peers, run, threads, yardstick
from leadscrew.bench.measuring import row
from leadscrew.bench.servo import INTEGRATORS
from leadscrew.bench.table import HEAD, markdown
from leadscrew.kernel.portable.powers import pow as portable_pow
from tests.tools import missing


@pytest.fixture(scope="module", params=sorted(INTEGRATORS))
def pair(request):
    """A form of the loop, ours and in C."""
    loop = loops.lathe(request.param)
    try:
        return request.param, loop, yardstick.Yardstick(loop)
    except yardstick.NoCompilerError as why:
        missing("gcc", str(why))


@pytest.mark.parametrize("periods", [1, 2, 800, 4000])
def test_hand_written_c_gives_the_same_bits_as_our_loop(pair, periods):
    form, loop, c = pair
    live = loop.start()
    live.advance(periods, every=0)
    assert yardstick.same_bits(c.run(f"{form}_portable", periods), live)
    assert yardstick.same_bits(c.run(f"{form}_shortcut", periods), live)


def test_the_power_in_c_is_the_kernels_for_all_doubles(pair):
    edges = [0.0, 1.0, 2.0, 3.0, 0.5, 1e-320, 2.0**53 + 2, 1e300, 1.7e308, float("inf")]
    edges += [-x for x in edges] + [float("nan")]
    drawn = np.random.default_rng(1).integers(-(2**63), 2**63, size=(2, 2000), dtype=np.int64).view(np.float64)
    grid = np.array([(x, y) for x in edges for y in edges]).T
    near = np.random.default_rng(2).uniform((0.0, -5.0), (3.0, 5.0), (2000, 2)).T
    x, y = np.ascontiguousarray(np.concatenate([drawn, grid, near], axis=1))
    out = np.empty_like(x)
    at = [v.ctypes.data_as(ctypes.c_void_p) for v in (x, y, out)]
    pair[2].library.pow_portable_points(*at, ctypes.c_long(x.size))
    ours = np.array([portable_pow(a, b) for a, b in zip(x.tolist(), y.tolist(), strict=True)])
    assert np.array_equal(np.isnan(out), np.isnan(ours))
    real = ~np.isnan(ours)
    assert out[real].tobytes() == ours[real].tobytes()


def test_c_with_libm_is_close_but_another_program(pair):
    form, _, c = pair
    ours, theirs = c.run(f"{form}_portable", 800), c.run(f"{form}_libm", 800)
    assert theirs.position == pytest.approx(ours.position, abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("form", sorted(INTEGRATORS))
def test_plain_python_runs_the_same_loop(form):
    loop = loops.lathe(form)
    by_hand = np.array(getattr(peers, form)(yardstick.Yardstick.parameters(loop), 300))
    assert np.abs(by_hand - peers.positions(loop, 300)).max() < 1e-9


def test_both_forms_are_as_accurate_as_the_bench_says():
    _, errors = peers.accuracy(20)
    assert errors["hold"] < 1e-12
    assert errors["rk4"] < 1e-7


@pytest.mark.parametrize("fused", [False, True])
@pytest.mark.parametrize("substeps", [1, loops.SUBSTEPS])
def test_python_control_runs_the_same_loop(fused, substeps):
    p = yardstick.Yardstick.parameters(loops.lathe())
    theirs = peers.python_control(p, 40, substeps, fused)
    form = "hold" if substeps == 1 else "rk4"
    assert np.abs(theirs - peers.positions(loops.lathe(form), 40)).max() < 1e-9


def test_rows_have_the_schema_and_one_verdict_each():
    rows = run(quick=True, parts=("settled loops",))
    assert [r["name"] for r in rows] == ["machine", "settled loop, hold", "settled loop, rk4", "machine"]
    for r in rows:
        assert tuple(r) == FIELDS
        assert (r["passed"] is None) == (r["target"] == "" or r["value"] is None)
    assert json.loads(json.dumps(rows, allow_nan=False)) == rows
    assert PARTS[0] == "threads"
    lines = markdown(rows).splitlines()
    assert len(lines) == 2 + len(rows)
    assert all(line.count("|") == len(HEAD) + 1 for line in lines)


@pytest.mark.slow
@pytest.mark.parametrize(("load", "judged"), [(0.1, True), (2.0, False), (None, False)])
def test_threads_are_judged_on_an_idle_machine_only(monkeypatch, load, judged):
    monkeypatch.setattr(threads, "load", lambda: load)
    last = threads.rows(1, 32, {})[-1]
    assert last["target"] == ">= 1.7 x"
    assert (last["passed"] is not None) == judged
    assert last["remark"].startswith("machine not idle: load") != judged


@pytest.mark.parametrize(("ratio", "passed"), [(np.float64(1.0), True), (np.float64(2.0), False), (None, None)])
def test_a_verdict_is_true_false_or_none(ratio, passed):
    assert row("a", "b", None if ratio is None else 3.0, ratio=ratio, at_most=1.5)["passed"] is passed


def test_without_a_compiler_the_rows_say_why(monkeypatch):
    monkeypatch.setattr(yardstick.shutil, "which", lambda name: None)
    with pytest.raises(yardstick.NoCompilerError, match="gcc"):
        yardstick.build()
    assert functions.libm(1) == {}
