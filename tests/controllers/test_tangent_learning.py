"""What the feed-forward and the rules of the curvature learn: against batch least squares of the recorded signals."""

import math

import numpy as np
import pytest

from leadscrew.controllers._tangent.curvature_feed_forward import curvature_feed_forward
from leadscrew.controllers._tangent.curvature_network import apart_covariance, curvature_network, start_covariance
from leadscrew.neural.inference_net import Fired
from leadscrew.neural.kalman import kalman_learn
from leadscrew.references._cut_line import TangentCommand
from leadscrew.sensors._cut_camera import SeenCut
from leadscrew.util.errors import ValueRefused
from tests.controllers.tangent_loop import knife

SEEN = ("command", "feedback", "output")
LATE = 4
RULES_APART = curvature_network(prior_covariance=apart_covariance(), k_c=36.0, k_h=36.0, gain=0.0)
CENTRES = np.linspace(-6.0, 6.0, 7)


def controller_state(live):
    return live.program.plan.state.unpack(live.state[0].copy(), live.state[1].copy()).controller


def lived(controller, seconds, **options):
    """A run, and the controller's state at its end."""
    live = knife(controller, **options).start()
    run = live.advance(round(seconds * 100), record=SEEN)
    return run, controller_state(live)


def axis_of(sent):
    """The axis as believed, at the start of every period."""
    x = np.zeros(len(sent) + 1)
    for k, d in enumerate(sent):
        x[k + 1] = x[k] + (1.0 - math.exp(-0.5)) * (d - x[k])
    return x[:-1]


def unexplained(run):
    """What the offset does not explain of each reading from the first that shows the line on, and its place."""
    c = run["feedback.deviation"].copy()
    c[LATE:] -= 0.9 * axis_of(run["output"])[: len(c) - LATE]
    return c[LATE + 1 :], np.arange(len(c) - LATE - 1)


def direction(run):
    turned = np.radians(2.0 * run["command.heading"])
    return np.sin(turned), np.cos(turned)


def least_squares(rows, targets, covariance, noise):
    """Mean of the weights after all rows, from the start covariance and a mean of 0."""
    gain = covariance @ rows.T @ np.linalg.inv(rows @ covariance @ rows.T + noise * np.eye(len(rows)))
    return gain @ targets


def test_feed_forward_learns_the_least_squares_weights():
    run, state = lived(curvature_feed_forward(forgetting=1.0, trace_cap=1e6), 5.0, noise=0.15)
    c, at = unexplained(run)
    kappa = run["command.curvature"]
    lagged = [np.where(at >= lag, 30.0 * kappa[np.maximum(at - lag, 0)], 0.0) for lag in (0, 3, 8, 16)]
    rows = np.column_stack([*lagged, *(part[at] for part in direction(run)), np.ones(len(at))])
    assert len(c) > 400
    assert np.allclose(state.weights, least_squares(rows, c, 0.03 * np.eye(7), 0.05), atol=1e-9)


def memberships(levels):
    return np.stack([np.interp(np.clip(levels, -6.0, 6.0), CENTRES, peak) for peak in np.eye(7)], axis=-1)


def rules_of(run, at, scale=36.0):
    """Regressors of the rules at the places ``at``: memberships of the curvature and of its high-pass."""
    kappa, low, high, smooth = run["command.curvature_ahead"], 0.0, [], 1.0 - math.exp(-0.1)
    for value in kappa:
        low += smooth * (value - low)
        high.append(value - low)
    e, ec = memberships(scale * kappa), memberships(scale * np.array(high))
    rows = (ec[:, :, None] * e[:, None, :]).reshape(len(kappa), 49)
    return rows[at - 1]


@pytest.mark.slow
def test_rules_of_the_curvature_learn_the_least_squares_weights():
    run, state = lived(curvature_network(k_c=36.0, k_h=36.0), 5.0, noise=0.15)
    c, at = unexplained(run)
    c, at = c[1:], at[1:]
    rows = np.column_stack([rules_of(run, at), *(part[at] for part in direction(run))])
    found = least_squares(rows, -c / 0.9 / 2.5, start_covariance(), 0.05)
    assert np.abs(found).max() < 6.0
    assert np.allclose(state.weights, found, atol=1e-9)


@pytest.mark.slow
def test_rules_apart_are_updated_by_the_networks_own_filter():
    """Every rule for itself: the same weights as of the Kalman update of the network of the error."""
    run, state = lived(RULES_APART, 3.0, noise=0.15)
    c, at = unexplained(run)
    rows = rules_of(run, at[1:])
    weights, covariance = np.zeros(49), np.eye(49)
    for h, needed in zip(rows, -c[1:] / 0.9 / 2.5, strict=True):
        k = int(np.flatnonzero(h)[0])
        j, i = min(k // 7, 5), min(k % 7, 5)
        mu = float(h.reshape(7, 7)[:, i + 1].sum())
        nu = float(h.reshape(7, 7)[j + 1].sum())
        kalman_learn(weights, covariance, Fired(i, j, mu, nu), needed - h @ weights, 0.05, 0.0, 1e9, 6.0)
    assert np.allclose(state.weights[:49], weights, atol=1e-9)
    assert not state.weights[49:].any()


@pytest.mark.slow
def test_rules_that_never_fired_follow_the_others():
    """On a gentle line the middle rules fire alone; the sharp ones still get an offset, of the slope learned there."""
    _, near = lived(curvature_network, 5.0, size=40.0)
    _, alone = lived(curvature_network(prior_covariance=apart_covariance()), 5.0, size=40.0)
    middle, sharp = 24, 27  # E = ZO and PB, EC = ZO
    assert alone.weights[sharp] == 0.0
    slope = near.weights[middle + 1] - near.weights[middle]
    assert slope > 0.3
    assert near.weights[sharp] - near.weights[middle] == pytest.approx(3.0 * slope, rel=0.3)


@pytest.mark.slow
@pytest.mark.parametrize("controller", [curvature_feed_forward, curvature_network])
def test_the_second_piece_is_better_and_frozen_it_stays_so(controller):
    """What was learned is the prior of the next piece; without learning it cuts as well."""
    _, state = lived(controller, 6.0, noise=0.15)
    errors = []
    for block in (
        controller,
        controller(prior=state.weights, prior_covariance=state.covariance),
        controller(prior=state.weights, learning=0),
    ):
        errors.append(knife(block, noise=0.15).run(6.0, every=0, replicate=1).metrics["rms_error"])
    assert errors[1] < 0.6 * errors[0] and errors[2] < 0.6 * errors[0]


@pytest.mark.slow
@pytest.mark.parametrize("controller", [curvature_feed_forward, curvature_network])
def test_nothing_is_learned_while_the_cut_is_not_seen(controller):
    live = knife(controller, noise=0.15).using({"sensor.lost_from_s": 1.0, "sensor.lost_for_s": 1.0}).start()
    live.advance(100)
    before = controller_state(live)
    live.advance(100)
    lost = controller_state(live)
    live.advance(100)
    after = controller_state(live)
    assert np.array_equal(before.weights, lost.weights) and before.found == lost.found
    assert np.array_equal(before.covariance, lost.covariance)
    assert not np.array_equal(lost.weights, after.weights)


@pytest.mark.parametrize("controller", [curvature_feed_forward, curvature_network])
def test_what_is_read_while_the_cut_is_not_seen_does_no_harm(controller):
    """Step by step: NaN from a lost camera leaves no trace, whatever it says instead."""
    plan, sent = controller.prepare(controller.params, 0.01), []
    for blank in (math.nan, 7.0):
        state, offsets = controller.state._replace(**{k: np.array(v) for k, v in arrays_of(controller.state)}), []
        for k in range(60):
            command = TangentCommand(0.0, 2.0 * k, 0.03, 2.0 * k + 2.0, 0.03, 0.5 * k)
            seen = not 30 <= k < 40
            reading = SeenCut(0.3 * math.sin(k), 1.0) if seen else SeenCut(blank, 0.0)
            state, offset = controller.step(plan, state, command, reading, 0.01)
            offsets.append(offset)
        sent.append(offsets)
    assert np.isfinite(sent[0]).all() and sent[0] == sent[1]
    assert len(set(sent[0])) > 20


def arrays_of(state):
    return [(k, v) for k, v in state._asdict().items() if isinstance(v, np.ndarray)]


@pytest.mark.slow
@pytest.mark.parametrize("controller", [curvature_feed_forward, curvature_network])
def test_the_offset_does_not_jump_when_the_cut_is_seen_again(controller):
    """Lost while the material changes: all at once it steps by twice what it does with the reading coming back."""
    steps = []
    for block in (controller, controller(return_s=0.01)):
        lost = {"sensor.lost_from_s": 2.8, "sensor.lost_for_s": 1.0, "plant.change_at": 120.0}
        sent = knife(block, noise=0.15).using(lost).run(4.2, record=("output",))["output"]
        steps.append(np.abs(np.diff(sent))[377:].max())
    assert steps[0] < 0.6 * steps[1]


@pytest.mark.slow
@pytest.mark.parametrize("controller", [curvature_feed_forward, curvature_network])
def test_nothing_is_learned_at_the_limit_of_the_axis(controller):
    """A limit of 0.2 deg is reached at once; the weights stay where they were whenever the last offset was at it."""
    live = knife(controller(most=0.2), noise=0.15).start()
    held = moved = 0
    sent, weights = 0.0, controller_state(live).weights
    for _ in range(200):
        run = live.advance(1, record=SEEN)
        now = controller_state(live).weights
        if abs(sent) >= 0.2:
            assert np.array_equal(now, weights)
            held += 1
        elif not np.array_equal(now, weights):
            moved += 1
        sent, weights = float(run["output"][0]), now
    assert held > 50 and moved > 1


@pytest.mark.slow
@pytest.mark.parametrize("controller", [curvature_feed_forward, curvature_network])
@pytest.mark.parametrize("size", [0.0, 90.0])
def test_100000_samples_leave_the_covariance_sound(controller, size):
    """Straight on, where nothing excites the curvatures, and on the line: symmetric, positive, bounded; no drift."""
    live = knife(controller, noise=0.15, size=size).start()
    live.advance(99_000)
    late = live.advance(1000, record=("actual.deviation",))
    state = controller_state(live)
    assert np.array_equal(state.covariance, state.covariance.T)
    assert np.linalg.eigvalsh(state.covariance).min() > 0.0
    assert np.trace(state.covariance) <= max(10.0, np.trace(start_covariance())) * (1.0 + 1e-9)
    assert np.isfinite(state.weights).all() and np.abs(state.weights).max() < 6.0
    assert np.sqrt(np.mean(late["actual.deviation"] ** 2)) < 0.3


@pytest.mark.parametrize(
    ("block", "changes", "said"),
    [
        (curvature_feed_forward, {"lags": [0.0, 3.0, 3.0, 8.0]}, "lags"),
        (curvature_feed_forward, {"lags": [0.0, 3.0, 8.0, 30.0]}, "delay_s"),
        (curvature_feed_forward, {"prior_covariance": np.triu(np.ones((7, 7)))}, "symmetric"),
        (curvature_network, {"prior_covariance": np.triu(np.ones((51, 51)))}, "symmetric"),
        (curvature_network, {"prior": np.zeros(49)}, "prior"),
    ],
)
def test_what_does_not_fit_is_refused(block, changes, said):
    with pytest.raises(ValueRefused, match=said):
        knife(block(**changes)).run(0.01)


@pytest.mark.parametrize("filter_s", [0.02, 0.05])
def test_what_the_rules_do_not_explain_comes_through_the_lag_that_was_asked_for(filter_s):
    """On a straight line 0.45 deg off, with an offset of 0: -0.45 / 0.9 deg is needed, -0.2 levels of 2.5 deg."""
    block = curvature_network(learning=0, gain=0.0, filter_s=filter_s)
    plan, found = block.prepare(block.params, 0.01), []
    state = block.state._replace(**{k: np.array(v) for k, v in arrays_of(block.state)})
    for _ in range(30):
        state, offset = block.step(plan, state, TangentCommand(0.0, 0.0, 0.0, 0.0, 0.0, 0.0), SeenCut(0.45, 1.0), 0.01)
        assert offset == 0.0
        found.append(state.found)
    # the cut of the first offset is seen after 4 samples, that of the 2 samples ahead begun there
    begins = int(np.flatnonzero(found)[0])
    assert begins == 6
    time = 0.01 * np.arange(1, 31 - begins)
    assert found[begins:] == pytest.approx(-0.2 * (1.0 - np.exp(-time / filter_s)), rel=1e-9)
