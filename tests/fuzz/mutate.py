"""Changes of a file such as a bad disk, a careless editor, or somebody hostile makes."""

from __future__ import annotations

import random
import re

PIECES = re.compile(rb"[A-Za-z_]+|\d+|\s+|[^\w\s]|[^\x00-\x7f]+")
ODD = [
    *("0", "-1", "1e999", "-1e308", "nan", "inf", "-inf", "99999999999999999999", "9" * 400, "1e-320", "1_0", "true"),
    *("null", "[]", "{}", "<!--", "]]>", "&lt;", "\\ud800", "", "\0", "\x1b]0;x\x07", "\r", "\n\n", "\t", "\u00b5"),
    *("\u0663", "\u2028", "../../etc/passwd", "/dev/zero", "a" * 5000, "[" * 3000, "(" * 3000, *",;%#[]{}()\"'\\"),
]
"""Pieces of text that readers have stumbled over."""
BYTES = [0, 1, 127, 128, 255]


def mutated(data: bytes, rng: random.Random, others: list[bytes]) -> bytes:
    """The file with one to eight changes; pieces of ``others`` may be put in."""
    binary = b"\0" in data[:4096]
    for _ in range(min(8, 1 + int(rng.expovariate(1.2)))):
        data = (_bytes if binary or rng.random() < 0.15 else _pieces)(data, rng, others)
    return data[:4_000_000]


def _bytes(data: bytes, rng: random.Random, others: list[bytes]) -> bytes:
    held = bytearray(data)
    at = rng.randrange(len(held) + 1)
    end = min(len(held), at + int(rng.expovariate(0.02)))
    how = rng.randrange(10)
    if how == 0:
        del held[at:end]
    elif how == 1:
        held[at:at] = held[at:end]
    elif how == 2:
        held = held[:at]
    elif how == 3 and at + 4 <= len(held):
        held[at : at + 4] = rng.choice((0, 1, 2**31 - 1, 2**31, 2**32 - 1)).to_bytes(4, "little")
    elif how == 4:
        other = rng.choice(others)
        start = rng.randrange(len(other) + 1)
        held[at:end] = other[start : start + end - at]
    else:
        for place in range(at, min(len(held), at + rng.choice((1, 1, 1, 4)))):
            held[place] = rng.choice((rng.randrange(256), *BYTES, held[place] ^ (1 << rng.randrange(8))))
    return bytes(held)


def _pieces(data: bytes, rng: random.Random, others: list[bytes]) -> bytes:
    pieces = PIECES.findall(data)
    if not pieces:
        return rng.choice(ODD).encode()
    at, other = rng.randrange(len(pieces)), rng.randrange(len(pieces))
    how = rng.randrange(12)
    if how == 0:
        del pieces[at]
    elif how == 1:
        del pieces[at : at + int(rng.expovariate(0.05))]
    elif how == 2:
        pieces[at], pieces[other] = pieces[other], pieces[at]
    elif how == 3:
        pieces[at:at] = pieces[other : other + int(rng.expovariate(0.05))] * rng.choice((1, 1, 1, 50))
    elif how == 4:
        pieces = pieces[:at]
    elif how == 5:
        foreign = PIECES.findall(rng.choice(others)[:20_000])
        start = rng.randrange(len(foreign) + 1)
        pieces[at : at + 1] = foreign[start : start + int(rng.expovariate(0.2))]
    elif how < 10:
        numbers = [k for k, piece in enumerate(pieces) if piece[:1].isdigit()]
        pieces[rng.choice(numbers) if numbers else at] = rng.choice(ODD).encode()
    else:
        pieces[at] = rng.choice(ODD).encode()
    return b"".join(pieces)
