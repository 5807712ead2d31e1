"""Integrators of fixed cost, a step at a time. Shared signature: state and memory after ``dt``."""

from leadscrew.kernel.bits import stack_array2
from leadscrew.kernel.drivers import hooks
from leadscrew.kernel.drivers.linear import lu_factor, lu_solve

GAMMA = 0.435866521508459
A21 = 0.5 * (1.0 - GAMMA)
B1 = -0.25 * (6.0 * GAMMA * GAMMA - 16.0 * GAMMA + 1.0)
B2 = 0.25 * (6.0 * GAMMA * GAMMA - 20.0 * GAMMA + 5.0)
NEWTON = 4


def rk4(p, s, memory, u, load, t, dt):
    """Classical Runge-Kutta, order 4, explicit."""
    half = 0.5 * dt
    k1 = hooks.derivative(p, s, u, load, t)
    k2 = hooks.derivative(p, hooks.along(s, half, k1), u, load, t + half)
    k3 = hooks.derivative(p, hooks.along(s, half, k2), u, load, t + half)
    k4 = hooks.derivative(p, hooks.along(s, dt, k3), u, load, t + dt)
    return hooks.weighted(s, dt / 6.0, k1, k2, k3, k4), memory


def newton_stage(p, s, u, load, t, dt, start, x, f, g, lu, swaps):
    """Solves ``x = start + GAMMA dt f(x)`` by a fixed number of simplified Newton steps; ``f`` ends as ``f(x)``."""
    n = hooks.ORDER
    for _ in range(NEWTON):
        hooks.rates(p, s, u, load, t, x, f)
        for i in range(n):
            g[0, i] = start[0, i] + GAMMA * dt * f[0, i] - x[0, i]
        lu_solve(lu, swaps, g, n)
        for i in range(n):
            x[0, i] += g[0, i]
    for i in range(n):
        f[0, i] = (x[0, i] - start[0, i]) / (GAMMA * dt)
    return 0


def sdirk3(p, s, memory, u, load, t, dt):
    """Alexander's singly diagonally implicit method, order 3, L-stable, stiffly accurate, three stages.

    Source: R. Alexander, SIAM J. Numer. Anal. 14 (1977) 1006.
    """
    n = hooks.ORDER
    x0 = stack_array2(1, hooks.ORDER)
    x = stack_array2(1, hooks.ORDER)
    f1 = stack_array2(1, hooks.ORDER)
    f2 = stack_array2(1, hooks.ORDER)
    f3 = stack_array2(1, hooks.ORDER)
    g = stack_array2(1, hooks.ORDER)
    swaps = stack_array2(hooks.ORDER, hooks.ORDER)
    lu = stack_array2(hooks.ORDER, hooks.ORDER)
    hooks.spread(s, x0)
    hooks.rates(p, s, u, load, t, x0, f1)
    hooks.jacobian(p, s, u, load, t, x0, f1, lu)
    for i in range(n):
        for j in range(n):
            lu[i, j] = (1.0 if i == j else 0.0) - GAMMA * dt * lu[i, j]
    lu_factor(lu, swaps, n)
    for i in range(n):
        x[0, i] = x0[0, i]
    newton_stage(p, s, u, load, t + GAMMA * dt, dt, x0, x, f1, g, lu, swaps)
    start = stack_array2(1, hooks.ORDER)
    for i in range(n):
        start[0, i] = x0[0, i] + dt * A21 * f1[0, i]
    newton_stage(p, s, u, load, t + (GAMMA + A21) * dt, dt, start, x, f2, g, lu, swaps)
    for i in range(n):
        start[0, i] = x0[0, i] + dt * (B1 * f1[0, i] + B2 * f2[0, i])
    newton_stage(p, s, u, load, t + dt, dt, start, x, f3, g, lu, swaps)
    return hooks.gathered(s, x), memory
