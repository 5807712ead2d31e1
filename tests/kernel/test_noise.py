"""The noise: the published numbers, the same in both engines, and normal where it says so."""

import math

import numpy as np
import pytest
from scipy import stats

from leadscrew.kernel.noise import Noise, normal, threefry4x32, uniform
from tests.kernel.test_portable import compiled

ONES = 0xFFFFFFFF
PUBLISHED = {
    "zeros": ((0,) * 8, (0x9C6CA96A, 0xE17EAE66, 0xFC10ECD4, 0x5256A7D8)),
    "ones": ((ONES,) * 8, (0x2A881696, 0x57012287, 0xF6C7446E, 0xA16A6732)),
    "pi": (
        # The counter comes first in Random123's list: 243f6a88 ...; the key follows.
        (0xA4093822, 0x299F31D0, 0x082EFA98, 0xEC4E6C89, 0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344),
        (0x59CD1DBB, 0xB8879579, 0x86B5D00C, 0xAC8B6D84),
    ),
}
"""Threefry-4x32-20 from Random123's known answers: key and counter, result."""


def drawn(J, Y):
    for i in range(Y.shape[1]):
        noise = Noise(J[0, 0], i & 3, i & 7, i * 1000003)
        Y[0, i] = uniform(noise, 0)
        Y[1, i] = normal(noise, 1)
    return 0


@pytest.fixture(scope="module")
def draws():
    """A compiled loop over periods: uniform and normal draws of a seed into the two rows of an array."""
    code = compiled(drawn)
    return lambda seed, out: code(np.array([[seed]]), out)


@pytest.mark.parametrize("name", PUBLISHED)
def test_threefry_gives_the_published_words(name):
    words, expected = PUBLISHED[name]
    assert threefry4x32(*words) == expected


def test_machine_code_draws_the_bits_of_plain_python(draws):
    for seed in (-(2**63), -1, 0, 2**62):
        got = np.empty((2, 500))
        draws(seed, got)
        for i in range(500):
            noise = Noise(seed, i & 3, i & 7, i * 1000003)
            assert (uniform(noise, 0), normal(noise, 1)) == tuple(got[:, i])


def test_every_part_of_the_token_changes_the_draw():
    base = Noise(1, 2, 3, 4)
    others = [base._replace(**{name: 2**31}) for name in base._fields]
    others += [base._replace(seed=1 + 2**32), base._replace(period=4 + 2**32)]
    assert len({uniform(n, 0) for n in [base, *others]} | {uniform(base, 1)}) == 8


def test_a_draw_can_be_reproduced_from_the_generator_of_the_paper():
    """Key: low and high word of the seed, run, block; counter: low and high word of the period, draw, 0."""
    x0, x1, x2, x3 = threefry4x32(7, 3, 11, 13, 5 + 2**31, 2, 17, 0)
    token = Noise(7 + 3 * 2**32, 11, 13, 5 + 2**31 + 2 * 2**32)
    u, v = (((high * 2**20 + low // 2**12) + 0.5) / 2**52 for high, low in ((x0, x1), (x2, x3)))
    assert uniform(token, 17) == u
    assert normal(token, 17) == pytest.approx(math.sqrt(-2.0 * math.log(u)) * math.cos(2.0 * math.pi * v), rel=1e-14)


def test_uniform_never_reaches_its_ends():
    from leadscrew.kernel.noise import _open_unit

    assert _open_unit(0, 0) == 2.0**-53
    assert _open_unit(ONES, ONES) == 1 - 2.0**-53


def test_draws_follow_their_distributions(draws):
    n = 100_000
    out = np.empty((2, n))
    draws(2024, out)
    even, bell = out
    assert abs(bell.mean()) < 4 / math.sqrt(n)
    assert abs(bell.var() - 1) < 4 * math.sqrt(2 / n)
    assert stats.kstest(bell, "norm").pvalue > 1e-3
    assert stats.kstest(even, "uniform").pvalue > 1e-3
    assert abs(np.corrcoef(bell[1:], bell[:-1])[0, 1]) < 4 / math.sqrt(n)
    assert abs(np.corrcoef(even, bell)[0, 1]) < 4 / math.sqrt(n)
