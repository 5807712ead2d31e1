"""The limited axis by SciPy alone: one differential equation for each state of the limits, switched at events."""

import numpy as np
from scipy.integrate import solve_ivp

OHM, SUPPLY, FULL = 6.4, 30.0, 289.0
PWM, ELECTRICAL, MECHANICAL, GRATING = 0.0008, 0.0015, 0.017, 0.006
HENRY = OHM * ELECTRICAL * MECHANICAL / (ELECTRICAL + MECHANICAL)
PUSH = FULL / SUPPLY * OHM / (ELECTRICAL + MECHANICAL)


def event(function):
    function.terminal, function.direction = True, -1
    return function


def outward(y, side):
    """Voltage left for a change of current, positive where it pushes the current further out."""
    return side * (y[0] - OHM * y[1] - SUPPLY * y[2] / FULL)


def solve(duties, largest_current, top_speed, dt=1e-3):
    """Volt, ampere, mm/s, mm, mm read: at the start and after every period."""
    y, mode, side, rows = np.zeros(5), "free", 0.0, [np.zeros(5)]
    for u in duties:
        t = 0.0
        while t < dt - 1e-15:
            held = mode

            def slopes(_, y, u=u, held=held):
                current = 0.0 if held == "current" else outward(y, 1.0) / HENRY
                speed = 0.0 if held == "speed" else PUSH * y[1]
                return [(-SUPPLY * u - y[0]) / PWM, current, speed, y[2], (y[3] - y[4]) / GRATING]

            events = {
                "free": [
                    event(lambda _, y: largest_current - abs(y[1])),
                    event(lambda _, y: top_speed - abs(y[2])),
                ],
                "current": [event(lambda _, y, side=side: outward(y, side))],
                "speed": [event(lambda _, y, side=side: side * y[1])],
            }[mode]
            found = solve_ivp(slopes, (t, dt), y, "DOP853", events=events, max_step=2e-4, rtol=1e-10, atol=1e-12)
            t, y = found.t[-1], found.y[:, -1]
            if found.status == 1 and mode == "free":
                which = 1 if len(found.t_events[0]) else 2
                mode, side = ("current", "speed")[which - 1], np.sign(y[which])
                y[which] = side * (largest_current, top_speed)[which - 1]
            elif found.status == 1:
                mode = "free"
        rows.append(y.copy())
    return np.array(rows)
