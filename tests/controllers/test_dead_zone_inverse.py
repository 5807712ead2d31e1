"""The dead-zone compensator against the dead zone itself, and against what the XY table loses to one."""

import math

import numpy as np
import pytest

from leadscrew.actuators._dead_zone import dead_zone
from leadscrew.controllers._dead_zone_inverse import dead_zone_inverse, narrowed, widened
from leadscrew.references._eased_sine import eased_sine
from leadscrew.studies.npid_xytable.tunings import TUNINGS, table_pid
from leadscrew.util.errors import BlockError, ValueRefused
from tests.controllers.xy_loop import PERIOD, outputs, xy_loop

DRIVE = dead_zone(threshold=0.02, subtract=True)
ERRORS = np.random.default_rng(4).normal(scale=0.05, size=200)


def test_without_softness_the_drive_sees_what_the_controller_meant():
    errors = np.concatenate([ERRORS, [0.0]])
    plain = outputs(table_pid, errors, np.zeros(201))
    through = [
        DRIVE(DRIVE.params, u) for u in outputs(dead_zone_inverse(table_pid, softness=0.0), errors, np.zeros(201))
    ]
    assert through == pytest.approx(plain, abs=1e-15)


def test_softened_it_adds_width_times_tanh():
    plain = outputs(table_pid, ERRORS, np.zeros(200))
    expected = [u + 0.02 * math.tanh(u / 1e-3) for u in plain]
    assert outputs(dead_zone_inverse(table_pid), ERRORS, np.zeros(200)) == pytest.approx(expected, rel=1e-15)


@pytest.mark.slow
def test_20_mv_of_dead_zone_and_what_compensating_all_and_80_percent_of_it_leaves():
    loop = xy_loop(dead_zone_inverse(table_pid), eased_sine(amplitude=1.0, frequency=0.7), actuator=DRIVE)
    changes = {
        "controller.width": np.array([0.0, 0.016, 0.02, 0.02]),
        "controller.softness": np.array([1e-3, 1e-3, 1e-3, 0.0]),
    }
    errors = 1e3 * loop.batch(12.0, changes, record="true_error")["true_error"][:, 4000:]
    bare = xy_loop(table_pid, eased_sine(amplitude=1.0, frequency=0.7)).run(12.0)
    healthy = 1e3 * bare["true_error"][4000:].std()
    rms = errors.std(axis=1)
    assert rms[:3] == pytest.approx([19.46, 7.85, 5.06], abs=0.01) and healthy == pytest.approx(5.04, abs=0.01)
    assert rms[3] == pytest.approx(healthy, rel=1e-6)


@pytest.mark.parametrize(("width", "softness"), [(0.02, 1e-3), (0.5, 0.01), (0.0, 1e-3), (0.02, 0.0)])
def test_the_way_back_undoes_the_way_there(width, softness):
    for u in (*ERRORS[:40].tolist(), 0.0, 3e-4, -1e-7):
        assert narrowed(widened(u, width, softness), width, softness) == pytest.approx(u, rel=1e-12, abs=1e-15)


@pytest.mark.parametrize(("softness", "output"), [(1e-3, 0.7), (1e-3, -0.004), (0.0, -0.7)])
def test_the_first_output_after_an_align_is_the_last_one_before(softness, output):
    block = dead_zone_inverse(TUNINGS["ours.pid_ms_159"], softness=softness)
    p = block.prepare(block.params, PERIOD)
    _, u = block.step(p, block.align(p, 1.0, 1.001, output), 1.0, 1.001, PERIOD)
    assert u == pytest.approx(output, abs=1e-12)


@pytest.mark.sweep
@pytest.mark.parametrize("softness", [1e-3, 0.0])
def test_all_engines_give_the_same_bits(softness):
    loop = xy_loop(
        dead_zone_inverse(table_pid, softness=softness), eased_sine(amplitude=4.0, frequency=3.0), actuator=DRIVE
    )
    record = ("output", "actual", "controller")
    fast, plain = (loop.run(0.2, record=record, engine=engine) for engine in ("llvm", "python"))
    assert all(np.array_equal(fast[name], plain[name]) for name in plain.signals)


def test_a_negative_width_and_what_is_no_controller_are_refused():
    with pytest.raises(ValueRefused, match=r"width = -0.1"):
        dead_zone_inverse(table_pid)(width=-0.1)
    with pytest.raises(BlockError, match=r"dead_zone_inverse\(dead_zone\)"):
        dead_zone_inverse(dead_zone)
