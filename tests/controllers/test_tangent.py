"""Tables and the observer of a tangential axis: hand-worked values, a second writing, and what the cut shows."""

import math

import numpy as np
import pytest

from leadscrew.controllers._tangent.curvature_feed_forward import curvature_feed_forward
from leadscrew.controllers._tangent.curvature_network import curvature_network
from leadscrew.controllers._tangent.tangent_dob import tangent_dob
from leadscrew.controllers._tangent.taught_offset import taught_alone, taught_offset
from leadscrew.studies.npid_xytable.tunings import table_pid
from leadscrew.util.errors import BlockError, ValueRefused
from tests.controllers.tangent_loop import T, knife

TABLE = np.array([1.0, -2.0, 3.0, 20.0])


def output(controller, samples=8, **options):
    return knife(controller, **options).run(samples * T, record=("output",))["output"]


@pytest.mark.slow
def test_a_table_alone_is_sent_sample_by_sample_and_its_end_held():
    assert output(taught_alone(TABLE, samples=3)).tolist() == [1.0, -2.0, 3.0, 3.0, 3.0, 3.0, 3.0, 3.0]


@pytest.mark.slow
def test_lap_behind_lap_it_starts_again():
    assert output(taught_alone(TABLE, samples=3, laps=1)).tolist() == [1.0, -2.0, 3.0, 1.0, -2.0, 3.0, 1.0, -2.0]


@pytest.mark.slow
def test_it_stays_within_the_axis():
    assert output(taught_alone(TABLE)).tolist()[2:5] == [3.0, 15.0, 15.0]


@pytest.mark.slow
def test_the_table_is_added_to_what_the_controller_sends():
    """Against the same feedback: a PID in its place on the same readings, its own limit above the sum."""
    law = table_pid(kp=0.5, ki=5.0, kd=0.0)
    run = knife(taught_offset(law, TABLE, samples=3), noise=0.15).run(0.4, record=("output", "feedback"))
    added = np.r_[TABLE[:3], np.full(37, 3.0)]
    y, total = run["feedback"], np.cumsum(-run["feedback"]) * T
    assert np.allclose(run["output"], -0.5 * y + 5.0 * total + added, atol=1e-12)


def test_it_takes_what_the_inner_controller_takes():
    assert taught_offset(curvature_feed_forward).step.takes_cut_line
    assert not taught_offset(tangent_dob).step.takes_cut_line
    with pytest.raises(BlockError, match="taught_offset"):
        taught_offset(knife(tangent_dob).blocks["plant"])


@pytest.mark.parametrize("bad", [[], [[1.0, 2.0]], [1.0, math.nan]])
def test_tables_that_are_no_row_of_numbers_are_refused(bad):
    with pytest.raises(ValueRefused):
        knife(taught_alone(bad)).run(T)


def test_more_samples_than_the_table_has_are_refused():
    with pytest.raises(ValueRefused, match="samples = 5"):
        knife(taught_alone(TABLE, samples=5)).run(T)


def observer(y, g=0.9, gain=0.9, late=4):
    """The observer once more, with a list for the past of the axis."""
    past, x, z, sent = [], 0.0, 0.0, []
    for k, reading in enumerate(y):
        past.append(x)
        z += (1.0 - math.exp(-0.5)) * (reading - g * (past[k - late] if k >= late else 0.0) - z)
        sent.append(min(max(-gain * z / g, -15.0), 15.0))
        x += (1.0 - math.exp(-0.5)) * (sent[-1] - x)
    return sent


def test_observer_is_its_second_writing():
    run = knife(tangent_dob, noise=3.0).run(2.0, record=("output", "feedback"))
    assert np.allclose(run["output"], observer(run["feedback"]), atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("gain", [0.5, 0.9, 1.0])
def test_observer_leaves_its_share_of_a_steady_deviation(gain):
    """On a straight line the fabric turns the cut by -14 tanh(0.3 / 14) deg; with g believed right, 1 - gain stays."""
    run = knife(tangent_dob(gain=gain, plant_gain=0.95), size=0.0).run(3.0, record=("actual.deviation",))
    assert run["actual.deviation"][-1] == pytest.approx(-(1.0 - gain) * 14.0 * math.tanh(0.3 / 14.0), abs=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(
    "controller", [tangent_dob, curvature_feed_forward, curvature_network, taught_offset(tangent_dob, [0.7])]
)
def test_taking_over_does_not_jump(controller):
    """After 0.8 s the one before sends 2 deg; without a bumpless start the first offset would be near 0.8 deg."""
    whole = getattr(controller.step, "takes_cut_line", False)
    before = taught_alone([2.0])
    if whole:
        before.step.takes_cut_line = True
    try:
        live = knife(before).start()
    finally:
        if whole:
            del before.step.takes_cut_line
    live.advance(80)
    live = live.switch(controller)
    after = live.advance(300, record=("output", "actual.deviation"))
    assert live.bumpless
    assert after["output"][0] == pytest.approx(2.0, abs=1e-9)
    assert np.abs(after["actual.deviation"][150:]).max() < 1.5


@pytest.mark.sweep
@pytest.mark.parametrize("controller", [tangent_dob, curvature_feed_forward, taught_offset(tangent_dob, TABLE)])
def test_python_and_compiled_give_the_same_bits(controller):
    loop = knife(controller, noise=0.15)
    plain, fast = loop.run(0.5, engine="python"), loop.run(0.5)
    assert all(np.array_equal(plain[name], fast[name]) for name in plain.signals)


def test_a_delay_that_does_not_fit_is_refused():
    with pytest.raises(ValueRefused, match=r"delay_s = 0\.5"):
        knife(tangent_dob(delay_s=0.5)).run(T)
