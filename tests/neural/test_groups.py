"""All groups of weights learned: derivatives against differences, the filter against matrices, the block in a loop."""

from typing import NamedTuple

import numpy as np
import pytest

from leadscrew.controllers._sofnn.network import AllWeightsState, sofnn, sofnn_all_weights
from leadscrew.export.folder import compiler_path
from leadscrew.neural.groups import SIZE, full_covariance, learn_all, said_by, triangle_of
from leadscrew.neural.inference_net import AXIS, CENTRES, W0, fired, network_output
from leadscrew.references._cut_line import TangentCommand
from leadscrew.sensors._cut_camera import SeenCut
from tests.controllers.sofnn_loop import knife_loop, rms, state_of
from tests.neural.groups_loop import ALL, all_groups
from tests.tools import missing


def stepped(block, deviations):
    """Offsets after some readings, by the block's step alone."""
    p = block.prepare(block.params, 0.01)
    state = type(block.state)(*(v.copy() if isinstance(v, np.ndarray) else v for v in block.state))
    found = []
    for e in deviations:
        state, offset = block.step(p, state, TangentCommand(), SeenCut(float(e), 1.0), 0.01)
        found.append(offset)
    return np.array(found)


class Filter(NamedTuple):
    r: float = 0.01
    q: float = 0.05
    q_certainty: float = 0.02
    q_centre: float = 0.01
    cap: float = 4.0
    clamp: float = 6.0
    gap: float = 0.4
    forgetting: float = 1.0


def network(seed):
    """Consequents, certainties and two rows of centres."""
    rng = np.random.default_rng(seed)
    inner = [CENTRES + np.concatenate([[0], rng.uniform(-0.6, 0.6, 5), [0]]) for _ in range(2)]
    return [2.0 * rng.normal(size=49), rng.uniform(0.3, 3.0, 49), *inner]


def packed(parts):
    return np.concatenate([parts[0], parts[1], parts[2][1:-1], parts[3][1:-1]])


def unpacked(x):
    return [x[:49], x[49:98], *(np.concatenate([[-6.0], x[k : k + 5], [6.0]]) for k in (98, 103))]


def plain(parts, e, ec):
    """The normalised sum over all 49 rules, equation (2) with certainties."""
    mu = [np.interp(e, parts[2], peak) for peak in np.eye(7)]
    nu = [np.interp(ec, parts[3], peak) for peak in np.eye(7)]
    a = parts[1] * np.kron(nu, mu)
    return a @ parts[0] / a.sum()


def slopes(parts, e, ec):
    x = packed(parts)
    found = np.zeros(SIZE)
    for k in range(SIZE):
        step = np.zeros(SIZE)
        step[k] = 1e-6
        found[k] = (plain(unpacked(x + step), e, ec) - plain(unpacked(x - step), e, ec)) / 2e-6
    return found


def test_the_output_is_the_normalised_sum_of_all_rules():
    for seed in range(20):
        parts = network(seed)
        e, ec = np.random.default_rng(seed).uniform(-7.0, 7.0, 2)
        assert said_by(*parts, e, ec).level == pytest.approx(plain(parts, e, ec), abs=1e-12)
    even = [W0, np.ones(49), CENTRES, CENTRES]
    assert said_by(*even, 1.3, -2.2).level == pytest.approx(network_output(W0, fired(AXIS, AXIS, 1.3, -2.2)), abs=1e-14)


@pytest.mark.parametrize("forgetting", [1.0, 0.98])
def test_an_update_is_that_of_the_extended_kalman_filter(forgetting):
    p = Filter(forgetting=forgetting)
    a = np.random.default_rng(9).normal(size=(SIZE, 130))
    for seed, (e, ec) in enumerate([(0.3, 0.2), (-5.5, 5.7), (5.1, -3.3), (2.4, -0.9)]):
        parts, covariance = network(seed), 0.01 * (a @ a.T + (a @ a.T).T)
        h, x = slopes(parts, e, ec), packed(parts)
        wider = covariance / forgetting
        s = h @ wider @ h + p.r
        gain = wider @ h / s
        after = wider - np.outer(gain, gain) * s + np.diag(np.repeat([p.q, p.q_certainty, p.q_centre], [49, 49, 10]))
        d = np.sqrt(np.minimum(1.0, p.cap / after.diagonal()))
        moved = x + 0.05 * gain
        moved[:49] = np.clip(moved[:49], -6.0, 6.0)
        triangle = triangle_of(covariance)
        assert learn_all(p, *parts, triangle, said_by(*parts, e, ec), 0.05) == pytest.approx(s, rel=1e-6)
        assert packed(parts) == pytest.approx(moved, abs=1e-7)
        assert full_covariance(triangle) == pytest.approx(after * np.outer(d, d), abs=1e-6)


def test_certainties_cancel_where_a_rule_fires_alone():
    for k, (ec, e) in enumerate((a, b) for a in CENTRES for b in CENTRES):
        certainties = np.random.default_rng(k).uniform(0.1, 10.0, 49)
        assert said_by(W0, certainties, CENTRES, CENTRES, e, ec).level == pytest.approx(W0[k], abs=1e-12)
        doubled = said_by(W0, 2.0 * certainties, CENTRES, CENTRES, e + 0.5, ec + 0.5).level
        assert doubled == pytest.approx(said_by(W0, certainties, CENTRES, CENTRES, e + 0.5, ec + 0.5).level, abs=1e-12)


def test_a_walk_without_bounds_leaves_them_in_order():
    parts, covariance = network(3), triangle_of(4.0 * np.eye(SIZE))
    p = Filter(q_centre=1.0, q_certainty=1.0)
    rng = np.random.default_rng(4)
    for _ in range(40):
        said = said_by(*parts, *rng.uniform(-7.0, 7.0, 2))
        learn_all(p, *parts, covariance, said, 50.0 * rng.normal())
    assert all((np.diff(c) >= 0.4 - 1e-12).all() for c in parts[2:])
    assert np.abs(parts[0]).max() <= 6.0 and parts[1].min() >= 0.1 and parts[1].max() <= 10.0


def test_with_no_walk_each_step_is_that_of_the_network_whose_consequents_learn():
    few = {"target": 1, "k_e": 0.2, "kg": 0.7, "passes": 2, "delay": 2}
    e = 20.0 * np.sin(np.arange(16) * 0.5)
    ours, theirs = stepped(sofnn_all_weights(**few), e), stepped(sofnn(**few), e)
    assert ours == pytest.approx(theirs, abs=1e-12) and np.ptp(ours) > 1.0


@pytest.mark.slow
def test_with_no_walk_it_is_the_network_whose_consequents_learn():
    few = {"target": 1, "k_e": 0.2, "kg": 0.7, "passes": 3}
    ours = knife_loop(sofnn_all_weights(**few)).run(4.0)
    theirs = knife_loop(sofnn(**few)).run(4.0)
    assert ours["output"] == pytest.approx(theirs["output"], abs=1e-10)
    assert np.abs(theirs["output"]).max() > 1.0


@pytest.mark.slow
def test_all_groups_move_and_the_deviation_falls():
    live = all_groups().start()
    live.advance(850, every=0)
    state = state_of(live)
    assert np.abs(state.centres_e - CENTRES).max() > 0.3 and np.ptp(state.certainties) > 0.3
    assert (np.diff(state.centres_e) >= 0.4 - 1e-9).all() and (np.diff(state.centres_ec) >= 0.4 - 1e-9).all()
    fixed = all_groups().using({"controller.learning": False}).run(8.5)["actual.deviation"]
    assert rms(all_groups().run(8.5)["actual.deviation"]) < 0.9 * rms(fixed)


def test_it_takes_over_without_a_bump():
    given = SeenCut(4.0, 1.0)
    for output in (-14.0, 0.0, 3.0):
        params = sofnn_all_weights.prepare(sofnn_all_weights.params, 0.01)
        state = sofnn_all_weights.align(params, TangentCommand(), given, output)
        assert isinstance(state, AllWeightsState)
        _, sent = sofnn_all_weights.step(params, state, TangentCommand(), given, 0.01)
        assert sent == pytest.approx(output, abs=1e-9)


@pytest.mark.sweep
def test_every_engine_has_the_same_bits():
    if compiler_path() is None:
        missing("gcc", "there is no C compiler on this machine")
    found = [all_groups().run(0.3, engine=engine)["output"] for engine in ("llvm", "c", "python")]
    assert all((other == found[0]).all() for other in found[1:])


@pytest.mark.slow
def test_100000_samples_do_no_harm():
    live = knife_loop(sofnn_all_weights(**ALL), again=True).start()
    run = live.advance(100_000, every=0)
    state = state_of(live)
    assert run.diverged is None and np.abs(state.weights).max() <= 6.0
    covariance = full_covariance(state.covariance)
    assert np.isfinite(covariance).all() and covariance.diagonal().max() <= 4.0 + 1e-9
    assert np.linalg.eigvalsh(covariance)[0] > -1e-9
