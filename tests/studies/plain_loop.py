"""The blocks of the lathe study in a plain Python loop: what the engines must give, without any engine."""

from types import SimpleNamespace

import numpy as np

PERIOD = 1e-3


def ready(block):
    """Parameters as the step reads them."""
    return block.prepare(block.params, PERIOD) if block.prepare else block.params


def run_plain(controller, plant, sensor, target, periods):
    """Signals of a step to ``target``, like a run of the loop: ``run.signals[name]``, ``run.time``."""
    pc, pp, ps = ready(controller), ready(plant), sensor.params
    sc, sp = controller.state, plant.state
    names = ("actual.position", "feedback", "output", *(f"controller.{f}" for f in getattr(sc, "_fields", ())))
    rows = np.empty((periods, len(names)))
    for k in range(periods):
        actual = plant.output(pp, sp)
        feedback = sensor.step(ps, actual)
        if sc is None:
            output = controller.step(pc, target, feedback)
        else:
            sc, output = controller.step(pc, sc, target, feedback, PERIOD)
        rows[k] = (actual.position, feedback, output, *(sc or ()))
        sp = plant.step(pp, sp, output, PERIOD)
    return SimpleNamespace(time=np.arange(periods) * PERIOD, signals=dict(zip(names, rows.T, strict=True)))
