"""Which transfer functions are tried: degrees, poles at zero, delay; and their poles as numbers that have no bounds.

    G(s) = (b_m s^m + ... + b_0) / (s^q D(s)) * exp(-delay s)

``D`` is a product of ``s^2 + 2 zeta w s + w^2`` and, for an odd degree, ``s + w``, with ``w`` and ``zeta`` above zero:
two real poles or a pair, stable. Searched are ``ln w``, ``ln zeta`` and the delay in sample periods.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

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
