"""The C that is printed: the same bits as machine code and plain Python, for every block at each optimisation level."""

import ctypes
import os
import shutil
import subprocess
import sys
import warnings

import numpy as np
import pytest

from leadscrew import catalogue
from leadscrew.kernel import engines
from leadscrew.kernel.c99.translation import entry_text
from leadscrew.kernel.engines import Entry
from leadscrew.kernel.program import RANKS
from tests.budget import WHOLE
from tests.kernel import test_engines
from tests.kernel.loops import around, varied
from tests.tools import missing

PERIODS = 10_000 if WHOLE else 2000
PLAIN = 2000 if WHOLE else 200
"""Periods in plain Python, the second opinion of both compiled engines, which share the front of the compiler."""
CASES = 3 if WHOLE else 2
"""The parameters of the catalogue, and further ones."""
STRICT = ("-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror", "-ffp-contract=off")
LEVELS = ("-O0", "-O2", "-O3")


@pytest.fixture(scope="module", autouse=True)
def gcc():
    if shutil.which("gcc") is None:
        missing("gcc", "gcc is not installed")


def entry_at(loop, folder, level) -> Entry:
    """A loop's single run from C in which every function is one of its own, as an export has it."""
    source = entry_text(loop.program.module, "single", RANKS["single"], fused=False)
    made = engines.shared_library(source, folder, f"single{level[1:]}", *STRICT, level)
    address = ctypes.cast(ctypes.CDLL(str(made)).single, ctypes.c_void_p).value
    order = [RANKS["single"][a] for a in loop.program.module.arguments_of("single")]
    return Entry("single", order, address)


def recorded(loop, engine="llvm", entry=None, periods=PERIODS):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        live = loop.start(engine=engine)
        live.entry = entry or live.entry
        return live.advance(periods, record=loop.program.plan.columns)


def assert_same(a, b):
    assert a.signals.keys() == b.signals.keys()
    for column in a.signals:
        assert a[column].shape == b[column].shape
        assert test_engines.same(a[column], b[column]), column
    assert str(a.diverged) == str(b.diverged)


def moves(run) -> bool:
    return any(np.ptp(run[c][np.isfinite(run[c])]) > 0 for c in run.signals if c != "time")


QUICK = (
    "eased_sine_motion", "quintic", "grating_counter", "lathe_reading", "npid", "pd_dob", "vud_fast", "torque_drive",
    "ballscrew_stage", "ballscrew_gms", "turning", "xy_table_cutting", "five_sines", "metrics.rise_time",
)  # fmt: skip
"""One of each kind, and those that use most of the language: arrays, loops, integers, stiff integrators, `prepare`."""


@pytest.mark.parametrize("name", QUICK)
def test_blocks_of_every_kind_on_the_engine_c_is_what_machine_code_computes(name):
    """At one level and one set of parameters; the next test does the rest, for every block."""
    loop = around(name)
    expected = recorded(loop, periods=1000)
    assert moves(expected)
    assert_same(recorded(loop, engine="c", periods=1000), expected)


@pytest.mark.slow
@pytest.mark.parametrize("name", catalogue.BLOCKS)
def test_every_block_in_c_is_what_machine_code_and_plain_python_compute(name, tmp_path):
    """C as an export has it, at one level of optimisation in turn, and the engine's own."""
    loop = around(name)
    number = catalogue.block_names().index(name)
    entries = [entry_at(loop, tmp_path, level) for level in (LEVELS if WHOLE else (LEVELS[number % 3],))]
    rng = np.random.default_rng(number)
    for case in range(CASES):
        mine = varied(loop, rng) if case else loop
        expected = recorded(mine)
        assert moves(expected)
        assert_same(recorded(mine, engine="python", periods=PLAIN), recorded(mine, periods=PLAIN))
        for entry in entries:
            assert_same(recorded(mine, entry=entry), expected)
        if WHOLE or case:
            assert_same(recorded(mine, engine="c"), expected)


@pytest.mark.parametrize("name", test_engines.LOOPS)
def test_loops_of_all_kinds_in_c(name, tmp_path):
    loop = test_engines.made(name)
    expected = recorded(loop, periods=1000)
    assert_same(recorded(loop, engine="c", periods=1000), expected)
    for level in LEVELS:
        assert_same(recorded(loop, entry=entry_at(loop, tmp_path, level), periods=1000), expected)


@pytest.mark.parametrize("name", ["pid", "everything", "two axes"])
def test_a_batch_in_c(name):
    loop = test_engines.made(name)
    a, b = (loop.batch(0.2, runs=37, engine=e, record=("output",)) for e in ("llvm", "c"))
    for column in a.signals:
        assert test_engines.same(a[column], b[column]), column
    assert a.metrics.keys() == b.metrics.keys()


def test_with_contraction_the_bits_would_differ(tmp_path):
    """What -ffp-contract=off is for, and that this comparison can fail."""
    loop = around("lathe_servo")
    if (
        "fma"
        not in subprocess.run(["gcc", "-march=native", "-Q", "--help=target"], capture_output=True, text=True).stdout
    ):
        pytest.skip("fma: this processor has none")
    source = entry_text(loop.program.module, "single", RANKS["single"])
    flags = ("-std=gnu99", "-O2", "-mfma", "-ffp-contract=fast")
    made = engines.shared_library(source, tmp_path, "fused", *flags)
    address = ctypes.cast(ctypes.CDLL(str(made)).single, ctypes.c_void_p).value
    order = [RANKS["single"][a] for a in loop.program.module.arguments_of("single")]
    got, expected = recorded(loop, entry=Entry("single", order, address)), recorded(loop)
    assert any(not test_engines.same(got[c], expected[c]) for c in expected.signals)


def test_without_a_compiler_the_engine_says_what_to_do(monkeypatch):
    from leadscrew.util.errors import EngineError

    monkeypatch.setenv("PATH", "/nonexistent")
    monkeypatch.delenv("CC", raising=False)
    engines.c_compiler.cache_clear()
    with pytest.raises(EngineError, match="install gcc, or use engine='llvm'"):
        engines.c_compiler()
    engines.c_compiler.cache_clear()


def test_the_engine_c_does_not_import_llvm(tmp_path):
    code = (
        "import sys; from leadscrew.bench.loops import lathe; run = lathe('rk4').run(0.1, engine='c');"
        "print(len(run.time), [m for m in ('llvmlite', 'scipy') if m in sys.modules])"
    )
    env = {**os.environ, "LEADSCREW_CACHE_DIR": str(tmp_path)}
    for _ in range(2):
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=env, check=True)
        assert done.stdout.strip() == "100 []"
    assert len(list(tmp_path.rglob("*.so"))) == 1
