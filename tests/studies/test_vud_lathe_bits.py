"""Every scenario of the lathe study under every controller: the same bits on every engine."""

import numpy as np
import pytest

from leadscrew.resolve import study
from tests.budget import some
from tests.tools import runnable

LATHE = study("vud_lathe")
FIRST, PLAIN = next(iter(LATHE.scenarios)), "corrected.vud_beta_e"
QUICK = [(c, FIRST) for c in LATHE.controllers] + [(PLAIN, s) for s in LATHE.scenarios if s != FIRST]


def different_loops():
    """Of these, one pair of controller and scenario for each combination of blocks."""
    found = {}
    for c, s in QUICK:
        found.setdefault(tuple(b and b.name for b in LATHE.loop(c, s).blocks.values()), (c, s))
    return list(found.values())


def every_signal(controller, scenario, engine, duration):
    loop = LATHE.loop(controller, scenario)
    return loop.run(duration, record=loop.program.plan.columns, engine=engine)


@pytest.mark.slow
@pytest.mark.parametrize(("controller", "scenario"), different_loops())
def test_python_and_machine_code_agree_on_every_signal(controller, scenario):
    a, b = (every_signal(controller, scenario, e, 0.3) for e in ("python", "llvm"))
    for name in a.signals:
        assert np.array_equal(a[name].view(np.int64), b[name].view(np.int64)), name
    assert dict(a.metrics) == dict(b.metrics) or all(
        x == y or (np.isnan(x) and np.isnan(y)) for x, y in zip(a.metrics.values(), b.metrics.values(), strict=True)
    )


@pytest.mark.sweep
@pytest.mark.parametrize(("controller", "scenario"), some(different_loops(), 3))
def test_all_three_engines_agree_over_the_whole_run(controller, scenario):
    duration = LATHE.scenarios[scenario].duration_s
    runs = [every_signal(controller, scenario, e, duration) for e in ("llvm", "python", runnable("c"))]
    for other in runs[1:]:
        for name in runs[0].signals:
            assert np.array_equal(runs[0][name].view(np.int64), other[name].view(np.int64)), (other.engine, name)


@pytest.mark.slow
def test_a_run_of_a_gain_sweep_is_the_single_run_with_that_gain():
    loop = LATHE.loop("corrected.vud_beta_e", "fig11b_step_m170")
    gains = np.linspace(259.0, 334.0, 20)
    batch = loop.batch(2.0, {"plant.full_duty_speed_mm_s": gains}, record=None)
    for k in (0, 11, 19):
        run = loop.using({"plant.full_duty_speed_mm_s": float(gains[k])}).run(2.0, replicate=k)
        for name in run.signals:
            assert np.array_equal(run.signals[name].view(np.int64), batch.signals[name][k].view(np.int64)), name
