"""A simulated axis under a position and speed loop that runs a test move: independent of the plants of the package."""

import math

import numpy as np


def run(seen, *, mass, coulomb, viscous, offset=0.0, static=None, stribeck_speed=1.0, noise=1e-6, seed=1, delay=0,
        backlash=0.0, kpos=60.0, bandwidth=150.0, substeps=None):  # fmt: skip
    """Drive and measured position of each sample (N, m); ``coulomb``, ``viscous``, ``static`` by direction."""
    step = _exact if static is None else _euler
    static = coulomb if static is None else static
    rng = np.random.default_rng(seed)
    period = float(seen.time[1] - seen.time[0])
    substeps = substeps or (1 if step is _exact else 10)
    h = period / substeps
    x, v, table, integral, kvp = float(seen.position[0]), 0.0, float(seen.position[0]), 0.0, mass * bandwidth
    measured = before = x
    waiting = [0.0] * delay
    drive, position = np.zeros(len(seen.time)), np.zeros(len(seen.time))
    for k in range(len(seen.time)):
        measured = table + noise * rng.normal()
        wanted = kpos * (seen.position[k] - measured) + seen.velocity[k]
        speed_error = wanted - (measured - before) / period
        before = measured
        integral += 0.1 * bandwidth * kvp * speed_error * period
        drive[k] = kvp * speed_error + integral + mass * seen.acceleration[k]
        position[k] = measured
        waiting.append(drive[k])
        u = waiting.pop(0)
        for _ in range(substeps):
            x, v = step(x, v, u - offset, mass, coulomb, viscous, static, stribeck_speed, h)
            table = min(max(table, x - 0.5 * backlash), x + 0.5 * backlash)
    return drive, position


def _exact(x, v, push, mass, coulomb, viscous, static, speed, h):
    """Coulomb and viscous friction in closed form, from stop to stop."""
    while h > 0.0:
        if v == 0.0 and -coulomb[1] <= push <= coulomb[0]:
            return x, 0.0
        way = math.copysign(1.0, v if v != 0.0 else push)
        k = 0 if way > 0.0 else 1
        rate, force = viscous[k] / mass, push - way * coulomb[k]
        end = force / viscous[k]
        until = math.log(1.0 - v / end) / rate if v != 0.0 and end * v < 0.0 else math.inf
        t = min(h, until)
        fall = math.exp(-rate * t)
        x += end * t + (v - end) * (1.0 - fall) / rate
        v = 0.0 if until <= h else end + (v - end) * fall
        h -= t
    return x, v


def _euler(x, v, push, mass, coulomb, viscous, static, speed, h):
    """Semi-implicit Euler with exact sticking."""
    if v == 0.0:
        if -static[1] <= push <= static[0]:
            return x, 0.0
        way = 1.0 if push > 0.0 else -1.0
    else:
        way = 1.0 if v > 0.0 else -1.0
    k = 0 if way > 0.0 else 1
    level = coulomb[k] + (static[k] - coulomb[k]) * math.exp(-min((v / speed) ** 2, 700.0))
    after = (v + h / mass * (push - way * level)) / (1.0 + h * viscous[k] / mass)
    if v != 0.0 and after * way < 0.0:
        after = 0.0
    return x + 0.5 * h * (v + after), after
