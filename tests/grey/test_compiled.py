"""Predictors in a compiled loop: all kinds mixed in one batch, and every engine as plain Python."""

import math
from typing import NamedTuple

import numpy as np
import pytest

from leadscrew import Loop, controller, plant, reference
from leadscrew.grey.predictors import KINDS, predicted
from leadscrew.grey.window import Window, pushed
from tests.tools import runnable


class Asked(NamedTuple):
    kind: int = 1
    horizon: float = 1.0


class Kept(NamedTuple):
    window: Window = Window()


@controller(Asked(), Kept())
def predicts(p, s, command):
    window = pushed(s.window, command)
    return Kept(window), predicted(p.kind, window, p.horizon, 150.0, 150.0)


@reference()
def rising(t):
    return 150.0 * (1.0 - math.exp(-t / 0.1) * math.cos(30.0 * t)) if t > 0.1 else 0.0


class Held(NamedTuple):
    value: float = 0.0


@plant(Held(), Held())
def wire(p, s, u, dt):
    return Held(u)


@pytest.fixture(scope="module")
def loop():
    return Loop(reference=rising, controller=predicts, plant=wire, period=0.02, metrics={})


def by_hand(signal, kind, horizon):
    window, out = Window(), []
    for y in signal:
        window = pushed(window, float(y))
        out.append(predicted(kind, window, horizon, 150.0, 150.0))
    return np.array(out)


@pytest.mark.slow
def test_one_batch_mixes_all_predictors(loop):
    batch = loop.batch(1.0, {"controller.kind": np.arange(len(KINDS))}, record=["command", "output"])
    for kind in KINDS.values():
        expected = by_hand(batch["command"][kind], kind, 1.0)
        assert batch["output"][kind] == pytest.approx(expected, rel=1e-12, abs=1e-10)


@pytest.mark.sweep
@pytest.mark.parametrize("engine", ["python", "llvm", "c"])
def test_engines_agree_bit_by_bit(loop, engine):
    one = loop.using({"controller.kind": KINDS["gm11_residual"], "controller.horizon": 2.0})
    expected = one.run(0.5, engine="llvm")["output"]
    assert one.run(0.5, engine=runnable(engine))["output"].tobytes() == expected.tobytes()
