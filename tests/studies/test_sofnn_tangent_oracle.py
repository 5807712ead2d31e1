"""The cut, the camera and the controllers of sofnn_tangent against a second, dense writing of them in NumPy."""

import numpy as np
import pytest

from leadscrew.controllers.sofnn import TUNINGS
from leadscrew.neural.inference_net import W0
from leadscrew.studies.sofnn_tangent.runs import Loops
from tests.studies import tangent_oracle as oracle

LITERAL = {"delay": 6, "leak": 0.0, "freeze": False}
BLOCKS = {
    "fixed": (TUNINGS["corrected.fnn"], oracle.FIXED),
    "table": (TUNINGS["corrected.sofnn_table"](**LITERAL), oracle.LITERAL_TABLE),
    "net": (TUNINGS["paper.sofnn_pnn"](**LITERAL), oracle.LITERAL_NET),
    "tuned": (TUNINGS["ours.sofnn_tuned"](leak=0.0, freeze=False), oracle.TUNED),
}
DIGEST = [
    (None, 1.1797, 2.9196, 1.3751),
    (oracle.FIXED, 1.0167, 2.5191, 1.1643),
    (oracle.LITERAL_TABLE, 0.6112, 1.9179, -0.1643),
    (oracle.LITERAL_NET, 0.7680, 2.1530, None),
    (oracle.TUNED, 0.1525, 0.7689, None),
]


@pytest.fixture(scope="module")
def loops():
    return Loops()


@pytest.mark.parametrize(("control", "rms", "most", "at_200"), DIGEST, ids=["none", "fixed", "table", "net", "tuned"])
def test_the_second_writing_gives_the_numbers_of_the_digest(control, rms, most, at_200):
    """Within 0.1 %: what the digest left open has been found."""
    e = oracle.cut(*oracle.wave(), control, W0).e
    assert oracle.numbers(e) == pytest.approx((rms, most), rel=1e-3)
    assert at_200 is None or e[200] == pytest.approx(at_200, rel=2e-3)


@pytest.mark.slow
def test_the_uncompensated_cut_is_the_same_sample_by_sample(loops):
    seen = loops.run("paper.uncompensated", "wave_fabric_quiet")
    expected = oracle.cut(*oracle.wave(), None, W0)
    e = seen["actual.deviation"][1:]
    assert np.abs(e[: len(expected.e)] - expected.e).max() < 1e-8
    assert np.abs(seen["actual.lateral"][1 : len(expected.e) + 1] - expected.lateral).max() < 1e-8


def test_a_pid_is_the_same_sample_by_sample(loops):
    """A derivative behind no lag: the lag of the product is by backward Euler, that of the oracle exact."""
    block = loops.controllers["ours.pid"](filter_s=0.0)
    e = loops.run(block, "wave_fabric_quiet")["actual.deviation"][1:]
    expected = oracle.cut(*oracle.wave(), oracle.Control(pid=(0.7, 14.0, 0.005), filter_s=1e-6), W0).e
    assert np.abs(e[: len(expected)] - expected).max() < 1e-8


@pytest.mark.slow
@pytest.mark.parametrize("name", ["fixed", "table", "net", "tuned"])
def test_networks_are_the_same_sample_by_sample(loops, name):
    """Four rules at a time against dense matrices in Joseph form; the loop's first sample is before the line."""
    block, control = BLOCKS[name]
    seen = loops.run(block, "wave_fabric_quiet")
    expected = oracle.cut(*oracle.wave(), control, W0, waiting=1)
    n = len(expected.e)
    assert np.abs(seen["actual.deviation"][1 : n + 1] - expected.e).max() < 1e-7
    assert np.abs(seen["output"][:n] - expected.d).max() < 1e-7


@pytest.mark.slow
def test_a_change_of_material_under_noise_is_the_same_sample_by_sample(loops):
    """Texture and noise of the product's run go into the oracle; the flower is cut there by its polar equation."""
    block, control = BLOCKS["table"]
    seen = loops.run(block, "flower_change", record=("actual.deviation", "disturbance.texture", "feedback.deviation"))
    heading, curvature = oracle.flower()
    n = len(heading)
    e, texture = seen["actual.deviation"], seen["disturbance.texture"]
    noise = seen["feedback.deviation"] - np.r_[np.zeros(4), e[:-4]]
    assert np.std(noise) == pytest.approx(0.15, rel=0.1) and np.std(texture) == pytest.approx(0.25, rel=0.3)
    half = int(np.argmax(np.arange(n) * 0.5 >= 0.25 * n))
    expected = oracle.cut(
        heading, curvature, control, W0, later="foam", change=half, texture=texture, noise=noise, waiting=1
    ).e
    assert np.abs(e[1 : n + 1] - expected).max() < 1e-6


@pytest.mark.slow
def test_the_second_writing_gives_the_digest_table_of_nine_cells():
    """Section 7, five textures and noises of its own: every cell within 0.05 deg, the mean within 0.02."""
    table = {
        "fixed": [1.03, 0.82, 1.71, 2.32, 1.61, 3.74, 1.79, 1.42, 2.77],
        "bilinear": [0.51, 0.33, 0.85, 1.73, 1.07, 2.84, 1.27, 0.80, 1.90],
        "net": [0.66, 0.40, 1.12, 1.88, 1.16, 3.02, 1.35, 0.84, 2.00],
        "tuned": [0.27, 0.27, 0.27, 1.00, 0.68, 1.38, 0.98, 0.65, 1.15],
        "pid": [0.27, 0.25, 0.34, 1.07, 0.70, 1.66, 0.95, 0.62, 1.26],
    }
    controls = {
        "fixed": oracle.FIXED,
        "bilinear": oracle.LITERAL_TABLE._replace(delay=4),
        "net": oracle.LITERAL_NET._replace(delay=4),
        "tuned": oracle.TUNED,
        "pid": oracle.Control(pid=(0.7, 14.0, 0.005), filter_s=0.02),
    }
    lines = [oracle.wave(), oracle.flower(), oracle.rounded_rectangle()]
    for name, control in controls.items():
        found = []
        for line in lines:
            n = len(line[0])
            for material in oracle.MATERIALS:
                runs = []
                for seed in range(11, 16):
                    rng = np.random.default_rng(seed)
                    texture, noise = oracle.texture_of(n, 0.5, rng), 0.15 * rng.standard_normal(n)
                    e = oracle.cut(*line, control, W0, material, texture=texture, noise=noise).e
                    runs.append(oracle.numbers(e)[0])
                found.append(np.mean(runs))
        assert found == pytest.approx(table[name], abs=0.05), name
        assert np.mean(found) == pytest.approx(np.mean(table[name]), abs=0.02), name
