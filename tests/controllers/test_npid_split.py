"""Nonlinear PID in two paths: its parts, its limits as a PID, its start and its limit."""

import math

import numpy as np
import pytest

from leadscrew.controllers._npid_split import npid_split
from leadscrew.studies.npid_xytable.tunings import table_pid
from tests.controllers.xy_loop import outputs

ERRORS = 1e-3 * np.array([0.0, 0.4, -0.7, 2.0, 9.0, -3.0, 0.1])


def same_paths(**gains):
    return npid_split.using(**{f"{path}.{k}": v for path in ("quiet", "firm") for k, v in gains.items()})


def test_two_alike_paths_are_a_plain_pid():
    gains = {"kp": 1.1, "ki": 90.0, "kd": 0.004, "filter_s": 0.0007}
    split = outputs(same_paths(**gains), ERRORS, 0.0 * ERRORS)
    np.testing.assert_allclose(split, outputs(table_pid(**gains), ERRORS, 0.0 * ERRORS), rtol=1e-12)


def test_each_path_gets_its_part_of_the_error():
    law = npid_split.using(**{"quiet.kp": 2.0, "firm.kp": 5.0, "es_um": 0.8}).using(
        **{f"{path}.{k}": 0.0 for path in ("quiet", "firm") for k in ("ki", "kd", "filter_s")}
    )
    for error_um in (0.1, -0.8, 4.0):
        small = 0.8 * math.atan(error_um / 0.8)
        expected = 1e-3 * (2.0 * small + 5.0 * (error_um - small))
        assert outputs(law, [1e-3 * error_um], [0.0])[0] == pytest.approx(expected, rel=1e-12)


def test_small_errors_see_the_quiet_path_and_large_ones_the_firm_one():
    quiet, firm = npid_split.params.quiet, npid_split.params.firm

    def gain(error):
        return outputs(npid_split, [error], [0.0])[0] / error

    def linear(path):
        return path.kp + path.ki * 5e-4 + path.kd / (path.filter_s + 5e-4)

    assert gain(1e-7) == pytest.approx(linear(quiet), rel=1e-3)
    assert gain(10.0) == pytest.approx(linear(firm), rel=1e-3)


def test_the_start_is_bumpless_and_the_limit_holds_the_integral():
    state = npid_split.align(npid_split.params, 0.02, 0.011, 0.4)
    _, output = npid_split.step(npid_split.params, state, 0.02, 0.011, 5e-4)
    assert output == pytest.approx(0.4, abs=1e-12)
    limited = npid_split(lower=-0.05, upper=0.05)
    state = limited.state
    for _ in range(50):
        state, output = limited.step(limited.params, state, 1.0, 0.0, 5e-4)
    assert output == 0.05 and state.integral == 0.0
