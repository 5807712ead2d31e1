"""The checksum of a session: of every bit of every signal, computed here by hashlib alone."""

import hashlib

import pytest

from leadscrew.operate.operated import Operated, Start
from tests.operate.bench_study import NAME


def digest_of(*pieces):
    """SHA-256 over rows of float64, little-endian, row after row."""
    return hashlib.sha256(b"".join(rows.astype("<f8").tobytes(order="C") for rows in pieces)).hexdigest()


def test_the_digest_is_that_of_all_columns_in_full_precision_across_a_switch():
    operated = Operated(Start(NAME, "pid", "way", seed=3))
    pieces = [operated.advance(70)[0]]
    operated.set({"controller.kp": 4.0})
    operated.disturb("noise", {"deviation": 0.002, "for_s": 0.02})
    pieces.append(operated.advance(50)[0])
    operated.switch("gain")
    pieces.append(operated.advance(33)[0])
    assert [len(p) for p in pieces] == [70, 50, 33]
    assert pieces[0].shape[1] == len(operated.restarted().columns) != pieces[2].shape[1] == len(operated.columns)
    assert operated.digest == operated.session().digest == digest_of(*pieces)


@pytest.mark.slow
def test_the_digest_of_two_axes_is_of_the_columns_of_both():
    operated = Operated(Start("fsmc_ballscrew", "ours.pid", "sine_fast", circle=True, engine="python"))
    pieces = [operated.advance(20)[0]]
    operated.set({"y.controller.kp": 250.0})
    pieces.append(operated.advance(20)[0])
    assert operated.digest == digest_of(*pieces)
    one = (len(operated.columns) - 1) // 2
    x, y = pieces[1][:, 1 : one + 1], pieces[1][:, one + 1 :]
    assert x.shape == y.shape and (x != y).any(axis=0).sum() > 5
    assert operated.columns[one + 1 :] == [f"y.{c}" for c in operated.columns[1 : one + 1]]
