"""All unknowns of a candidate in one vector: simulation and its change by each, for covariance and instruments.

What a transfer function with delay answers to an input that is held from sample to sample: exact, and fast.

    Y(s) / U(s) = s^k / D(s) * exp(-delay s),    k = 0 ... n - 1,    D of degree n

In companion form the states of ``1 / D(s)`` are all these at once. With ``delay = (l + f) T``, ``0 <= f < 1``, the
input of a period is ``u[k - l - 1]`` for ``f T`` and then ``u[k - l]``, so one step is (Astrom and Wittenmark,
*Computer-Controlled Systems*, 3rd ed., 1997, section 2.3)

    x[k + 1] = Phi x[k] + G0 u[k - l] + G1 u[k - l - 1]
    G0 = Gamma((1 - f) T),    G1 = Phi((1 - f) T) Gamma(f T)

with ``Phi(t) = e^(A t)`` and ``Gamma(t)`` the response to an input of one held over ``t``. Blocks of samples are
answered at once, by powers of the step: no loop over samples, and nothing is rounded off as in a filter's polynomials.

Which transfer functions are tried: degrees, poles at zero, delay; and their poles as numbers that have no bounds.

    G(s) = (b_m s^m + ... + b_0) / (s^q D(s)) * exp(-delay s)

``D`` is a product of ``s^2 + 2 zeta w s + w^2`` and, for an odd degree, ``s + w``, with ``w`` and ``zeta`` above zero:
two real poles or a pair, stable. Searched are ``ln w``, ``ln zeta`` and the delay in sample periods.

Output error of one candidate: only poles and delay are searched, all else follows by linear least squares.

For given poles and delay the simulated output is linear in the rest,

    y[k] = sum_i b_i x_i[k] + (e_0 Phi^k) x(0) + c t[k]^q

``x_i`` are the states of ``1 / D`` under the logged input, ``x(0)`` the unknown start and ``c`` an offset: of the
output where no pole is zero, of the input with ``q`` poles at zero. So the search is over few numbers, and the rest is
exact at every step of it (variable projection: Golub and Pereyra, *SIAM J. Numer. Anal.* 10, 1973, 413).

Where the search for poles starts: a grid, poles of simpler candidates with one more, instrumental variables.

Refined instrumental variables for continuous time (Young, *Recursive Estimation and Time-Series Analysis*, 2nd ed.,
2011, chapter 8): filtered by ``1 / E(s)``, ``D(s) y = B(s) u`` is a linear equation in the coefficients. Its output is
noisy, so the instruments are what the model so far makes of the input; then ``E`` becomes the new ``D``.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from leadscrew.plants._linear import hold_matrices

BLOCK = 64
"""Samples that are answered at once."""


class Step(NamedTuple):
    """One period of ``1 / D(s)`` with delay, state k being ``(s / rate)^k rate^n / D(s)``."""

    transition: np.ndarray
    now: np.ndarray
    """What an input of the newest sample that arrives adds, ``G0``."""
    before: np.ndarray
    """What the one before it adds, ``G1``."""
    whole: int
    """Whole periods of delay, ``l``."""
    rate: float
    """1/s: geometric mean of the poles that are not zero."""


def step_of(denominator: np.ndarray, delay_s: float, period: float) -> Step:
    """The step of a monic denominator, highest power first."""
    n = len(denominator) - 1
    known = np.flatnonzero(denominator)[-1]
    rate = float(abs(denominator[known]) ** (1.0 / known)) if known else 1.0 / period
    scaled = denominator / rate ** np.arange(n + 1.0)
    a = np.zeros((n, n))
    a[np.arange(n - 1), np.arange(1, n)] = rate
    a[-1] = -rate * scaled[:0:-1]
    b = np.zeros(n)
    b[-1] = rate
    whole = int(np.floor(delay_s / period + 1e-12))
    late = max(delay_s - whole * period, 0.0)
    transition, gamma = hold_matrices(a, b, period)
    if late == 0.0:
        return Step(transition, gamma, np.zeros(n), whole, rate)
    rest, now = hold_matrices(a, b, period - late)
    return Step(transition, now, rest @ hold_matrices(a, b, late)[1], whole, rate)


def forced(step: Step, u: np.ndarray, count: int | None = None) -> np.ndarray:
    """The first ``count`` states ``[sample, state]`` under ``u``, from rest; ``u`` had its first value before, too."""
    n = len(step.now)
    count = n if count is None else count
    now = np.concatenate([np.full(step.whole, u[0]), u])[: len(u)]
    blocks = -(-len(u) // BLOCK)
    inputs = np.zeros((blocks, BLOCK))
    inputs.ravel()[: len(u)] = now
    a = np.zeros((n + 1, n + 1))
    a[:n, :n], a[:n, n] = step.transition, step.before
    powers = np.empty((BLOCK + 1, n + 1, n + 1))
    powers[0] = np.eye(n + 1)
    for k in range(BLOCK):
        powers[k + 1] = powers[k] @ a
    answers = powers[:BLOCK] @ np.append(step.now, 1.0)
    x = np.zeros((blocks, n + 1))
    x[0, n] = u[0]
    ends, whole = inputs @ answers[::-1], powers[BLOCK].T.copy()
    for c in range(blocks - 1):
        x[c + 1] = x[c] @ whole + ends[c]
    states = np.einsum("kij,cj->cki", powers[:BLOCK, :count], x, optimize=True)
    lag = np.subtract.outer(np.arange(BLOCK), np.arange(BLOCK)) - 1
    for i in range(count):
        states[:, :, i] += inputs @ np.where(lag >= 0, answers[lag, i], 0.0).T
    return states.reshape(-1, count)[: len(u)]


def free(step: Step, samples: int) -> np.ndarray:
    """What each start of the states adds to state 0, ``[sample, state]``: the row ``e_0 Phi^k``."""
    rows = np.zeros((samples, len(step.now)))
    rows[0, 0] = 1.0
    done, power = 1, step.transition
    while done < samples:
        more = min(done, samples - done)
        rows[done : done + more] = rows[:more] @ power
        power, done = power @ power, done + more
    return rows


def sampled_response(step: Step, weights: np.ndarray, period: float, frequencies_hz: np.ndarray) -> np.ndarray:
    """Complex response from samples of the input to samples of the output, hold included; ``weights`` of the states."""
    z = np.exp(2j * np.pi * np.asarray(frequencies_hz) * period)
    left = z[:, None, None] * np.eye(len(step.now)) - step.transition
    arriving = step.now[None] + step.before[None] / z[:, None]
    states = np.linalg.solve(left, arriving[:, :, None])[:, :, 0]
    return (states @ weights) * z ** (-step.whole)


DAMPING = (1e-3, 100.0)
"""Range of ``zeta``; 100 are two real poles 1 to 40,000."""


class Structure(NamedTuple):
    """Degrees of one candidate."""

    order: int
    """Poles, those at zero included."""
    zeros: int
    integrators: int
    """Poles at zero."""

    @property
    def free(self) -> int:
        """Poles that are searched."""
        return self.order - self.integrators

    @property
    def text(self) -> str:
        """In words."""
        parts = [f"{self.order} pole{'s' * (self.order != 1)}"]
        if self.integrators:
            parts[0] += f", {self.integrators} at 0"
        if self.zeros:
            parts.append(f"{self.zeros} zero{'s' * (self.zeros != 1)}")
        return ", ".join(parts)

    def denominator(self, theta: np.ndarray) -> np.ndarray:
        """Monic, highest power first, from ``ln w, ln zeta`` of each pair and ``ln w`` of the odd pole."""
        found = np.array([1.0])
        for k in range(self.free // 2):
            w, zeta = np.exp(theta[2 * k]), np.exp(theta[2 * k + 1])
            found = np.convolve(found, [1.0, 2.0 * zeta * w, w * w])
        if self.free % 2:
            found = np.convolve(found, [1.0, np.exp(theta[self.free - 1])])
        return np.concatenate([found, np.zeros(self.integrators)])

    def theta(self, poles: np.ndarray) -> np.ndarray:
        """The searched numbers of poles that are not zero; what is unstable is mirrored into the left half plane."""
        poles = np.asarray(poles, dtype=complex)
        poles = np.where(poles.real > 0.0, -poles.conj(), poles)
        pairs = [p for p in poles if p.imag > 1e-12 * abs(p)]
        real = sorted((p for p in poles if abs(p.imag) <= 1e-12 * abs(p)), key=abs)
        found: list[float] = []
        for p in pairs:
            found += [np.log(abs(p)), np.log(max(-p.real / abs(p), DAMPING[0]))]
        for slow, fast in zip(real[0::2], real[1::2], strict=False):
            w = np.sqrt(abs(slow) * abs(fast))
            found += [np.log(w), np.log((abs(slow) + abs(fast)) / (2.0 * w))]
        if len(real) % 2:
            found.append(np.log(abs(real[-1])))
        return np.array(found)


def candidates(max_order: int, max_zeros: int, integrators: tuple[int, ...]) -> list[Structure]:
    """All to be tried, simplest first: by number of coefficients, then by order."""
    found = [
        Structure(n, m, q)
        for q in integrators
        for n in range(max(1, q), max_order + 1)
        for m in range(min(n - 1, max_zeros) + 1)
    ]
    return sorted(found, key=lambda s: (s.free + s.zeros, s.order, s.zeros))


RANK = 1e-11
"""Singular values below this share of the largest are left out: a start of a mode that has long decayed."""


class Solved(NamedTuple):
    """The best linear part for some poles and a delay."""

    denominator: np.ndarray
    delay_s: float
    numerator: np.ndarray
    """Of ``s^m`` down to ``s^0``."""
    start: np.ndarray
    """Of the scaled states, at the first sample."""
    offset: float
    """Of the output (no pole at zero), or the coefficient of ``t^q``."""
    residual: np.ndarray
    """Measured less simulated, at the rows used."""


class Problem:
    """One record and one structure; ``theta`` is as in :class:`Structure`, with the delay in periods last if fitted."""

    def __init__(
        self, u: np.ndarray, y: np.ndarray, period: float, structure: Structure, delay: float | None,
        longest: float, rows: np.ndarray,
    ) -> None:  # fmt: skip
        self.u, self.y, self.period, self.structure, self.delay = u, y, period, structure, delay
        self.longest, self.rows = longest, rows
        self.time = period * np.arange(len(u))

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Of ``theta``: from a twentieth of what the record's length shows to three times the sampling rate."""
        low, high = np.log(0.05 / self.time[-1]), np.log(3.0 / self.period)
        lows, highs = [], []
        for k in range(self.structure.free):
            pair = k < self.structure.free // 2 * 2
            lows.append(np.log(DAMPING[0]) if pair and k % 2 else low)
            highs.append(np.log(DAMPING[1]) if pair and k % 2 else high)
        if self.delay is None:
            lows.append(0.0)
            highs.append(self.longest / self.period)
        return np.array(lows), np.array(highs)

    def system(self, theta: np.ndarray) -> tuple[np.ndarray, float, Step]:
        """Denominator, delay and step."""
        delay_s = float(theta[-1]) * self.period if self.delay is None else self.delay
        denominator = self.structure.denominator(theta)
        return denominator, delay_s, step_of(denominator, delay_s, self.period)

    def columns(self, step: Step) -> np.ndarray:
        """``[row, column]``: states under the input, free responses, the offset's."""
        count = self.structure.zeros + 1
        ramp = (self.time[self.rows] / self.time[-1]) ** self.structure.integrators
        under = forced(step, self.u, count)[self.rows]
        return np.concatenate([under, free(step, len(self.u))[self.rows], ramp[:, None]], axis=1)

    def residual(self, theta: np.ndarray) -> np.ndarray:
        """What the best linear part leaves."""
        return self.project(self.columns(self.system(theta)[2]))[1]

    def project(self, columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Coefficients and residual of linear least squares."""
        measured = self.y[self.rows]
        size = np.linalg.norm(columns, axis=0)
        size[size == 0.0] = 1.0
        q, r = np.linalg.qr(columns / size)
        left, values, right = np.linalg.svd(r)
        kept = values > RANK * values[0]
        shares = left[:, kept].T @ (q.T @ measured)
        coefficients = right[kept].T @ (shares / values[kept]) / size
        return coefficients, measured - q @ (left[:, kept] @ shares)

    def solve(self, theta: np.ndarray) -> Solved:
        """Everything at ``theta``."""
        denominator, delay_s, step = self.system(theta)
        found, residual = self.project(self.columns(step))
        m, n = self.structure.zeros, self.structure.order
        numerator = found[: m + 1] * step.rate ** (n - np.arange(m + 1.0))
        offset = float(found[-1]) / self.time[-1] ** self.structure.integrators
        return Solved(denominator, delay_s, numerator[::-1].copy(), found[m + 1 : -1], offset, residual)

    def search(self, start: np.ndarray, evaluations: int = 60, tolerance: float = 1e-10) -> tuple[np.ndarray, float]:
        """The nearest minimum, and its sum of squares."""
        from scipy.optimize import least_squares

        if not len(start):
            return start, float(np.sum(self.residual(start) ** 2))
        low, high = self.bounds()
        margin = 1e-6 * (high - low)
        inside = np.clip(start, low + margin, high - margin)
        scale = float(np.std(self.y[self.rows])) or 1.0
        found = least_squares(
            lambda x: self.residual(x) / scale, inside, bounds=(low, high), max_nfev=evaluations, ftol=tolerance,
            xtol=1e-9, gtol=1e-12, diff_step=1e-5,
        )  # fmt: skip
        return found.x, float(2.0 * found.cost * scale**2)


NUDGE = 1e-5
"""Step of the differences in ``theta``."""


class Model:
    """``phi``: ``b_0 ... b_m``, ``theta`` (as in :class:`Problem`), start of the scaled states, offset."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self.m, self.n = problem.structure.zeros, problem.structure.order
        self.searched = problem.structure.free + (problem.delay is None)

    @property
    def kept(self) -> int:
        """Unknowns that belong to the system: numerator and ``theta``; start and offset belong to the record."""
        return self.m + 1 + self.searched

    def phi(self, theta: np.ndarray, solved: Solved) -> np.ndarray:
        """The vector of a solution."""
        return np.concatenate([solved.numerator[::-1], theta, solved.start, [solved.offset]])

    def split(self, phi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Numerator by rising power, and ``theta``."""
        return phi[: self.m + 1], phi[self.m + 1 : self.kept]

    def weights(self, step: Step, b: np.ndarray) -> np.ndarray:
        """Of the scaled states, for a numerator by rising power."""
        return b / step.rate ** (self.n - np.arange(self.m + 1.0))

    def ramp(self, time: np.ndarray) -> np.ndarray:
        """What an offset of one adds."""
        return np.asarray(time**self.problem.structure.integrators)

    def simulate(self, phi: np.ndarray, u: np.ndarray) -> np.ndarray:
        """The output at the rows used."""
        b, theta = self.split(phi)
        p, step = self.problem, self.problem.system(theta)[2]
        own = forced(step, u, self.m + 1)[p.rows] @ self.weights(step, b)
        begun = free(step, len(u))[p.rows] @ phi[self.kept : -1]
        return own + begun + phi[-1] * self.ramp(p.time[p.rows])

    def jacobian(self, phi: np.ndarray, u: np.ndarray) -> np.ndarray:
        """Change of the output by each unknown, ``[row, unknown]``."""
        p = self.problem
        theta = self.split(phi)[1]
        step = p.system(theta)[2]
        size = step.rate ** (self.n - np.arange(self.m + 1.0))
        by_b = forced(step, u, self.m + 1)[p.rows] / size
        by_start, by_offset = free(step, len(u))[p.rows], self.ramp(p.time[p.rows])[:, None]
        by_theta = np.empty((len(p.rows), self.searched))
        for k in range(self.searched):
            ahead, back = phi.copy(), phi.copy()
            ahead[self.m + 1 + k] += NUDGE
            late = p.delay is None and k == self.searched - 1
            back[self.m + 1 + k] -= min(NUDGE, theta[k]) if late else NUDGE
            width = ahead[self.m + 1 + k] - back[self.m + 1 + k]
            by_theta[:, k] = (self.simulate(ahead, u) - self.simulate(back, u)) / width
        return np.concatenate([by_b, by_theta, by_start, by_offset], axis=1)

    def refined(self, phi: np.ndarray, clean: np.ndarray, rounds: int = 12) -> tuple[np.ndarray, bool]:
        """``Z' e = 0`` with instruments from the input ``clean``, by Gauss and Newton; and whether it came to rest."""
        p = self.problem
        low, high = p.bounds()
        at = slice(self.m + 1, self.kept)
        for _ in range(rounds):
            left = p.y[p.rows] - self.simulate(phi, p.u)
            z, j = self.jacobian(phi, clean), self.jacobian(phi, p.u)
            size = np.linalg.norm(j, axis=0) + 1e-300
            change = np.linalg.lstsq((z / size).T @ (j / size), (z / size).T @ left, rcond=1e-12)[0] / size
            if not np.all(np.isfinite(change)):
                return phi, False
            share = min(1.0, 0.5 / float(np.max(np.abs(change[at]), initial=1e-9)))
            moved = phi + share * change
            moved[at] = np.clip(moved[at], low, high)
            if share == 1.0 and np.max(np.abs(change[at]), initial=0.0) < 1e-7:
                return moved, True
            phi = moved
        return phi, False


GRID = 10
"""Poles of the grid, evenly over the logarithm."""
ROUNDS = 4


class Known(NamedTuple):
    """What another candidate ended with."""

    poles: np.ndarray
    """Those that are not at zero."""
    delay_s: float


def starts(problem: Problem, known: list[Known], delays_s: list[float], most: int = 2) -> list[np.ndarray]:
    """The best few of all starts, by their sum of squares; ``delays_s`` are tried where nothing is known."""
    structure = problem.structure
    low, high = problem.bounds()
    tried: list[tuple[float, np.ndarray]] = []
    for poles, late in _sets(problem, known, delays_s):
        theta = structure.theta(poles)
        full = np.append(theta, late / problem.period) if problem.delay is None else theta
        full = np.clip(full, low, high)
        tried.append((float(np.sum(problem.residual(full) ** 2)), full))
    tried.sort(key=lambda pair: pair[0])
    chosen: list[np.ndarray] = []
    for _, theta in tried:
        if all(np.max(np.abs(theta - other), initial=0.0) > 0.5 for other in chosen):
            chosen.append(theta)
        if len(chosen) == most:
            break
    return chosen


def _sets(problem: Problem, known: list[Known], delays_s: list[float]) -> list[Known]:
    r = problem.structure.free
    grid = np.geomspace(1.0 / problem.time[-1], 1.0 / problem.period, GRID)
    sets = [k for k in known if len(k.poles) == r]
    for poles, late in known:
        if len(poles) == r - 1:
            sets += [Known(np.append(poles, -w), late) for w in grid]
        if len(poles) == r - 2:
            pairs = [w * np.array([-z + 1j, -z - 1j]) for w in grid for z in (0.03, 0.5)]
            sets += [Known(np.append(poles, pair), late) for pair in pairs]
    if not sets:
        sets = [Known(-w * np.geomspace(1.0, 3.0, r), late) for w in grid for late in delays_s]
    best = min(sets, key=lambda k: _cost(problem, k.poles))
    return [
        *sets,
        *(Known(poles, late) for poles in _refined(problem, best.poles) for late in (*delays_s, best.delay_s)),
    ]


def _cost(problem: Problem, poles: np.ndarray) -> float:
    theta = problem.structure.theta(poles)
    if problem.delay is None:
        theta = np.append(theta, 0.0)
    low, high = problem.bounds()
    return float(np.sum(problem.residual(np.clip(theta, low, high)) ** 2))


def _refined(problem: Problem, poles: np.ndarray) -> list[np.ndarray]:
    """Poles after some rounds of instrumental variables; none where they fail."""
    s = problem.structure
    found: list[np.ndarray] = []
    for _ in range(ROUNDS):
        try:
            poles = _round(problem, poles)
        except (np.linalg.LinAlgError, ValueError):
            return found[-1:]
        if len(poles) != s.free or not np.all(np.isfinite(poles)) or np.any(poles == 0.0):
            return found[-1:]
        poles = _inside(problem, poles)
        found.append(poles)
    return found[-1:]


def _inside(problem: Problem, poles: np.ndarray) -> np.ndarray:
    """Stable, and neither slower than the record nor faster than the sampling."""
    size = np.clip(np.abs(poles), 0.1 / problem.time[-1], 3.0 / problem.period)
    turned = np.where(poles.real > 0.0, -poles.conj(), poles)
    return size * turned / np.abs(poles)


def _round(problem: Problem, poles: np.ndarray) -> np.ndarray:
    s = problem.structure
    theta = s.theta(poles)
    late = 0.0 if problem.delay is None else problem.delay
    full = np.append(theta, 0.0) if problem.delay is None else theta
    low, high = problem.bounds()
    columns = problem.columns(problem.system(np.clip(full, low, high))[2])
    model = np.interp(np.arange(len(problem.u)), problem.rows, problem.y[problem.rows] - problem.project(columns)[1])
    filter_ = np.real(np.poly([*poles, *([-np.exp(np.mean(np.log(np.abs(poles))))] * s.integrators)]))
    own = step_of(filter_, 0.0, problem.period)
    driven = forced(step_of(filter_, late, problem.period), problem.u, s.zeros + 1)
    common = np.concatenate([driven, free(own, len(problem.u)), np.ones((len(problem.u), 1))], axis=1)
    measured, clean = (_derivatives(own, filter_, _middle(v - v[0])) for v in (problem.y, model))
    regress, tools = (np.concatenate([-v[:, s.integrators : -1], common], axis=1) for v in (measured, clean))
    size = np.linalg.norm(tools, axis=0) + 1e-300
    solution = np.linalg.lstsq((tools / size).T @ (regress / size), (tools / size).T @ measured[:, -1], rcond=1e-13)[0]
    inner = (solution / size)[: s.free] * own.rate ** (s.order - np.arange(s.integrators, s.order))
    return np.roots(np.concatenate([[1.0], inner[::-1]]))


def _middle(values: np.ndarray) -> np.ndarray:
    """What is held in place of a signal that runs on between its samples."""
    return np.append(0.5 * (values[1:] + values[:-1]), values[-1])


def _derivatives(step: Step, filter_: np.ndarray, values: np.ndarray) -> np.ndarray:
    """``(s / rate)^k rate^n / E`` of a signal, k = 0 ... n."""
    states = forced(step, values)
    n = len(filter_) - 1
    scaled = filter_ / step.rate ** np.arange(n + 1.0)
    return np.concatenate([states, (values - states @ scaled[:0:-1])[:, None]], axis=1)
