"""First gains of a linear machine, judged by python-control on the exactly sampled plant with its delay."""

import control
import numpy as np
import pytest
from scipy.linalg import expm

from leadscrew.machine.file import MachineFile
from leadscrew.machine.gains import pid
from leadscrew.util.errors import DataError

W1, W2 = 2.0 * np.pi * 40.0, 2.0 * np.pi * 30.0
TWO_MASSES = np.polymul([1.0, 20.0, 0.0], [1.0 / W1**2, 0.04 / W1, 1.0])
"""A rigid axis with a resonance at 40 Hz of damping 2 %."""
LATHE = np.polymul(np.polymul([8e-4, 1.0], [1.5e-3, 1.0]), np.polymul([17e-3, 1.0], [1.0, 0.0]))
PLANTS = {
    "the XY table": ([69380.0], [1.0, 144.8, 166.3], 0.775e-3, 0.5e-3),
    "two integrators and 2 ms": ([1000.0], [1.0, 0.0, 0.0], 2e-3, 1e-3),
    "a lag and an integrator": ([500.0], [1.0, 20.0, 0.0], 0.0, 1e-3),
    "the lathe": ([289.0], LATHE, 0.0, 1e-3),
    "two masses, motor": (1e4 * np.array([1.0 / W2**2, 0.04 / W2, 1.0]), TWO_MASSES, 1e-3, 1e-3),
    "two masses, load": ([1e4], TWO_MASSES, 1e-3, 1e-3),
    "a resonance alone": ([400.0], [1.0 / 200.0**2, 2.0 * 0.005 / 200.0, 1.0], 0.0, 1e-3),
    "two integrators and a lag": ([1000.0], [0.01, 1.0, 0.0, 0.0], 0.0, 1e-3),
    "one lag and no delay": ([90.0], [1.0, 30.0], 0.0, 1e-3),
    "one lag, later than it is long": ([30.0], [1.0, 30.0], 40e-3, 1e-3),
}


def machine(numerator, denominator, delay, period, **more):
    return MachineFile(
        name="m", model="linear", position_unit="mm", drive_unit="V", period=period, drive=10.0, speed=100.0,
        acceleration=1e3, travel=(0.0, 100.0), delay_s=delay, identified={},
        parameters={"numerator": [float(v) for v in numerator], "denominator": [float(v) for v in denominator]}, **more,
    )  # fmt: skip


def sampled(numerator, denominator, delay, period):
    """The plant from sample to sample: the input of a period acts for the part that the delay leaves, then the next."""
    plant = control.tf2ss(control.tf(numerator, denominator))
    a, b, c = (np.asarray(m) for m in (plant.A, plant.B, plant.C))
    n, whole = len(a), int(delay / period + 1e-9)
    joined = np.block([[a, b], [np.zeros((1, n + 1))]])

    def held(seconds):
        return np.split(expm(joined * seconds)[:n], [n], axis=1)

    late = max(delay - whole * period, 0.0)
    rest, now = held(period - late)
    before = rest @ held(late)[1]
    # The states and the last inputs, newest first.
    big, drive = np.zeros((n + whole + 1, n + whole + 1)), np.zeros((n + whole + 1, 1))
    big[:n, :n] = held(period)[0]
    columns = [drive, *(big[:, n + k : n + k + 1] for k in range(whole + 1))]
    columns[whole][:n] += now
    columns[whole + 1][:n] += before
    drive[n] = 1.0
    big[n + 1 :, n : n + whole] += np.eye(whole)
    return control.ss(big, drive, np.concatenate([c, np.zeros((1, whole + 1))], axis=1), 0.0, period)


def controller(g, period):
    z = control.tf([1.0, 0.0], [1.0], period)
    return g.kp + g.ki * period * z / (z - 1) + g.kd * (z - 1) / ((g.filter_s + period) * z - g.filter_s)


@pytest.mark.parametrize("name", PLANTS)
def test_the_loop_of_the_first_gains_is_stable_and_its_peak_of_sensitivity_low(name):
    period = PLANTS[name][-1]
    gains = pid(machine(*PLANTS[name]))
    plant, law = sampled(*PLANTS[name]), control.tf2ss(controller(gains, period))
    assert np.abs(control.feedback(plant * law, 1).poles()).max() < 1.0
    z = np.exp(1j * period * np.geomspace(1e-2, np.pi / period, 1500))
    open_loop = plant(z) * law(z)
    assert np.abs(1.0 / (1.0 + open_loop)).max() < 1.55
    assert np.abs(open_loop / (1.0 + open_loop)).max() < 1.55
    # And it is no loop that does nothing.
    assert gains.ki > 0.0 and np.abs(open_loop).max() > 10.0


def test_a_coarse_encoder_and_a_noisy_one_lower_the_gains():
    fine, coarse, noisy = (pid(machine(*PLANTS["the XY table"], **more)) for more in
                           ({}, {"resolution": 0.2}, {"noise": 0.1}))  # fmt: skip
    for gains in (coarse, noisy):
        assert gains.kp < fine.kp
    assert 0.2 * (coarse.kp + coarse.kd / (coarse.filter_s + 5e-4)) <= 0.05 * 10.0
    assert 0.3 * (noisy.kp + noisy.kd / (noisy.filter_s + 5e-4)) <= 0.05 * 10.0


def test_a_plant_that_runs_backwards_is_refused_and_not_fed_back_positively():
    with pytest.raises(DataError, match="gain is negative"):
        pid(machine([-500.0], [1.0, 20.0, 0.0], 0.0, 1e-3))
