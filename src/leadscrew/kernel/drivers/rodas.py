"""RODAS4(3): an adaptive linearly implicit (Rosenbrock) method for stiff plants and for continuous loops.

Source: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, section IV.7 (order 4, embedded order 3, six
stages, stiffly accurate). The Jacobian is the block's own or by forward differences.
"""

import math

from leadscrew.kernel.bits import stack_array2
from leadscrew.kernel.drivers import hooks
from leadscrew.kernel.drivers.linear import lu_factor, lu_solve

GAMMA = 0.25
A21, A31, A32 = 1.544, 0.9466785280815826, 0.2557011698983284
A41, A42, A43 = 3.314825187068521, 2.896124015972201, 0.9986419139977817
A51, A52, A53, A54 = 1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950
C21, C31, C32 = -5.6688, -2.430093356833875, -0.2063599157091915
C41, C42, C43 = -0.1073529058151375, -9.594562251023355, -20.47028614809616
C51, C52, C53, C54 = 7.496443313967647, -10.24680431464352, -33.99990352819905, 11.70890893206160
C61, C62, C63 = 8.083246795921522, -7.981132988064893, -31.52159432874371
C64, C65 = 16.31930543123136, -6.058818238834054
T2, T3, T4 = 0.386, 0.21, 0.63
D1, D2, D3, D4 = 0.25, -0.1043, 0.1035, -0.03620000000000023
GROW, SHRINK, SAFETY = 6.0, 0.2, 0.9
STEPS = 1000000
"""Steps allowed between two calls; beyond, the state becomes NaN and the loop reports divergence."""


def difference_jacobian(p, s, u, load, t, x, f, jac):
    """Jacobian of the derivative by forward differences at ``x``, where the derivative is ``f``."""
    n = hooks.ORDER
    g = stack_array2(1, hooks.ORDER)
    for j in range(n):
        kept = x[0, j]
        nudge = 1.4901161193847656e-08 * max(abs(kept), 1e-5)
        x[0, j] = kept + nudge
        nudge = x[0, j] - kept
        hooks.rates(p, s, u, load, t, x, g)
        x[0, j] = kept
        for i in range(n):
            jac[i, j] = (g[0, i] - f[0, i]) / nudge
    return 0


def stage(lu, swaps, k, row, f, ft, weight, n):
    """Solves for one stage: row ``row`` of ``k`` holds the sum of the earlier stages and becomes the stage."""
    b = stack_array2(1, hooks.ORDER)
    for i in range(n):
        b[0, i] = f[0, i] + k[row, i] + weight * ft[0, i]
    lu_solve(lu, swaps, b, n)
    for i in range(n):
        k[row, i] = b[0, i]
    return 0


def try_step(p, s, u, load, t, h, x, f, ft, jac, y, rtol, atol):
    """One step of size ``h`` from ``x`` to the new state ``y``; returns the error relative to the tolerance."""
    n = hooks.ORDER
    lu = stack_array2(hooks.ORDER, hooks.ORDER)
    k = stack_array2(6, hooks.ORDER)
    g = stack_array2(1, hooks.ORDER)
    swaps = stack_array2(hooks.ORDER, hooks.ORDER)
    for i in range(n):
        for j in range(n):
            lu[i, j] = (1.0 / (h * GAMMA) if i == j else 0.0) - jac[i, j]
        for m in range(6):
            k[m, i] = 0.0
    per = 1.0 / h
    lu_factor(lu, swaps, n)
    stage(lu, swaps, k, 0, f, ft, h * D1, n)
    for i in range(n):
        y[0, i] = x[0, i] + A21 * k[0, i]
        k[1, i] = C21 * k[0, i] * per
    hooks.rates(p, s, u, load, t + T2 * h, y, g)
    stage(lu, swaps, k, 1, g, ft, h * D2, n)
    for i in range(n):
        y[0, i] = x[0, i] + A31 * k[0, i] + A32 * k[1, i]
        k[2, i] = (C31 * k[0, i] + C32 * k[1, i]) * per
    hooks.rates(p, s, u, load, t + T3 * h, y, g)
    stage(lu, swaps, k, 2, g, ft, h * D3, n)
    for i in range(n):
        y[0, i] = x[0, i] + A41 * k[0, i] + A42 * k[1, i] + A43 * k[2, i]
        k[3, i] = (C41 * k[0, i] + C42 * k[1, i] + C43 * k[2, i]) * per
    hooks.rates(p, s, u, load, t + T4 * h, y, g)
    stage(lu, swaps, k, 3, g, ft, h * D4, n)
    for i in range(n):
        y[0, i] = x[0, i] + A51 * k[0, i] + A52 * k[1, i] + A53 * k[2, i] + A54 * k[3, i]
        k[4, i] = (C51 * k[0, i] + C52 * k[1, i] + C53 * k[2, i] + C54 * k[3, i]) * per
    hooks.rates(p, s, u, load, t + h, y, g)
    stage(lu, swaps, k, 4, g, ft, 0.0, n)
    for i in range(n):
        y[0, i] += k[4, i]
        k[5, i] = (C61 * k[0, i] + C62 * k[1, i] + C63 * k[2, i] + C64 * k[3, i] + C65 * k[4, i]) * per
    hooks.rates(p, s, u, load, t + h, y, g)
    stage(lu, swaps, k, 5, g, ft, 0.0, n)
    total = 0.0
    for i in range(n):
        y[0, i] += k[5, i]
        scale = atol + rtol * max(abs(x[0, i]), abs(y[0, i]))
        total += (k[5, i] / scale) * (k[5, i] / scale)
    return math.sqrt(total / n)


def rodas_advance(p, s, u, load, t, dt, x, h, rtol, atol):
    """Moves ``x`` from ``t`` to ``t + dt`` in place; returns the step to try next."""
    n = hooks.ORDER
    f = stack_array2(1, hooks.ORDER)
    ft = stack_array2(1, hooks.ORDER)
    y = stack_array2(1, hooks.ORDER)
    jac = stack_array2(hooks.ORDER, hooks.ORDER)
    done = 0.0
    fresh = True
    wanted = h
    for _ in range(STEPS):
        left = dt - done
        if left <= 1e-13 * dt:
            return wanted
        if fresh:
            hooks.rates(p, s, u, load, t + done, x, f)
            hooks.jacobian(p, s, u, load, t + done, x, f, jac)
            for i in range(n):
                ft[0, i] = 0.0
            if hooks.TIMED:
                nudge = 1.4901161193847656e-08 * max(abs(t + done), 1e-3 * dt)
                hooks.rates(p, s, u, load, t + done + nudge, x, ft)
                for i in range(n):
                    ft[0, i] = (ft[0, i] - f[0, i]) / nudge
        last = wanted >= left
        h = left if last else wanted
        error = try_step(p, s, u, load, t + done, h, x, f, ft, jac, y, rtol, atol)
        if not error < 1e30:
            wanted = 0.1 * h
            fresh = False
        else:
            factor = SAFETY / math.sqrt(math.sqrt(max(error, 1e-8)))
            factor = min(GROW, max(SHRINK, factor))
            fresh = error <= 1.0
            if fresh:
                for i in range(n):
                    x[0, i] = y[0, i]
                done = dt if last else done + h
                wanted = max(wanted, factor * h) if last else factor * h
            else:
                wanted = min(factor, 0.9) * h
        if wanted < 1e-14 * dt:
            break
    for i in range(n):
        x[0, i] = x[0, i] * 0.0 + (1e308 * 10.0 - 1e308 * 10.0)
    return dt


def rodas(p, s, memory, u, load, t, dt):
    """Adaptive step over a hold; the memory carries the step size from hold to hold."""
    x = stack_array2(1, hooks.ORDER)
    hooks.spread(s, x)
    h = memory if memory > 0.0 else dt
    h = rodas_advance(p, s, u, load, t, dt, x, h, hooks.RTOL, hooks.ATOL)
    return hooks.gathered(s, x), h
