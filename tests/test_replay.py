"""Where two runs part first, in any bit."""

import math

import numpy as np
import pytest

from leadscrew.replay import _causes, first_difference

TIME = np.array([0.0, 0.5, 1.0, 1.5])
SAVED = {"time": TIME, "x": np.array([1.0, math.nan, 0.0, 4.0]), "y": np.array([1.0, 1.0, 1.0, 1.0])}


def changed(**values):
    """The saved signals with some values replaced: ``name=(row, value)``."""
    now = {k: v.copy() for k, v in SAVED.items()}
    for name, (row, value) in values.items():
        now[name][row] = value
    return now


@pytest.mark.parametrize(
    ("now", "said"),
    [
        (changed(), ""),
        (changed(y=(3, math.nextafter(1.0, 2.0))), "y at row 3, t = 1.5 s: saved 1.0, now 1.0000000000000002"),
        (changed(x=(2, -0.0)), "x at row 2, t = 1 s: saved 0.0, now -0.0"),
        (changed(x=(3, 5.0), y=(1, 2.0)), "y at row 1, t = 0.5 s: saved 1.0, now 2.0"),
        (changed(x=(1, 2.0), y=(3, 2.0)), "x at row 1, t = 0.5 s: saved nan, now 2.0"),
        ({k: v[:3] for k, v in SAVED.items()}, "saved 4 rows, now 3"),
        ({"time": TIME, "x": SAVED["x"]}, "the recorded signals differ: y"),
        ({k: SAVED[k] for k in ("time", "y", "x")}, "the recorded signals differ: their order"),
    ],
)
def test_the_first_row_that_differs_is_named_with_both_values(now, said):
    assert first_difference(SAVED, now) == said


@pytest.mark.parametrize(
    "name",
    ["module", "period_s", "sample_s", "substeps", "method", "computation_delay_s", "transport_delay_s", "blocks",
     "platform", "versions"],
)  # fmt: skip
def test_what_is_not_as_it_was_saved_is_named_as_a_cause(name):
    now = dict.fromkeys(("module", "period_s", "sample_s", "substeps", "method", "computation_delay_s",
                         "transport_delay_s", "blocks", "platform", "versions"), 1)  # fmt: skip
    assert _causes(now, now) == ()
    assert _causes(now | {name: 2}, now) == (f"{name}: saved 2, now 1",)
