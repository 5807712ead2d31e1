"""Small dense linear systems inside an integrator step: LU with partial pivoting, in place.

No index depends on a number of the system, so that a compiler can unroll the loops and keep a small system in
registers: rows are exchanged by selects. ``lu_factor`` leaves the reciprocals of the pivots on the diagonal.
"""


def lu_factor(a, swaps, n):
    """Factorises ``a`` (n by n) in place; ``swaps[k, i]`` is 1 where column ``k`` exchanged rows k and i, else 0."""
    for k in range(n):
        for i in range(k + 1, n):
            larger = abs(a[i, k]) > abs(a[k, k])
            swaps[k, i] = 1.0 if larger else 0.0
            for j in range(n):
                upper = a[k, j]
                lower = a[i, j]
                a[k, j] = lower if larger else upper
                a[i, j] = upper if larger else lower
        a[k, k] = 1.0 / a[k, k] if a[k, k] != 0.0 else 1e300
        for i in range(k + 1, n):
            a[i, k] = a[i, k] * a[k, k]
            for j in range(k + 1, n):
                a[i, j] -= a[i, k] * a[k, j]
    return 0


def lu_solve(a, swaps, b, n):
    """Solves with the factors in ``a``; ``b[0, :]`` becomes the solution."""
    for k in range(n):
        for i in range(k + 1, n):
            larger = swaps[k, i] > 0.5
            upper = b[0, k]
            lower = b[0, i]
            b[0, k] = lower if larger else upper
            b[0, i] = upper if larger else lower
    for k in range(n):
        for i in range(k + 1, n):
            b[0, i] -= a[i, k] * b[0, k]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            b[0, k] -= a[k, j] * b[0, j]
        b[0, k] = b[0, k] * a[k, k]
    return 0
