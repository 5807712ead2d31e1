"""The noise-free deviations of an earlier, independent simulation, and the same loop in a second writing."""

import numpy as np
import pytest

from leadscrew.controllers._sofnn import fnn, sofnn
from leadscrew.neural.inference_net import W0
from leadscrew.studies.sofnn_tangent.tunings import TUNINGS
from tests.controllers.sofnn_loop import QUIET, knife_loop, rms
from tests.studies import tangent_oracle

PLAIN = {"leak": 0.0, "freeze": False}
GOLDEN = {
    # RMS, largest, e at sample 200, deg
    "none": (fnn(rules=np.zeros(49)), None, 1.1797, 2.9196, 1.3751),
    "fixed": (fnn, tangent_oracle.FIXED, 1.0167, 2.5191, 1.1643),
    "table": (sofnn(**PLAIN), tangent_oracle.LITERAL_TABLE, 0.6112, 1.9179, -0.1643),
    "network": (sofnn(source=2, **PLAIN), tangent_oracle.LITERAL_NET, 0.7680, 2.1530, None),
    "tuned": (TUNINGS["ours.sofnn_tuned"](**PLAIN), tangent_oracle.TUNED, 0.1525, 0.7689, None),
}


@pytest.fixture(scope="module")
def line():
    return tangent_oracle.wave()


CASES = [c if c == "tuned" else pytest.param(c, marks=pytest.mark.slow) for c in GOLDEN]


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_the_deviations_of_the_earlier_simulation_come_out_within_two_percent(case, line):
    block, _, root, most, at_200 = GOLDEN[case]
    e = knife_loop(block, *line).using(QUIET).run(9.24)["actual.deviation"][1:]
    assert len(e) == 923 and rms(e) == pytest.approx(root, rel=0.02) and abs(e).max() == pytest.approx(most, rel=0.02)
    if at_200 is not None:
        assert e[200] == pytest.approx(at_200, rel=0.02)


@pytest.mark.parametrize("case", CASES)
def test_the_loop_is_what_a_second_writing_of_it_gives(case, line):
    # there the plant steps before the controller, here after it: what it does in the first period does not count
    block, control, *_ = GOLDEN[case]
    loop = knife_loop(block.starting(**{"watch.known": -1}), *line).using({**QUIET, "disturbance.size": 0.25})
    run = loop.run(9.24, record=("actual.deviation", "actual.lateral", "disturbance.texture"))
    other = tangent_oracle.cut(*line, control, W0, texture=run["disturbance.texture"][:-1])
    assert abs(run["actual.deviation"][1:] - other.e).max() < 1e-9
    assert abs(run["actual.lateral"][1:] - other.lateral).max() < 1e-9
