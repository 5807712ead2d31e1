"""Rows of signals as the page gets them: float32, thinned to pairs of minimum and maximum, in binary messages."""

from __future__ import annotations

import struct
from dataclasses import dataclass

import numpy as np

LIVE, GHOST, CAPTURE = 1, 2, 3
HEADER = struct.Struct("<BBHIIIdd")
ROWS_PER_S = 2000.0
"""Most rows a second of wall time that a page is sent of one kind."""


@dataclass(frozen=True)
class Frame:
    """Consecutive rows of one run, or a capture.

    ``first`` is the period of the first row, ``stride`` the periods between rows. Where ``stride`` is above 1, rows
    come in pairs: minimum and maximum of each column over the ``2 x stride`` periods from the first of the pair on.
    """

    kind: int
    run: int
    first: float
    stride: float
    rows: np.ndarray

    def encode(self) -> bytes:
        """The binary message, little-endian: 32 bytes of header, then float32 rows (float64 of a capture)."""
        rows = np.ascontiguousarray(self.rows, dtype="<f8" if self.kind == CAPTURE else "<f4")
        header = HEADER.pack(1, self.kind, rows.shape[1], rows.shape[0], self.run, 0, self.first, self.stride)
        return header + rows.tobytes()


class Thinner:
    """Makes frames of rows as they come, so that a page never gets more than ``ROWS_PER_S``.

    Buckets begin at whole multiples of their length, however the rows were cut on the way here.
    """

    def __init__(self, kind: int, run: int) -> None:
        self.kind, self.run, self.bucket = kind, run, 1
        self._first = 0
        self._kept: list[np.ndarray] = []

    def pace(self, rows_per_s: float) -> list[Frame]:
        """Sets how many rows a second will come; gives what was waiting for a bucket of the old length."""
        bucket = 1 if rows_per_s <= ROWS_PER_S else 2 * int(np.ceil(rows_per_s / ROWS_PER_S))
        if bucket == self.bucket:
            return []
        left = self.flush()
        self.bucket = bucket
        return left

    def feed(self, first: int, rows: np.ndarray) -> list[Frame]:
        """Frames of the whole buckets that ``rows``, from period ``first`` on, complete."""
        if not len(rows):
            return []
        if self.bucket == 1:
            return [Frame(self.kind, self.run, first, 1.0, narrowed(rows))]
        left = [] if not self._kept or self._first + self._waiting() == first else self.flush()
        if not self._kept:
            self._first = first
        self._kept.append(rows)
        end = first + len(rows)
        whole_end = end - end % self.bucket
        if whole_end <= self._first:
            return left
        all_rows = np.concatenate(self._kept) if len(self._kept) > 1 else rows
        begin = -(-self._first // self.bucket) * self.bucket
        if begin > self._first:
            head = min(begin, whole_end) - self._first
            left += self._pairs(self._first, all_rows[:head], head)
        if whole_end > begin:
            left += self._pairs(begin, all_rows[begin - self._first : whole_end - self._first], self.bucket)
        rest = all_rows[whole_end - self._first :]
        self._first, self._kept = whole_end, [rest.copy()] if len(rest) else []
        return left

    def flush(self) -> list[Frame]:
        """What waits for its bucket to fill, as one shorter bucket."""
        if not self._kept:
            return []
        rows = np.concatenate(self._kept)
        self._kept = []
        return self._pairs(self._first, rows, len(rows))

    def _waiting(self) -> int:
        return sum(len(k) for k in self._kept)

    def _pairs(self, first: int, rows: np.ndarray, bucket: int) -> list[Frame]:
        """Minimum and maximum of each column over each ``bucket`` rows; of one or two rows, the rows themselves."""
        if bucket <= 2:
            return [Frame(self.kind, self.run, first, 1.0, narrowed(rows))]
        cut = rows.reshape(len(rows) // bucket, bucket, rows.shape[1])
        pairs = np.stack([cut.min(axis=1), cut.max(axis=1)], axis=1).reshape(-1, rows.shape[1])
        return [Frame(self.kind, self.run, first, bucket / 2, narrowed(pairs))]


def narrowed(rows: np.ndarray) -> np.ndarray:
    """float32; what lies beyond its range becomes infinite, without a word."""
    with np.errstate(over="ignore"):
        return rows.astype(np.float32)


__all__ = ["CAPTURE", "GHOST", "HEADER", "LIVE", "Frame", "Thinner"]
