"""The lathe servo's loop in plain Python by hand: the plant in local floats, no containers in it, no calls."""

from __future__ import annotations

from math import floor
from typing import Any

from leadscrew.bench.loops import SUBSTEPS
from leadscrew.bench.yardstick import Lathe


class Controller:
    """Sensor and controller of the loop, for tools that bring their own plant."""

    def __init__(self, p: Lathe) -> None:
        self.p, self.centres, self.widths, self.rules = p, list(p.centres), list(p.reciprocal_widths), list(p.rules)
        self.e = self.started = 0.0

    def shape(self, x: float, y: float) -> float:
        """The output of the 36 rules."""
        c, w, t = self.centres, self.widths, self.rules
        x = c[0] if x < c[0] else c[5] if x > c[5] else x
        y = c[0] if y < c[0] else c[5] if y > c[5] else y
        i = (x >= c[1]) + (x >= c[2]) + (x >= c[3]) + (x >= c[4])
        j = (y >= c[1]) + (y >= c[2]) + (y >= c[3]) + (y >= c[4])
        mu, nu, k = (x - c[i]) * w[i], (y - c[j]) * w[j], 6 * i + j
        lower, upper = (1.0 - nu) * t[k] + nu * t[k + 1], (1.0 - nu) * t[k + 6] + nu * t[k + 7]
        return (1.0 - mu) * lower + mu * upper

    def duty(self, reading: float) -> float:
        """The duty for a reading of the grating."""
        p = self.p
        e = (p.target - p.resolution * floor(reading / p.resolution + 0.5)) / p.error_scale
        ec = self.started * ((e - self.e) * p.error_scale * (p.rate_interval / p.period)) / p.rate_scale
        alpha_e = abs(e) ** p.tau + p.floor if self.started else 1.0
        alpha_ec = abs(ec) ** p.tau + p.floor if self.started else 1.0
        beta = p.output_gain * (abs(e) ** p.output_tau + p.floor if self.started else 1.0)
        self.e, self.started = e, 1.0
        return min(1.0, max(-1.0, beta * self.shape(e / alpha_e, ec / alpha_ec)))


def rates(p: Lathe, x: Any, duty: float) -> list[float]:
    """The chain's derivative, for integrators."""
    drive = -p.full_duty_speed * duty
    return [
        (drive - x[0]) / p.pwm_lag,
        (x[0] - x[1]) / p.electrical_lag,
        (x[1] - x[2]) / p.mechanical_lag,
        x[2],
        (x[3] - x[4]) / p.grating_lag,
    ]


def hold(p: Lathe, periods: int) -> list[float]:
    """The loop with the exact zero-order hold; positions at the start of each period."""
    control = Controller(p)
    a0, a1, a2, a3, a4, a5, a6, a7, a8, a9, a10, a11, a12, a13 = p.a
    b0, b1, b2, b3, b4 = p.b
    c0, c1, c2, c3, c4, c5 = control.centres
    centres, widths, t = control.centres, control.widths, control.rules
    target, resolution, error_scale, rate_scale = p.target, p.resolution, p.error_scale, p.rate_scale
    scale = p.error_scale * (p.rate_interval / p.period)
    tau, floor_, output_tau, gain, speed_, dt = p.tau, p.floor, p.output_tau, p.output_gain, p.full_duty_speed, p.period
    pwm = current = speed = position = reading = last = squares = absolutes = largest = 0.0
    started = False
    seen = []
    for _ in range(periods):
        seen.append(position)
        e = (target - resolution * floor(reading / resolution + 0.5)) / error_scale
        if started:
            ec = (e - last) * scale / rate_scale
            alpha_e, alpha_ec = abs(e) ** tau + floor_, abs(ec) ** tau + floor_
            beta = gain * (abs(e) ** output_tau + floor_)
        else:
            ec, alpha_e, alpha_ec, beta, started = 0.0, 1.0, 1.0, gain, True
        last = e
        x, y = e / alpha_e, ec / alpha_ec
        x = c0 if x < c0 else c5 if x > c5 else x
        y = c0 if y < c0 else c5 if y > c5 else y
        i = (x >= c1) + (x >= c2) + (x >= c3) + (x >= c4)
        j = (y >= c1) + (y >= c2) + (y >= c3) + (y >= c4)
        mu, nu, k = (x - centres[i]) * widths[i], (y - centres[j]) * widths[j], 6 * i + j
        lower, upper = (1.0 - nu) * t[k] + nu * t[k + 1], (1.0 - nu) * t[k + 6] + nu * t[k + 7]
        rho = beta * ((1.0 - mu) * lower + mu * upper)
        rho = 1.0 if rho > 1.0 else -1.0 if rho < -1.0 else rho
        error = target - position
        size = abs(error)
        squares += error * error * dt
        absolutes += size * dt
        largest = size if size > largest else largest
        drive = -speed_ * rho
        reading = a9 * pwm + a10 * current + a11 * speed + a12 * position + a13 * reading + b4 * drive
        position = a6 * pwm + a7 * current + a8 * speed + position + b3 * drive
        speed = a3 * pwm + a4 * current + a5 * speed + b2 * drive
        current = a1 * pwm + a2 * current + b1 * drive
        pwm = a0 * pwm + b0 * drive
    return seen


def rk4(p: Lathe, periods: int) -> list[float]:
    """The loop with RK4; positions at the start of each period."""
    control = Controller(p)
    duty_of = control.duty
    t_p, t_e, t_m, t_g, dt, target, full = (
        p.pwm_lag, p.electrical_lag, p.mechanical_lag, p.grating_lag, p.period, p.target, p.full_duty_speed,
    )  # fmt: skip
    h = dt / SUBSTEPS
    half, sixth = 0.5 * h, h / 6.0
    v = c = w = x = g = squares = absolutes = largest = 0.0
    seen = []
    for _ in range(periods):
        seen.append(x)
        drive = -full * duty_of(g)
        size = abs(target - x)
        squares += size * size * dt
        absolutes += size * dt
        largest = size if size > largest else largest
        for _ in range(SUBSTEPS):
            v1, c1, w1, x1, g1 = (drive - v) / t_p, (v - c) / t_e, (c - w) / t_m, w, (x - g) / t_g
            v2, c2, w2, x2, g2 = v + half * v1, c + half * c1, w + half * w1, x + half * x1, g + half * g1
            v2, c2, w2, x2, g2 = (drive - v2) / t_p, (v2 - c2) / t_e, (c2 - w2) / t_m, w2, (x2 - g2) / t_g
            v3, c3, w3, x3, g3 = v + half * v2, c + half * c2, w + half * w2, x + half * x2, g + half * g2
            v3, c3, w3, x3, g3 = (drive - v3) / t_p, (v3 - c3) / t_e, (c3 - w3) / t_m, w3, (x3 - g3) / t_g
            v4, c4, w4, x4, g4 = v + h * v3, c + h * c3, w + h * w3, x + h * x3, g + h * g3
            v4, c4, w4, x4, g4 = (drive - v4) / t_p, (v4 - c4) / t_e, (c4 - w4) / t_m, w4, (x4 - g4) / t_g
            v += sixth * (v1 + 2.0 * v2 + 2.0 * v3 + v4)
            c += sixth * (c1 + 2.0 * c2 + 2.0 * c3 + c4)
            w += sixth * (w1 + 2.0 * w2 + 2.0 * w3 + w4)
            x += sixth * (x1 + 2.0 * x2 + 2.0 * x3 + x4)
            g += sixth * (g1 + 2.0 * g2 + 2.0 * g3 + g4)
    return seen


def rk4_step(p: Lathe, x: list[float], duty: float, h: float) -> list[float]:
    """One RK4 step of the plant, for tools that only step."""
    k1 = rates(p, x, duty)
    k2 = rates(p, [s + 0.5 * h * k for s, k in zip(x, k1, strict=True)], duty)
    k3 = rates(p, [s + 0.5 * h * k for s, k in zip(x, k2, strict=True)], duty)
    k4 = rates(p, [s + h * k for s, k in zip(x, k3, strict=True)], duty)
    return [s + h / 6.0 * (a + 2.0 * b + 2.0 * c + d) for s, a, b, c, d in zip(x, k1, k2, k3, k4, strict=True)]
