"""What a loop does with time, delays, limits, divergence; and that what goes in wrong is refused at the validate."""

import math
import warnings
from typing import NamedTuple

import numpy as np
import pytest

from leadscrew.kernel import live as live_module
from leadscrew.kernel.block import controller, disturbance, make, metric, plant, reference
from leadscrew.kernel.loop import DivergenceWarning, Loop
from leadscrew.kernel.metrics import STANDARD
from leadscrew.kernel.program import programs
from leadscrew.util.errors import BlockError, Diverged, NameUnknown, ValueRefused
from tests.kernel import zoo
from tests.kernel.test_validate import GOOD


class Empty(NamedTuple):
    x: float = 0.0


class CountState(NamedTuple):
    n: int = 0


@reference(None, CountState())
def counting(s):
    """The number of the period."""
    return CountState(s.n + 1), s.n


@controller(None)
def through(command):
    """The command itself."""
    return command


def test_a_plant_shows_what_it_was_given_one_period_before():
    run = Loop(reference=counting, controller=through, plant=plant(None, Empty())(hold_last), metrics={}).run(0.01)
    assert run["actual"].tolist() == [0, 0, 1, 2, 3, 4, 5, 6, 7, 8]
    assert run["command"].tolist() == list(range(10))
    assert run.time.tolist() == [k * 1e-3 for k in range(10)]


def hold_last(s, u, dt):
    """Shows what it was given last."""
    return Empty(u + 0.0 * dt)


class LineState(NamedTuple):
    x: float = 0.0


@plant(None, LineState())
def integrator(s, u, dt):
    """The sum of what came in."""
    return LineState(s.x + u * dt)


@pytest.mark.parametrize(("delay", "late"), [(0.0, 0), (0.001, 1), (0.003, 3)])
def test_a_computational_delay_holds_the_output_back(delay, late):
    loop = Loop(
        reference=counting,
        controller=through,
        plant=plant(None, Empty())(hold_last),
        computation_delay=delay,
        metrics={},
    )
    assert loop.run(0.01)["actual"].tolist() == [max(0, k - 1 - late) for k in range(10)]


def test_a_delay_within_the_period_splits_it():
    loop = Loop(
        reference=counting, controller=through, plant=integrator, substeps=4, computation_delay=0.00175, metrics={}
    )
    got = loop.run(0.006)["actual"] * 1000
    held = lambda k: max(0, k)  # noqa: E731
    want = [sum(0.75 * held(k - 2) + 0.25 * held(k - 1) for k in range(n)) for n in range(6)]
    np.testing.assert_allclose(got, want, atol=1e-12)


def test_other_steps_a_period_leave_the_delays_as_they_are():
    loop = Loop(
        reference=counting, controller=through, plant=integrator, substeps=4, computation_delay=0.00175, metrics={}
    )
    np.testing.assert_allclose(loop.using(substeps=8).run(0.006)["actual"], loop.run(0.006)["actual"], atol=1e-15)
    with pytest.raises(ValueRefused, match=r"computation_delay = 0.00175 s is not a multiple .* of 0.001 s"):
        loop.using(substeps=1)


def test_a_transport_delay_makes_the_sensor_see_the_past():
    loop = Loop(
        reference=counting, controller=through, plant=integrator, substeps=2, transport_delay=0.0015, metrics={}
    )
    run = loop.run(0.01)
    fine = np.interp(run.time - 0.0015, run.time, run["actual"], left=0.0)
    np.testing.assert_allclose(run["feedback"], fine, atol=1e-15)


def test_ten_short_advances_equal_one_long_one_bit_for_bit():
    loop = Loop(
        reference=zoo.sine, controller=zoo.history, plant=zoo.mass, sensor=zoo.ruler, substeps=2,
        computation_delay=0.001, transport_delay=0.002, seed=3,
    )  # fmt: skip
    whole = loop.start()
    a = whole.advance(1000, every=7)
    live = loop.start()
    parts = [live.advance(100, every=7) for _ in range(10)]
    for name in a.signals:
        assert np.array_equal(a.signals[name], np.concatenate([p.signals[name] for p in parts])), name
    assert live.time == 1.0
    assert parts[-1].metrics == a.metrics or all(
        x == y or math.isnan(x) for x, y in zip(parts[-1].metrics.values(), a.metrics.values(), strict=True)
    )


def test_a_run_in_slices_is_the_same_bit_for_bit(monkeypatch):
    loop = Loop(reference=zoo.sine, controller=zoo.history, plant=zoo.mass, sensor=zoo.ruler, substeps=2, seed=3)
    whole = loop.start().advance(2000, every=3)
    monkeypatch.setattr(live_module, "FIRST_SLICE", 7)
    monkeypatch.setattr(live_module, "SLICE_S", 0.0)  # a period at a time after the first seven
    sliced = loop.start().advance(2000, every=3)
    assert all(np.array_equal(whole[name], sliced[name]) for name in whole.signals)
    assert np.array_equal([*whole.metrics.values()], [*sliced.metrics.values()], equal_nan=True)


def test_after_ctrl_c_a_live_loop_stands_where_its_last_slice_ended(monkeypatch):
    loop = Loop(reference=zoo.sine, controller=zoo.pid, plant=zoo.mass)
    monkeypatch.setattr(live_module, "FIRST_SLICE", 10)
    stopped, seen = loop.start(), []

    def clock():
        seen.append(1)
        if len(seen) == 4:  # begin of the run, begin and end of the first slice, begin of the second
            raise KeyboardInterrupt
        return 0.0

    with monkeypatch.context() as m:
        m.setattr(live_module.time, "perf_counter", clock)
        with pytest.raises(KeyboardInterrupt):
            stopped.advance(2000)
    assert stopped.period == 10
    rest, whole = stopped.advance(1990), loop.start().advance(2000)
    assert np.array_equal(rest["actual"], whole["actual"][10:])


def test_a_saved_place_can_be_gone_back_to_and_parameters_set_on_the_way():
    loop = Loop(reference=zoo.sine, controller=zoo.pid, plant=zoo.mass, metrics={})
    live = loop.start()
    live.advance(50)
    saved = live.save()
    a = live.advance(50)
    live.restore(saved)
    b = live.advance(50)
    assert np.array_equal(a["actual"], b["actual"])
    live.restore(saved)
    assert np.array_equal(a["actual"], live.advance(50)["actual"])
    live.restore(saved)
    live.set("controller.kp", 0.5)
    c = live.advance(50)
    assert not np.array_equal(a["actual"], c["actual"])
    assert live.loop.parameters["controller.kp"] == 0.5
    live.restore(saved)
    assert live.loop.parameters["controller.kp"] == 1.32
    with pytest.raises(ValueRefused, match=r"controller\.kp"):
        live.set("controller.kp", -1.0)
    with pytest.raises(NameUnknown):
        live.set("seed", 3)
    assert live.values()["plant.position"] == pytest.approx(
        saved.scalars[live.program.plan.state.keys["plant.position"].at]
    )


def test_switching_the_controller_in_the_run_is_bumpless_where_it_can_align():
    loop = Loop(reference=zoo.sine(frequency=0.1), controller=zoo.pid(kp=2.0), plant=zoo.mass, metrics={})
    live = loop.start()
    before = live.advance(300)
    other = live.switch(zoo.pid(kp=0.5))
    after = other.advance(5)
    assert other.bumpless
    assert abs(after["output"][0] - before["output"][-1]) < 0.05 * abs(before["output"][-1])
    assert after.time[0] == pytest.approx(0.3)
    assert not live.switch(zoo.observed).bumpless


def test_several_parameters_are_set_in_the_run_together_or_not_at_all():
    loop = Loop(reference=zoo.sine, controller=zoo.pid, plant=zoo.mass, metrics={})
    one, both = loop.start(), loop.start()
    for live in (one, both):
        live.advance(20)
    one.set("controller.kp", 0.5)
    one.set("reference.amplitude", 2.0)
    both.set_all({"controller.kp": 0.5, "reference.amplitude": 2.0})
    assert np.array_equal(one.advance(30)["actual"], both.advance(30)["actual"])
    before = dict(both.loop.parameters)
    for refused in ({"controller.kp": 0.7, "controller.ki": -1.0}, {"controller.kp": 0.7, "controller.kq": 1.0},
                    {"controller.kp": 0.7, "seed": 3}):  # fmt: skip
        with pytest.raises((ValueRefused, NameUnknown)):
            both.set_all(refused)
        assert both.loop.parameters == before
    assert np.array_equal(one.advance(30)["actual"], both.advance(30)["actual"])


def test_a_switch_takes_the_compiled_program_of_a_loop_that_fits_and_gives_the_same_bits():
    loop = Loop(reference=zoo.sine, controller=zoo.pid, plant=zoo.mass, metrics={}, engine="python")
    live = loop.start()
    live.advance(50)
    shared, other = live.switch(zoo.pid(kp=0.5)), live.switch(zoo.observed)
    assert shared.program is live.program and other.program is not live.program
    programs.clear()
    alone = live.switch(zoo.pid(kp=0.5))
    assert alone.program is not live.program
    assert np.array_equal(alone.advance(40)["actual"], shared.advance(40)["actual"])


def test_a_loop_that_diverges_stops_and_says_when_and_where():
    loop = Loop(
        reference=zoo.sine,
        controller=zoo.pid(kp=1e6),
        plant=zoo.mass,
        substeps=1,
        metrics={"rms": STANDARD["rms_error"]},
    )
    runs = {}
    for engine in ("llvm", "python"):
        with pytest.warns(DivergenceWarning, match="diverged at t ="):
            runs[engine] = loop.run(20.0, engine=engine)
    a, b = runs["llvm"], runs["python"]
    assert a.diverged is not None and b.diverged is not None
    assert (a.diverged.time, a.diverged.state) == (b.diverged.time, b.diverged.state)
    assert 0 < len(a.time) < 20_000 and len(a.time) == a.diverged.period + 1
    assert math.isnan(a.metrics.rms)
    with pytest.raises(Diverged, match="diverged at") as caught:
        a.check()
    assert caught.value.run is a
    batch = loop.batch(20.0, {"controller.kp": np.array([1e6, 1.0, 1e6])})
    assert batch.diverged_at[0] == a.diverged.time and math.isnan(batch.diverged_at[1])
    assert math.isnan(batch.metrics["rms"][0]) and batch.metrics["rms"][1] > 0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert loop.batch(1.0, {"controller.kp": [1e6]}, engine="python").diverged_at.shape == (1,)
    assert loop.using({"controller.kp": 1.0}).run(0.1).check().diverged is None


def test_leaving_the_stated_bound_is_divergence():
    loop = Loop(reference=zoo.sine(amplitude=10.0), controller=zoo.pid, plant=zoo.mass, bound=5.0, metrics={})
    with pytest.warns(DivergenceWarning, match="left its bound of 5"):
        run = loop.run(2.0)
    assert run.diverged is not None and run.diverged.state == "actual" and abs(run["actual"][-1]) > 5.0


@controller(None)
def one_over(command, feedback):
    """Divides by what is zero at the start of the second period."""
    return 1.0 / (command - command) if feedback >= 0 else 0.0


def test_division_by_zero_is_infinity_on_every_engine_and_named_by_the_python_one():
    loop = Loop(reference=zoo.sine, controller=one_over, plant=zoo.mass, metrics={})
    with pytest.warns(DivergenceWarning):
        a, b = loop.run(1.0), loop.run(1.0, engine="python")
    assert a.diverged is not None and b.diverged is not None and a.diverged.period == b.diverged.period == 0
    assert b.diverged.place.startswith(__file__) and "0.0" in b.diverged.place
    line = int(b.diverged.place.split(":")[1].split()[0])
    from pathlib import Path

    assert "1.0 / (command" in Path(__file__).read_text().splitlines()[line - 1]


class TableParams(NamedTuple):
    table: np.ndarray = np.arange(4.0)
    at: int = 2


@controller(TableParams())
def looked_up(p, command):
    """A number of a table."""
    return p.table[p.at] + p.table[-1]


class WriteState(NamedTuple):
    ring: np.ndarray = np.zeros(3)


@controller(TableParams(), WriteState())
def written(p, s, command):
    """Writes where told."""
    s.ring[p.at] = command
    return s, s.ring[0]


@pytest.mark.parametrize("engine", ["llvm", "python"])
def test_reading_or_writing_outside_an_array_is_divergence_not_garbage(engine):
    loop = Loop(reference=zoo.sine, controller=looked_up, plant=zoo.mass, metrics={}, engine=engine)
    assert loop.run(0.002)["output"][0] == 5.0
    for at in (4, -1, 10**9):
        with pytest.warns(DivergenceWarning):
            lost = loop.using({"controller.at": at}).run(0.1)
        assert lost.diverged is not None and lost.diverged.period == 0
    loop = Loop(reference=zoo.sine, controller=written, plant=zoo.mass, metrics={}, engine=engine)
    assert loop.run(0.01).diverged is None
    with pytest.warns(DivergenceWarning, match=r"controller\.ring"):
        lost = loop.using({"controller.at": 3}).run(0.1)
    assert lost.diverged is not None and lost.diverged.period == 0


def test_tables_can_vary_from_run_to_run():
    loop = Loop(reference=zoo.sine, controller=looked_up, plant=zoo.mass, metrics={})
    tables = np.random.default_rng(1).uniform(-1, 1, (37, 4))
    batch = loop.batch(0.01, {"controller.table": tables}, record="output")
    np.testing.assert_array_equal(batch["output"][:, 0], tables[:, 2] + tables[:, 3])


def test_the_state_at_the_start_and_a_prepared_block_follow_their_parameters():
    class Start(NamedTuple):
        x0: float = 1.0
        rate: float = 2.0

    class Ready(NamedTuple):
        factor: float
        x0: float

    def ready(p, dt):
        return Ready(math.exp(-p.rate * dt), p.x0)

    def begin(p):
        return LineState(p.x0)

    def decay(p, s, u, dt):
        return LineState(p.factor * s.x + 0.0 * (u + dt + p.x0))

    block = make("plant", decay, Start(), LineState(), prepare=ready, initial=begin)
    loop = Loop(reference=zoo.sine, controller=through, plant=block, metrics={})
    run = loop.using({"plant.x0": 3.0, "plant.rate": 5.0}).run(0.11)
    np.testing.assert_allclose(run["actual"], 3.0 * np.exp(-5.0 * run.time), rtol=1e-12)
    batch = loop.batch(0.11, {"plant.x0": [3.0, 1.0, 3.0], "plant.rate": [5.0, 1.0, 1.0]}, record="actual")
    np.testing.assert_array_equal(batch["actual"][0], run["actual"])
    np.testing.assert_allclose(batch["actual"][2], 3.0 * np.exp(-batch.time), rtol=1e-12)


def test_a_sweep_has_the_shape_of_its_grid():
    loop = Loop(reference=zoo.sine, controller=zoo.pid, plant=zoo.mass, metrics={"rms": STANDARD["rms_error"]})
    seen = []
    sweep = loop.sweep(0.1, {"controller.kp": [0.5, 1.0, 2.0], "controller.kd": [0.0, 0.01]}, progress=seen.append)
    assert sweep.grid("rms").shape == (3, 2) and len(sweep) == 6
    assert sweep.grid("rms")[2, 1] == loop.using({"controller.kp": 2.0, "controller.kd": 0.01}).run(0.1).metrics.rms
    assert sweep.run(5).rms == sweep.grid("rms")[2, 1] and seen[-1] == 1.0
    with pytest.raises(NameUnknown, match="rms"):
        sweep.grid("rmse")
    with pytest.raises(NameUnknown):
        sweep["actual"]


def test_the_two_axes_have_an_error_each():
    loop = Loop(reference=zoo.circle, controller=zoo.two_pids, plant=zoo.table, metrics={})
    run = loop.run(0.2)
    np.testing.assert_array_equal(run["true_error.y"], run["command.y"] - run["actual.y"])
    assert {"error.x", "error.y", "applied.x"} <= set(run.signals)
    assert run["command"] is run.signals["command.x"]


def test_recording_every_nth_period_and_chosen_signals():
    loop = Loop(reference=zoo.sine, controller=zoo.pid, plant=zoo.mass, metrics={})
    full = loop.run(0.1)
    some = loop.run(0.1, record=["actual", "controller"], every=9)
    assert list(some.signals) == ["time", "actual", "controller.integral", "controller.last_error"]
    np.testing.assert_array_equal(some["actual"], full["actual"][::9])
    assert loop.run(0.1, every=0).signals == {}
    with pytest.raises(NameUnknown, match=r"did you mean .*plant\.position"):
        loop.run(0.1, record="plant.positio")
    with pytest.raises(NameUnknown, match="was not recorded"):
        some["output"]


def test_metrics_read_as_attributes():
    run = Loop(reference=zoo.sine, controller=zoo.pid, plant=zoo.mass).run(0.5)
    assert set(run.metrics) == set(STANDARD)
    errors = run["true_error"]
    assert run.metrics.rms_error == pytest.approx(np.sqrt(np.mean(errors**2)), rel=1e-12)
    assert run.metrics.max_error == np.abs(errors).max()
    with pytest.raises(AttributeError, match="rms_error"):
        _ = run.metrics.rms_eror
    assert "rms_error" in repr(run) and "<table>" in run._repr_html_()
    run.loop.name = "<script>"
    assert "<script>" not in run._repr_html_()


# ---- the contract of blocks
def test_blocks_that_break_the_contract_are_refused():
    class P(NamedTuple):
        a: float = 1.0

    with pytest.raises(BlockError, match="starts with"):
        controller(P())(lambda command: command)
    with pytest.raises(BlockError, match="cannot take 'speed'"):
        make("controller", bad_signal, P())
    with pytest.raises(BlockError, match="must be an instance of a NamedTuple"):
        make("controller", bad_signal, {"a": 1})
    with pytest.raises(BlockError, match="a plant needs a state"):
        make("plant", hold_last)
    with pytest.raises(BlockError, match="returns \\(next_state, signal\\)"):
        Loop(**{**GOOD, "controller": make("controller", forgets_state, None, Empty())}).run(0.1)
    with pytest.raises(BlockError, match="a plant returns its state"):
        Loop(**{**GOOD, "plant": make("plant", returns_number, None, Empty())}).run(0.1)
    with pytest.raises(BlockError, match="not a field"):
        Loop(**{**GOOD, "plant": make("plant", hold_last, None, Empty(), output="y")}).run(0.1)
    with pytest.raises(BlockError, match="next state is CountState, not Empty"):
        Loop(**{**GOOD, "controller": make("controller", other_state, None, Empty())}).run(0.1)
    with pytest.raises(BlockError, match="it returned 2 values; a step without state returns its signal alone"):
        Loop(**{**GOOD, "controller": make("controller", gives_pair, None)}).run(0.1)
    with pytest.raises(BlockError, match="may take p and s"):
        Loop(**{**GOOD, "plant": make("plant", hold_last, None, Empty(), output=wants_more)}).run(0.1)
    with pytest.raises(BlockError, match="is int; an integrated state"):
        Loop(**{**GOOD, "plant": make("plant", int_plant, None, CountState())}, method="sdirk3").run(0.1)
    with pytest.raises(BlockError, match="2 numbers"):
        Loop(**{**GOOD, "disturbance": make("disturbance", two_loads, None)}).run(0.1)
    with pytest.raises(BlockError, match="period=None"):
        Loop(**{**GOOD, "controller": make("controller", forgets_state, None, Empty(), continuous=True)})
    with pytest.raises(BlockError, match="brings its own step"):
        Loop(**{**GOOD, "controller": through, "plant": integrator, "period": None})
    with pytest.raises(BlockError, match="cannot have state"):
        Loop(**{**GOOD, "controller": through, "sensor": zoo.ruler, "period": None})
    with pytest.raises(ValueRefused, match="need a control period"):
        Loop(**{**GOOD, "controller": through, "transport_delay": 0.001, "period": None})


def bad_signal(p, speed):
    return speed


def forgets_state(s, command):
    return command


def returns_number(s, u):
    return u


def other_state(s, command):
    return CountState(1), command


def gives_pair(command):
    return (command, command)


def wants_more(p, s, t):
    return t


def int_plant(s, u):
    return CountState(1)


def two_loads(t):
    return zoo.Two(t, t)


def test_a_load_can_be_an_axis_each_and_an_output_disturbance_moves_the_first_axis():
    loop = Loop(
        reference=zoo.circle, controller=zoo.two_pids, plant=zoo.table, metrics={},
        disturbance=disturbance(None)(two_loads), output_disturbance=zoo.drift,
    )  # fmt: skip
    run = loop.run(0.05)
    assert {"disturbance.x", "disturbance.y"} <= set(run.signals)
    np.testing.assert_array_equal(run.signals["disturbance.x"], run.time)
    assert run["actual.x"][0] == pytest.approx(0.0)
    scalar = Loop(reference=zoo.circle, controller=zoo.two_pids, plant=zoo.table, metrics={}, disturbance=zoo.push).run(
        0.05
    )
    assert np.isfinite(scalar["actual.y"]).all()


def test_a_block_called_with_keywords_is_a_copy_and_with_arguments_its_step():
    changed = zoo.pid(kp=3.0)
    assert changed.params.kp == 3.0 and zoo.pid.params.kp == 1.32
    state, output = zoo.pid(zoo.PIDParams(), zoo.PIDState(), 1.0, 0.0, 1e-3)
    assert state.integral == 1e-3 and output > 1.32
    assert zoo.pid() is zoo.pid
    assert zoo.pid.starting(integral=2.0).state.integral == 2.0
    with pytest.raises(NameUnknown, match="did you mean kp"):
        zoo.pid(kpp=1.0)


def test_a_metric_of_ones_own():
    class S(NamedTuple):
        worst: float = 0.0

    def value(s):
        return s.worst

    def worst_output(s, output, t):
        return S(max(s.worst, abs(output) * (t > 0.05)))

    mine = metric(None, S(), output=value)(worst_output)
    run = Loop(**{**GOOD, "metrics": {"worst": mine}}).run(0.2)
    assert run.metrics.worst == np.abs(run["output"][run.time > 0.05]).max()
