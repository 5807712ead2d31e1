"""A log for the tests: 20 kg with Coulomb and viscous friction under a PD controller, written out step by step."""

from functools import cache

import numpy as np


@cache
def moves(seconds=3.0, period=1e-3, step=1e-6, gain=1.0):
    """Time s, drive N, position m (on counts), command m; the controller's gains times ``gain``."""
    count = round(seconds / period)
    time = period * np.arange(count)
    command = 0.05 * (np.sin(2.0 * time) + 0.4 * np.sin(7.0 * time)) * np.minimum(time / 0.5, 1.0)
    drive, position = np.zeros(count), np.zeros(count)
    x, v, before = 0.0, 0.0, 0.0
    for k in range(count):
        position[k] = np.round(x / step) * step
        rate = (position[k] - before) / period
        before = position[k]
        drive[k] = np.clip(gain * (4e5 * (command[k] - position[k]) - 2.5e3 * rate), -400.0, 400.0)
        for _ in range(5):
            v += period / 5.0 / 20.0 * (drive[k] - 15.0 * np.tanh(v / 1e-4) - 60.0 * v)
            x += period / 5.0 * v
    for array in (time, drive, position, command):
        array.flags.writeable = False
    return time, drive, position, command


def arrays(**changes):
    """The log by role, with some signals changed; None leaves one out."""
    time, drive, position, command = moves()
    held = {"time": time, "drive": drive, "position": position, "command": command, **changes}
    return {role: values for role, values in held.items() if values is not None}
