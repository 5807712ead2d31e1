"""What a controller does in HAL, in the real LinuxCNC: directions, faults, limits and the index."""

import numpy as np
import pytest

from leadscrew.export import hal, hal_run
from tests.export.hal_bench import Bench, needed


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    needed()
    with hal_run.workplace() as place:
        yield Bench(place, tmp_path_factory.mktemp("hal"))


def test_one_parameter_one_bit_off_gives_other_outputs(bench):
    inputs, outputs = bench.record("demo_down")
    assert (bench.stream("demo_down", inputs).outputs == outputs).all()
    other = repr(float(np.nextafter(0.25, 1.0)))
    off = bench.stream("demo_down", inputs, setup=[f"setp demo-down.0.kp {other}"]).outputs
    assert (off != outputs).any()
    assert np.abs(off - outputs).max() < 1e-12


@pytest.mark.parametrize("gain", [100.0, 20.0])
@pytest.mark.parametrize("name", ["demo_down", "demo_up", "demo_single"])
def test_the_first_move_is_in_the_direction_of_stock_pid(bench, name, gain):
    comp = hal.component(name)
    ours, drive, _ = bench.loop(f"loadrt {name}", f"{comp}.0", f"{comp}.0", gain=gain)
    pid = ["setp pid.0.Pgain 0.25", "setp pid.0.maxoutput 0.3"]
    stock, stock_drive, _ = bench.loop("loadrt pid num_chan=1", "pid.0", "pid.0.do-pid-calcs", pid, gain)
    assert stock[np.flatnonzero(stock)[0]] > 0
    assert ours[np.flatnonzero(ours)[0]] > 0
    assert (drive[np.flatnonzero(drive)[0]] > 0) == (stock_drive[np.flatnonzero(stock_drive)[0]] > 0)
    assert abs(ours[-1] - 1.0) < 0.2


def test_with_feedback_the_wrong_way_round_it_stops_within_the_limit(bench):
    read = ["show pin demo-down.0.fault-code"]
    feedback, output, text = bench.loop("loadrt demo_down", "demo-down.0", "demo-down.0", gain=-100.0, after=read)
    assert "s32 OUT 3 demo-down.0.fault-code" in text
    assert output[-1] == 0.0
    assert -5.5 < feedback.min() < -5.0


def test_disabled_the_output_is_zero_and_the_controller_starts_anew(bench):
    inputs, _ = bench.record("demo_down", 600)
    enable = np.ones(600, dtype=bool)
    enable[200:300] = False
    got = bench.stream("demo_down", inputs, bits={"enable": enable}).outputs
    again = bench.stream("demo_down", inputs[300:]).outputs
    assert (got[200:300] == 0).all()
    assert (got[:200] != 0).sum() > 190
    assert (got[300:] == again).all()


def test_a_number_that_is_not_finite_stops_the_axis_until_enable_is_taken_away(bench):
    inputs, outputs = bench.record("demo_down", 400)
    inputs[100, 2] = np.nan
    inputs[300, 0] = np.inf
    enable = np.ones(400, dtype=bool)
    enable[200] = False
    got = bench.stream("demo_down", inputs, bits={"enable": enable})
    assert (got.outputs[:100] == outputs[:100]).all()
    assert (got.outputs[100:201] == 0).all()
    assert (got.outputs[201:300] != 0).all()
    assert (got.outputs[300:] == 0).all()
    assert got.faults.tolist() == [0] * 100 + [1] * 100 + [0] * 100 + [1] * 100


def test_a_following_error_stops_the_axis_and_its_limit_can_be_set(bench):
    inputs, outputs = bench.record("demo_down", 400)
    inputs[100:, 0] += 150.0
    got = bench.stream("demo_down", inputs)
    assert (got.outputs[:100] == outputs[:100]).all()
    assert (got.outputs[100:] == 0).all()
    assert (got.faults == np.repeat([0, 2], [100, 300])).all()
    wide = bench.stream("demo_down", inputs, setup=["setp demo-down.0.max-following-error 0"])
    assert (wide.faults == 0).all()
    assert (wide.outputs[100:] != 0).all()


def test_the_output_is_held_to_maxoutput(bench):
    inputs, _ = bench.record("demo_up", 400)
    read = ["show pin demo-up.0.saturated"]
    got = bench.stream("demo_up", inputs, setup=["setp demo-up.0.maxoutput 0.01"], after=read)
    free = bench.stream("demo_up", inputs, setup=["setp demo-up.0.maxoutput 0"]).outputs
    assert (got.outputs == np.clip(free, -0.01, 0.01)).all()
    assert np.abs(free).max() > 0.05


@pytest.mark.parametrize("jump", [-7.25, 1234.5])
def test_a_jump_of_the_coordinates_at_the_index_makes_no_spike(bench, jump):
    inputs, _ = bench.record("demo_down", 600)
    index = np.zeros(600, dtype=bool)
    index[100:300] = True
    jumped = inputs.copy()
    jumped[300:, [0, 2]] += jump
    smooth = bench.stream("demo_down", inputs).outputs
    at_index = bench.stream("demo_down", jumped, bits={"index-enable": index}).outputs
    assert np.abs(at_index - smooth).max() < 1e-9 * np.abs(smooth).max()


def test_the_jump_at_the_index_is_not_seen_by_a_derived_velocity_either(bench):
    time = np.arange(600) * 1e-3
    ramp = {"command": 20.0 * time, "feedback": 20.0 * time - 0.125}
    index = (np.arange(600) >= 100) & (np.arange(600) < 300)
    smooth = bench.replay("demo_down", ramp).outputs
    jumped = {pin: x + np.where(time >= 0.3, 55.0, 0.0) for pin, x in ramp.items()}
    noted = bench.replay("demo_down", jumped, bits={"index-enable": index}).outputs
    unnoted = bench.replay("demo_down", jumped).outputs
    assert np.abs(noted - smooth).max() < 1e-9 * np.abs(smooth).max()
    assert np.abs(unnoted - smooth).max() > 0.1
