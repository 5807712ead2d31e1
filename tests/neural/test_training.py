"""Training of performance networks: searches, polish, and the test that keeps an unsafe network from the loop."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import approx_fprime
from typer.testing import CliRunner

from leadscrew.neural.genetic import Found, Genetic, cma_search, evolve, pymoo_search
from leadscrew.neural.performance import (
    CELLS,
    GOLDEN,
    READINGS,
    TABLE,
    Loss,
    Performance,
    Shape,
    measured,
    polish,
    read_net,
    reading,
    rmse_of,
    shape_of,
    surface,
)
from leadscrew.neural.safety import Safety, crossing, safety, table_faults
from leadscrew.neural.training import METHODS, train
from leadscrew.studies.sofnn_tangent.trainings import nets
from leadscrew.util.errors import EngineError, NameUnknown, ValueRefused

COUNTS = {"18": 18, "18_linear": 18, "19": 19, "24": 24, "25": 25, "16_four_hidden": 16, "16_five_hidden": 16}


def sphere(rows):
    """A bowl whose foot is at 1, 2, 3, 4, 5."""
    return np.sum((rows - np.arange(1.0, 6.0)) ** 2, axis=1)


@pytest.mark.parametrize("name", READINGS)
def test_a_reading_has_the_weights_of_its_name(name):
    """By hand: 12 + 6 without biases, 1, 6 or 7 more; 8 + 4 + 4 and 10 + 5 + 1 for the two that have 16."""
    shape = reading(name)
    assert shape.weights == COUNTS[name]
    net = shape.net(np.arange(1.0, shape.weights + 1.0))
    assert np.array_equal(shape.row(net), np.arange(1.0, shape.weights + 1.0))
    assert shape_of(net) == shape


@pytest.mark.parametrize("name", READINGS)
def test_many_networks_at_once_answer_as_each_does_in_the_loop(name):
    shape = READINGS[name]
    rows = 0.4 * np.random.default_rng(0).normal(size=(5, shape.weights))
    together = shape.outputs(rows, CELLS)
    for row, values in zip(rows, together, strict=True):
        assert values == pytest.approx([measured(shape.net(row), e, ec) for e, ec in CELLS], abs=1e-12)


@pytest.mark.parametrize("name", ["18", "18_linear", "25", "16_five_hidden"])
def test_derivatives_of_the_loss_are_those_of_finite_differences(name):
    shape = READINGS[name]
    loss = Loss(shape, TABLE, safe=True)
    row = np.random.default_rng(5).normal(size=shape.weights)
    cost = lambda w: 0.5 * np.sum(loss.both(w)[0] ** 2)  # noqa: E731
    values, slopes = loss.both(row)
    assert slopes.T @ values == pytest.approx(approx_fprime(row, cost, 1e-7), rel=2e-4, abs=2e-3)


def test_half_of_the_plane_costs_an_odd_network_what_the_whole_plane_does():
    """0.045 max(P sign(E), 0) on 49 x 49 points; the loss of an odd network takes those of E > 0 alone."""
    shape = READINGS["18"]
    row = np.random.default_rng(5).normal(size=18)
    cost = np.sum(Loss(shape, TABLE, safe=True).residuals(row)[2 * 169 : -18] ** 2)
    e, ec = (x.ravel() for x in np.meshgrid(np.linspace(-6.0, 6.0, 49), np.linspace(-6.0, 6.0, 49)))
    output = shape.outputs(row[None], np.column_stack([e, ec]))[0]
    assert cost == pytest.approx(np.sum((0.045 * np.maximum(output * np.sign(e), 0.0)) ** 2), rel=1e-9) and cost > 0.1


def test_the_golden_network_lies_at_the_foot_of_the_safe_loss():
    """The kept weights come from elsewhere: polished here, they stay as good and move the surface by little."""
    shape = Shape()
    row = polish(shape.row(GOLDEN), Loss(shape, TABLE, safe=True))
    before, after = safety(GOLDEN), safety(shape.net(row))
    assert after.rmse == pytest.approx(before.rmse, abs=5e-4)
    assert np.abs(surface(shape.net(row), *CELLS.T) - surface(GOLDEN, *CELLS.T)).max() < 0.05


def test_the_genetic_algorithm_finds_the_foot_of_a_bowl_and_never_loses_its_best():
    found = evolve(sphere, 5, Genetic(40, 200), seed=1)
    assert found.best == pytest.approx(np.arange(1.0, 6.0), abs=0.05)
    assert found.history.shape == (201,) and np.all(np.diff(found.history) <= 0.0)
    assert found.history[-1] == found.cost == sphere(found.best[None])[0]
    assert found.evaluations == 40 + 200 * 38


def test_the_same_seed_gives_the_same_network_and_another_one_another():
    cost = rmse_of(Shape(), TABLE)
    first, again, other = (evolve(cost, 18, Genetic(20, 20), seed).best for seed in (4, 4, 5))
    assert np.array_equal(first, again) and not np.array_equal(first, other)


def test_weights_stay_inside_the_bound():
    best = evolve(lambda rows: -np.sum(rows, axis=1), 3, Genetic(20, 60, bound=2.5), seed=0).best
    assert np.all(best == 2.5)


def test_progress_is_told_generation_by_generation():
    told = []
    evolve(sphere, 5, Genetic(8, 7), report=lambda done, total: told.append((done, total)))
    assert told == [(k, 7) for k in range(1, 8)]


def test_cma_finds_the_same_foot():
    assert cma_search(sphere, 5, seed=2, evaluations=2500).best == pytest.approx(np.arange(1.0, 6.0), abs=1e-3)


@pytest.mark.slow
def test_pymoo_finds_it_too():
    assert pymoo_search(sphere, 5, 0, 40, 80).best == pytest.approx(np.arange(1.0, 6.0), abs=0.2)


def test_without_pymoo_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pymoo.algorithms.soo.nonconvex.ga", None)
    with pytest.raises(EngineError, match=r"leadscrew\[tune\]"):
        pymoo_search(sphere, 5)


def test_the_golden_network_is_safe():
    found = safety(GOLDEN)
    assert found.accepted and found.right_way and not found.failures()
    assert found.rmse == pytest.approx(0.601, abs=0.002)
    e, step = 0.0, 1e-6
    assert found.slope == pytest.approx((measured(GOLDEN, e + step, 0.0) - measured(GOLDEN, e - step, 0.0)) / 2e-6)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"out": -GOLDEN.out}, "has the sign of E"),
        ({"out_bias": 0.1}, r"P\(0, 0\) = 0.59"),
        ({"hidden": 0.5 * GOLDEN.hidden}, "slope dP/dE = -0.30 at the origin, expected -1.5 to -0.4"),
        ({"hidden": 4.0 * GOLDEN.hidden}, "slope dP/dE = -2.39"),
    ],
)
def test_a_network_that_would_drive_the_wrong_way_is_told_apart(change, said):
    found = safety(GOLDEN._replace(**change))
    assert not found.right_way and not found.accepted
    assert said.replace("\\", "") in "; ".join(found.failures())


def test_a_bad_memory_alone_is_not_the_wrong_way():
    found = safety(Performance(np.array([[1.0, 0.6]]), np.zeros(1), np.array([-1.0])))
    assert found.right_way and not found.accepted and found.failures()[0].startswith("RMSE")


@pytest.mark.parametrize("bias", [-0.05, 0.03])
def test_a_learning_loop_rests_where_the_correction_crosses_zero(bias):
    net = GOLDEN._replace(out_bias=bias)
    at = crossing(net)
    assert measured(net, at, 0.0) == pytest.approx(0.0, abs=1e-4)
    assert np.sign(at) == np.sign(bias)


def test_where_nothing_crosses_there_is_no_place_to_rest():
    assert np.isnan(
        crossing(GOLDEN._replace(out=-GOLDEN.out)._replace(out_bias=5.0)._replace(hidden=0.01 * GOLDEN.hidden))
    )


def test_quick_training_gives_a_network_that_goes_the_right_way():
    found = train(seed=1, population=30, generations=40, tries=2)
    assert found.safety.right_way and found.safety.rmse < found.searched.rmse
    assert safety(found.net) == found.safety
    assert found.history[-1] == pytest.approx(found.searched.rmse)


@pytest.mark.slow
def test_a_search_that_goes_the_wrong_way_is_repaired_and_said_so(monkeypatch):
    """From the network of the smallest RMSE, whose slope is 0.66."""
    wrong = Found(Shape().row(nets()["min_rmse"]), 0.594, np.ones(1), 1)
    monkeypatch.setattr("leadscrew.neural.training.search", lambda *a: wrong)
    found = train(method="ga", tries=1)
    assert not found.searched.right_way and found.searched.slope > 0.6
    assert found.safety.right_way
    assert found.notes[0].startswith("repaired: the search left P(-0.65, 0) has the sign of E")


def test_what_stays_unsafe_is_refused(monkeypatch):
    monkeypatch.setattr("leadscrew.neural.training.polish", lambda row, loss: row)
    wrong = Found(Shape().row(GOLDEN._replace(out=-GOLDEN.out)), 1.0, np.ones(1), 1)
    monkeypatch.setattr("leadscrew.neural.training.search", lambda *a: wrong)
    with pytest.raises(ValueRefused, match="no safe network found: 2-6-1, no biases, tanh output, 2 searches by ga"):
        train(method="ga", tries=2)


@pytest.mark.parametrize(
    ("table", "said"),
    [
        (-TABLE, "at E = -1, EC = 0, expected the other sign than E"),
        (TABLE + np.where(np.arange(169).reshape(13, 13) == 84, 1.0, 0.0), "it corrects 1 at E = 0, EC = 0"),
        (TABLE[:12], "shape is \\(12, 13\\)"),
        (2.0 * TABLE, "outside -6 to 6"),
    ],
)
def test_a_table_that_drives_the_wrong_way_itself_is_refused(table, said):
    with pytest.raises(ValueRefused, match=said):
        train(table)
    assert not table_faults(TABLE)


def test_a_flatter_table_asks_for_a_flatter_network():
    table = 0.5 * TABLE
    assert safety(GOLDEN, table).slope_range == (-0.75, -0.2)


@pytest.mark.parametrize(
    ("options", "error", "said"),
    [
        ({"method": "swarm"}, NameUnknown, "there are ga, ga"),
        ({"population": 2}, ValueRefused, "population = 2"),
        ({"generations": 0}, ValueRefused, "generations = 0"),
        ({"seed": -1}, ValueRefused, "seed = -1"),
        ({"tries": 0}, ValueRefused, "tries = 0"),
    ],
)
def test_settings_out_of_range_are_refused(options, error, said):
    with pytest.raises(error, match=said):
        train(**options)


@pytest.mark.parametrize(("options", "said"), [({"hidden": 0}, "hidden = 0"), ({"biases": "some"}, "biases = 'some'")])
def test_shapes_that_are_none_are_refused(options, said):
    with pytest.raises(ValueRefused, match=said):
        Shape(**options)


def command():
    import typer

    from leadscrew.cli.exit_codes import Door
    from leadscrew.cli.tangent import train as typed

    app = typer.Typer(cls=Door)
    app.command("train")(typed)
    app.callback()(lambda: None)
    return app


def test_the_command_writes_what_the_loop_can_read(tmp_path):
    out = tmp_path / "net.json"
    asked = ["train", "--population", "30", "--generations", "40", "--seed", "1", "-o", str(out)]
    done = CliRunner().invoke(command(), asked)
    assert done.exit_code == 0, done.output
    assert "slope dP/dE at the origin" in done.output
    assert safety(read_net(out)).right_way
    again = CliRunner().invoke(command(), asked)
    assert again.exit_code == 2 and "exists already" in again.output


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["-o", "net.toml"], "ends in .json"),
        (["--biases", "few"], "expected none, output, hidden, all"),
        (["--table", "nowhere.csv"], "cannot be read"),
        (["--method", "luck"], "no method 'luck'"),
    ],
)
def test_the_command_refuses_in_one_sentence(options, said):
    done = CliRunner().invoke(command(), ["train", *options])
    assert done.exit_code == 2 and said in " ".join(done.output.split())


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_every_method_gives_a_safe_network(method):
    found = train(method=method, seed=2)
    assert found.safety.right_way
    assert found.safety.rmse <= 0.65 or "+" not in method


@pytest.mark.slow
def test_the_best_of_three_seeds_of_the_genetic_algorithm_is_near_the_table():
    """What `leadscrew tangent train` asks for."""
    cost = rmse_of(Shape(), TABLE)
    assert min(evolve(cost, 18, Genetic(80, 600), seed).cost for seed in range(3)) <= 0.85


SOUND = Safety(0.65, 1.0, 0.5, 1.0, 0.0199, -1.0, -0.01, 0.5)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({}, ""), ({"rmse": 0.651}, "RMSE = 0.651"), ({"origin": 0.02}, "P\\(0, 0\\) = 0.020"),
        ({"origin": -0.02}, "P\\(0, 0\\) = -0.020"), ({"wrong_way": 0.0}, "P\\(0.50, 0\\) has the sign of E"),
        ({"slope": -0.4}, ""), ({"slope": -0.39}, "slope dP/dE = -0.39"), ({"slope": -1.5}, ""),
        ({"slope": -1.51}, "slope dP/dE = -1.51"), ({"slope": -0.7, "wanted_slope": -0.5}, ""),
        ({"slope": -0.8, "wanted_slope": -0.5}, "expected -0.75 to -0.2"),
    ],
)  # fmt: skip
def test_a_network_is_accepted_up_to_the_limits_and_on_them(change, said):
    found = replace(SOUND, **change)
    assert found.accepted == (not said) and len(found.failures()) == bool(said)
    assert re.search(said, "".join(found.failures()))
    assert found.right_way == (not said or said.startswith("RMSE"))
