"""Small dense linear systems inside an integrator step: LU with partial pivoting, in place."""


def lu_factor(a, pivot, n):
    """Factorises ``a`` (n by n) in place; ``pivot[0, i]`` is the row taken for column ``i``."""
    for k in range(n):
        m = k
        for i in range(k + 1, n):
            if abs(a[i, k]) > abs(a[m, k]):
                m = i
        pivot[0, k] = m
        for j in range(n):
            swap = a[k, j]
            a[k, j] = a[m, j]
            a[m, j] = swap
        for i in range(k + 1, n):
            a[i, k] = a[i, k] / a[k, k] if a[k, k] != 0.0 else a[k, k] * 0.0 + 1e300
            for j in range(k + 1, n):
                a[i, j] -= a[i, k] * a[k, j]
    return 0


def lu_solve(a, pivot, b, n):
    """Solves with the factors in ``a``; ``b[0, :]`` becomes the solution."""
    for k in range(n):
        m = int(pivot[0, k])
        swap = b[0, k]
        b[0, k] = b[0, m]
        b[0, m] = swap
    for k in range(n):
        for i in range(k + 1, n):
            b[0, i] -= a[i, k] * b[0, k]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            b[0, k] -= a[k, j] * b[0, j]
        b[0, k] = b[0, k] / a[k, k] if a[k, k] != 0.0 else b[0, k] * 1e300
    return 0
