"""The load cell and its filter, against the theory of a first-order low-pass."""

import numpy as np
import pytest

from leadscrew import Loop, controller
from leadscrew.kernel.noise import Noise
from leadscrew.plants._turning import turning
from leadscrew.references._cutting_program import cutting_force
from leadscrew.sensors._faulty_load_cell import faulty_load_cell
from leadscrew.sensors._load_cell import CutReading, lathe_reading, load_cell


@controller()
def standing(command, feedback):
    return 0.0 * command


@controller()
def cutting(command, feedback):
    return 35.5 / 150.0 + 0.0 * command


def at_rest(sensor, law=standing):
    return Loop(
        reference=cutting_force, controller=law, plant=turning(runout=0.0), sensor=sensor, period=0.02, substeps=20,
        metrics={}, bound=1e6,
    )  # fmt: skip


@pytest.mark.slow
def test_the_filter_keeps_a_third_of_white_noise():
    run = at_rest(load_cell(noise_n=2.0)).run(400.0)
    raw = at_rest(load_cell(noise_n=2.0, keep=0.0)).run(400.0)
    assert raw["feedback"].std() == pytest.approx(2.0, rel=0.02)
    assert run["feedback"][50:].std() == pytest.approx(2.0 / 3.0, rel=0.03)


def test_the_filtered_force_is_the_recursion_of_the_raw_one():
    run = at_rest(lathe_reading(noise_n=2.0), cutting).run(2.0)
    y, kept = run["feedback.force"], 0.0
    for k, raw in enumerate(run["feedback.raw"]):
        kept = 0.8 * kept + 0.2 * raw
        assert y[k] == pytest.approx(kept, rel=1e-12, abs=1e-12)
    assert y[-1] == pytest.approx(150.0, abs=3.0)


@pytest.mark.slow
def test_both_sensors_read_the_same_noise():
    alone = at_rest(load_cell, cutting).run(1.0)["feedback"]
    whole = at_rest(lathe_reading, cutting).run(1.0)["feedback.force"]
    assert np.array_equal(alone, whole)


def test_counts_are_counts():
    sensor = lathe_reading(noise_n=0.0, keep=0.0, count_n=0.5, travel_count_mm=0.01, turn_counts=100.0)
    run = at_rest(sensor, cutting).run(1.0)
    for name, count, true in (("raw", 0.5, "force"), ("travel", 0.01, "travel"), ("turns", 0.01, "turns")):
        read = run[f"feedback.{name}"]
        assert np.allclose(read / count, np.round(read / count), atol=1e-6)
        assert np.abs(read - run[f"actual.{true}"]).max() <= 0.5 * count + 1e-9


@pytest.mark.parametrize(
    ("fault", "size", "expected"),
    [
        ("none", 3.0, [100.0, 110.0, 120.0, 130.0, 140.0]),
        ("constant", 3.0, [100.0, 100.0, 100.0, 100.0, 140.0]),
        ("dead", 3.0, [100.0, 0.0, 0.0, 0.0, 140.0]),
        ("saturated", -500.0, [100.0, -500.0, -500.0, -500.0, 140.0]),
        ("error_code", 9999.0, [100.0, 9999.0, 9999.0, 9999.0, 140.0]),
        ("jump", 3.0, [100.0, 113.0, 123.0, 133.0, 140.0]),
        ("drift", 50.0, [100.0, 110.0, 121.0, 132.0, 140.0]),
        ("wrong_scale", 0.5, [100.0, 55.0, 60.0, 65.0, 140.0]),
        ("frozen", 3.0, [100.0, 3.0, 3.0, 3.0, 140.0]),
    ],
)
def test_a_broken_cell_shows_what_its_table_says_from_its_first_sample_to_the_one_before_it_is_sound(
    fault, size, expected
):
    """Force rising by 10 N each 0.02 s, broken from 0.02 s on, sound again from 0.08 s on."""
    block = faulty_load_cell(
        fault=fault, size_n=size, from_s=0.02, until_s=0.08, **{"lathe.noise_n": 0.0, "lathe.keep": 0.5}
    )
    state, shown, kept = block.state, [], 0.0
    for k in range(5):
        state, reading = block.step(
            block.params, state, CutReading(100.0 + 10.0 * k), 0.02 * k, 0.02, Noise(0, 0, 0, 0)
        )
        kept = 0.5 * kept + 0.5 * expected[k]
        assert reading.force == pytest.approx(kept), "the filter goes on from what is shown"
        shown.append(reading.raw)
    assert shown == pytest.approx(expected)
