"""The cut, the camera and the controllers of sofnn_tangent against a second, dense writing of them in NumPy."""

import numpy as np
import pytest

from leadscrew.neural.inference_net import W0
from leadscrew.resolve import study
from leadscrew.studies.results import expected
from leadscrew.studies.sofnn_tangent.cuts import FIXED, NONE, PID, PNN, TABLE, TUNED, deviations
from tests.studies import tangent_oracle as oracle
from tests.studies.tangent_lab import lab

LITERAL = {"controller.leak": 0.0, "controller.freeze": False, "controller.delay": 6}
QUIET = "wave_fabric_quiet"


def test_the_uncompensated_cut_is_the_same_sample_by_sample():
    run, second = lab().run(NONE, QUIET), oracle.cut(*oracle.wave(), None, W0)
    n = len(second.e)
    assert np.abs(run["actual.deviation"][1 : n + 1] - second.e).max() < 1e-8
    assert np.abs(run["actual.lateral"][1 : n + 1] - second.lateral).max() < 1e-8


def test_a_pid_is_the_same_sample_by_sample():
    """A derivative behind no lag: the lag of the product is by backward Euler, that of the oracle exact."""
    second = oracle.cut(*oracle.wave(), oracle.Control(pid=(0.7, 14.0, 0.005), filter_s=1e-6), W0).e
    live = lab().loop(PID, QUIET).using({"controller.filter_s": 0.0}).start()
    assert np.abs(deviations(live, len(second)) - second).max() < 1e-8


@pytest.mark.slow
def test_a_change_of_material_under_noise_is_the_same_sample_by_sample():
    """Texture and noise of the product's run go into the oracle; the flower is cut there by its polar equation."""
    signals = ("actual.deviation", "disturbance.texture", "feedback.deviation")
    run = lab().loop(TABLE, "flower_change").using(LITERAL).run(7.9, record=signals)
    heading, curvature = oracle.flower()
    e, texture = run["actual.deviation"], run["disturbance.texture"]
    noise = run["feedback.deviation"] - np.r_[np.zeros(4), e[:-4]]
    assert np.std(noise) == pytest.approx(0.15, rel=0.1) and np.std(texture) == pytest.approx(0.25, rel=0.3)
    n = len(texture) - 1
    half = int(np.argmax(np.arange(n) * 0.5 >= 0.25 * len(heading)))
    more = {"later": "foam", "change": half, "texture": texture, "noise": noise, "waiting": 1}
    second = oracle.cut(heading[:n], curvature[:n], oracle.LITERAL_TABLE, W0, **more).e
    assert np.abs(e[1 : n + 1] - second).max() < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize(("assumed", "late"), [(8, 6), (6, 4), (12, 12), (4, 2)])
def test_a_step_with_a_wrong_delay_is_that_of_the_second_writing(assumed, late):
    samples, at = 300, 50
    texture, straight = np.where(np.arange(samples) >= at, -5.0, 0.0), np.zeros(samples)
    control = oracle.Control(k_e=0.4, delay=assumed)
    cut = oracle.cut(straight, straight, control, W0, texture=texture, sensor_delay=late, bias=0.0, waiting=1)
    changes = {"controller.k_e": 0.4, "controller.delay": assumed, "sensor.trailing_s": late * 0.01}
    loop = lab().loop(TABLE, "step").using({**changes, "disturbance.step_at": at * 0.01})
    assert deviations(loop.start(), samples) == pytest.approx(cut.e, abs=1e-6)


@pytest.mark.slow
def test_nine_cells_by_the_second_writing_have_the_means_of_the_study():
    """Lines, textures and noises of its own: the mean RMS of nine cells and three runs within 0.03 deg."""
    controls = {
        FIXED: oracle.FIXED,
        TABLE: oracle.LITERAL_TABLE._replace(delay=4),
        PNN: oracle.LITERAL_NET._replace(delay=4),
        TUNED: oracle.TUNED,
        PID: oracle.Control(pid=(0.7, 14.0, 0.005), filter_s=0.02),
    }
    lines = [oracle.wave(), oracle.flower(), oracle.rounded_rectangle()]
    study_ = expected(study("sofnn_tangent").folder)
    for name, control in controls.items():
        found = []
        for line in lines:
            n = len(line[0])
            for material in oracle.MATERIALS:
                for seed in range(11, 14):
                    rng = np.random.default_rng(seed)
                    texture, noise = oracle.texture_of(n, 0.5, rng), 0.15 * rng.standard_normal(n)
                    e = oracle.cut(*line, control, W0, material, texture=texture, noise=noise).e
                    found.append(np.sqrt(np.mean(e**2)))
        mean = float(study_[f"all_controllers/{name}/RMS deviation (deg)"][0])
        assert np.mean(found) == pytest.approx(mean, abs=0.03), name
