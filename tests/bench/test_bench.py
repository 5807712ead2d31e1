"""The bench measures what it says: the same loop on both sides, and rows that a table can be made of."""

import numpy as np
import pytest

from leadscrew.bench import FIELDS, functions, loops, others, plain, run, yardstick
from leadscrew.bench.servo import INTEGRATORS


@pytest.fixture(scope="module", params=sorted(INTEGRATORS))
def pair(request):
    """A form of the loop, ours and in C."""
    loop = loops.lathe(request.param)
    try:
        return request.param, loop, yardstick.Yardstick(loop)
    except yardstick.NoCompilerError as why:
        pytest.skip(str(why))


@pytest.mark.parametrize("periods", [1, 2, 800, 4000])
def test_hand_written_c_gives_the_same_bits_as_our_loop(pair, periods):
    form, loop, c = pair
    live = loop.start()
    live.advance(periods, every=0)
    assert yardstick.same_bits(c.run(f"{form}_portable", periods), live)


def test_c_with_libm_is_close_but_another_program(pair):
    form, _, c = pair
    ours, theirs = c.run(f"{form}_portable", 800), c.run(f"{form}_libm", 800)
    assert theirs.position == pytest.approx(ours.position, abs=1e-3)


@pytest.mark.parametrize("form", sorted(INTEGRATORS))
def test_plain_python_runs_the_same_loop(form):
    loop = loops.lathe(form)
    by_hand = np.array(getattr(plain, form)(yardstick.Yardstick.parameters(loop), 300))
    assert np.abs(by_hand - others.positions(loop, 300)).max() < 1e-9


def test_both_forms_are_as_accurate_as_the_bench_says():
    _, errors = others.accuracy(20)
    assert errors["hold"] < 1e-12
    assert errors["rk4"] < 1e-7


def test_rows_have_the_schema_and_one_verdict_each():
    rows = run(quick=True, parts=("settled loops",))
    assert rows
    for row in rows:
        assert tuple(row) == FIELDS
        assert (row["passed"] is None) == (row["target"] == "" or row["value"] is None)


def test_without_a_compiler_the_rows_say_why(monkeypatch):
    monkeypatch.setattr(yardstick.shutil, "which", lambda name: None)
    with pytest.raises(yardstick.NoCompilerError, match="gcc"):
        yardstick.build()
    assert functions.libm(1) == {}
