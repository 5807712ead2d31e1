"""The XY table with its dead time, under any controller: the loop of the tests of what rejects disturbances."""

import numpy as np

from leadscrew.controllers._wrapping import takes_motion
from leadscrew.kernel.loop import Loop
from leadscrew.plants._xy_table_cutting import xy_table_cutting
from leadscrew.references._eased_sine import eased_sine, eased_sine_motion

PERIOD = 0.5e-3
UM = 1e3


def table_axis(controller, amplitude=1.0, disturbance=None, sensor=None, frequency=0.7, period=PERIOD, **plant):
    """A sine that grows in 1 s; ``amplitude = 0`` holds still."""
    reference = eased_sine_motion if takes_motion(controller) else eased_sine
    return Loop(
        reference=reference(amplitude=amplitude, frequency=frequency),
        controller=controller,
        plant=xy_table_cutting(**plant),
        disturbance=disturbance,
        sensor=sensor,
        period=period,
        metrics={},
    )


def lines_um(run, frequencies, seconds=10.0, dt=PERIOD):
    """Amplitudes of the true error at these frequencies in the last seconds, by least squares, um."""
    error = UM * run["true_error"][-round(seconds / dt) :]
    t = dt * np.arange(len(error))
    angles = 2.0 * np.pi * np.outer(t, frequencies)
    columns = np.hstack([np.ones((len(t), 1)), t[:, None], np.sin(angles), np.cos(angles)])
    found = np.linalg.lstsq(columns, error, rcond=None)[0][2:]
    return np.hypot(found[: len(frequencies)], found[len(frequencies) :])


def rms_um(run, seconds=10.0, dt=PERIOD):
    """The true error's RMS in the last seconds, um."""
    return UM * float(np.sqrt(np.mean(run["true_error"][-round(seconds / dt) :] ** 2)))


def tried(block, commands, feedbacks, dt=PERIOD, state=None):
    """What a controller's step gives, called by hand, with its prepared parameters."""
    p = block.params if block.prepare is None else block.prepare(block.params, dt)
    s, seen = block.state if state is None else state, []
    for command, feedback in zip(commands, feedbacks, strict=True):
        s, u = block.step(p, s, command, float(feedback), dt)
        seen.append(u)
    return seen
