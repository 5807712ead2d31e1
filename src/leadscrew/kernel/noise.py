"""Noise by counting: each draw is a function of seed, run, block, period and draw number, and of nothing else.

So the same numbers come out in every engine, lane, thread and worker, in any order.

The generator is Threefry-4x32 with 20 rounds of J. K. Salmon, M. A. Moraes, R. O. Dror and D. E. Shaw, "Parallel
random numbers: as easy as 1, 2, 3", SC'11 (2011), doi:10.1145/2063384.2063405; tested against its published
known answers.
"""

from __future__ import annotations

from typing import NamedTuple

from leadscrew.kernel.bits import bits_to_float
from leadscrew.kernel.portable import cos, log, sqrt

LOW32 = 0xFFFFFFFF
PARITY = 0x1BD11BDA
"""Skein's key schedule constant, 32 bit form (paper, section 4.2)."""
ONE = 0x3FF0000000000000
HALF_STEP = 1.1102230246251565e-16
"""2**-53."""
TWO_PI = 6.283185307179586


class Noise(NamedTuple):
    """What a block receives as ``noise``: which numbers are its own in this period."""

    seed: int
    run: int
    block: int
    period: int


def _four_rounds(x0, x1, x2, x3, r0, r1, r2, r3, r4, r5, r6, r7):
    """Four rounds: add, turn left within 32 bits, exclusive or. The words change partners between rounds."""
    x0 = (x0 + x1) & LOW32
    x1 = (((x1 << r0) & LOW32) | (x1 >> (32 - r0))) ^ x0
    x2 = (x2 + x3) & LOW32
    x3 = (((x3 << r1) & LOW32) | (x3 >> (32 - r1))) ^ x2
    x0 = (x0 + x3) & LOW32
    x3 = (((x3 << r2) & LOW32) | (x3 >> (32 - r2))) ^ x0
    x2 = (x2 + x1) & LOW32
    x1 = (((x1 << r3) & LOW32) | (x1 >> (32 - r3))) ^ x2
    x0 = (x0 + x1) & LOW32
    x1 = (((x1 << r4) & LOW32) | (x1 >> (32 - r4))) ^ x0
    x2 = (x2 + x3) & LOW32
    x3 = (((x3 << r5) & LOW32) | (x3 >> (32 - r5))) ^ x2
    x0 = (x0 + x3) & LOW32
    x3 = (((x3 << r6) & LOW32) | (x3 >> (32 - r6))) ^ x0
    x2 = (x2 + x1) & LOW32
    x1 = (((x1 << r7) & LOW32) | (x1 >> (32 - r7))) ^ x2
    return x0, x1, x2, x3


def threefry4x32(k0: int, k1: int, k2: int, k3: int, c0: int, c1: int, c2: int, c3: int) -> tuple[int, int, int, int]:
    """Four random words of 32 bits from a key and a counter of four such words each."""
    k4 = PARITY ^ k0 ^ k1 ^ k2 ^ k3
    x0 = (c0 + k0) & LOW32
    x1 = (c1 + k1) & LOW32
    x2 = (c2 + k2) & LOW32
    x3 = (c3 + k3) & LOW32
    x0, x1, x2, x3 = _four_rounds(x0, x1, x2, x3, 10, 26, 11, 21, 13, 27, 23, 5)
    x0 = (x0 + k1) & LOW32
    x1 = (x1 + k2) & LOW32
    x2 = (x2 + k3) & LOW32
    x3 = (x3 + k4 + 1) & LOW32
    x0, x1, x2, x3 = _four_rounds(x0, x1, x2, x3, 6, 20, 17, 11, 25, 10, 18, 20)
    x0 = (x0 + k2) & LOW32
    x1 = (x1 + k3) & LOW32
    x2 = (x2 + k4) & LOW32
    x3 = (x3 + k0 + 2) & LOW32
    x0, x1, x2, x3 = _four_rounds(x0, x1, x2, x3, 10, 26, 11, 21, 13, 27, 23, 5)
    x0 = (x0 + k3) & LOW32
    x1 = (x1 + k4) & LOW32
    x2 = (x2 + k0) & LOW32
    x3 = (x3 + k1 + 3) & LOW32
    x0, x1, x2, x3 = _four_rounds(x0, x1, x2, x3, 6, 20, 17, 11, 25, 10, 18, 20)
    x0 = (x0 + k4) & LOW32
    x1 = (x1 + k0) & LOW32
    x2 = (x2 + k1) & LOW32
    x3 = (x3 + k2 + 4) & LOW32
    x0, x1, x2, x3 = _four_rounds(x0, x1, x2, x3, 10, 26, 11, 21, 13, 27, 23, 5)
    x0 = (x0 + k0) & LOW32
    x1 = (x1 + k1) & LOW32
    x2 = (x2 + k2) & LOW32
    x3 = (x3 + k3 + 5) & LOW32
    return x0, x1, x2, x3


def _words(noise: Noise, draw: int) -> tuple[int, int, int, int]:
    """The four words of one draw: key (seed low, seed high, run, block), counter (period low, period high, draw, 0)."""
    return threefry4x32(
        noise.seed & LOW32, (noise.seed >> 32) & LOW32, noise.run & LOW32, noise.block & LOW32,
        noise.period & LOW32, (noise.period >> 32) & LOW32, draw & LOW32, 0,
    )  # fmt: skip


def _open_unit(high: int, low: int) -> float:
    """Two words to a float strictly between 0 and 1: 52 bits of them, plus half a step (2**-53), exactly."""
    return (bits_to_float((high << 20) | (low >> 12) | ONE) - 1.0) + HALF_STEP


def uniform(noise: Noise, draw: int) -> float:
    """An even draw from the open interval (0, 1): an odd multiple of 2**-53, so 0 and 1 never occur.

    Draws of one block and period differ by ``draw``, an integer from 0 to 2**32 - 1.
    """
    x0, x1, _x2, _x3 = _words(noise, draw)
    return _open_unit(x0, x1)


def normal(noise: Noise, draw: int) -> float:
    """A draw from the normal distribution of mean 0 and deviation 1; at most 8.58 in size.

    G. E. P. Box and M. E. Muller, "A note on the generation of random normal deviates", Ann. Math. Statist. 29
    (1958) 610: ``sqrt(-2 log u) cos(2 pi v)``, u from the first two words of the draw, v from the other two. It
    shares its first two words with ``uniform`` of the same draw: take different draw numbers for the two.
    """
    x0, x1, x2, x3 = _words(noise, draw)
    return sqrt(-2.0 * log(_open_unit(x0, x1))) * cos(TWO_PI * _open_unit(x2, x3))
