"""The search for signatures with a shape: which take part, and their shapes. Method: see the diagnosis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from leadscrew.analysis.circular import signatures
from leadscrew.analysis.circular.paths import Floats
from leadscrew.analysis.circular.shapes import KINDS, Kind, Member, Shape, columns_of

LEAST_GAIN = 30.0
"""Residual variances that a signature with a shape must explain to take part."""
MOST_MEMBERS = 8


@dataclass(frozen=True)
class Data:
    """The points of all turns below one another."""

    phi: Floats
    sign: Floats
    um: Floats
    radius_mm: float

    @cached_property
    def axes(self) -> tuple[signatures.Motions, signatures.Motions]:
        """How each axis moves at the points."""
        return signatures.motions(self.phi, self.sign, 0), signatures.motions(self.phi, self.sign, 1)

    def without_reversals(self, angle: float) -> Data:
        """Without the points within ``angle`` of a reversal: on which side of a step they lie is not known."""
        kept = (np.abs(np.sin(self.phi)) > angle) & (np.abs(np.cos(self.phi)) > angle)
        return Data(self.phi[kept], self.sign[kept], self.um[kept], self.radius_mm)


def searched(data: Data, members: list[Member], most: float, floor: float) -> list[Member]:
    """The members that explain what the base does not, with their shapes refined."""
    for _ in range(MOST_MEMBERS):
        design = columns_of(data, members)
        basis = _independent(design)
        left = _off(basis, data.um)
        if float(np.ptp(left)) < floor:
            break
        taken = {(m.kind.name, m.which) for m in members}
        best: tuple[float, Member] | None = None
        for kind in KINDS:
            for which in (0, 1):
                if (kind.name, which) in taken:
                    continue
                gain, shape = _best_shape(data, kind, which, most, basis, left)
                if best is None or gain > best[0]:
                    best = (gain, Member(kind, which, shape))
        if best is None:
            break
        new = best[1]
        new = new.with_shape(_closer(data, new.kind, new.which, new.shape, most, basis, left)[1])
        tried = _refined(data, [*members, new], most)
        now = _residual(data, tried)
        rest = float(now @ now) / max(now.size - design.shape[1] - 4, 1)
        gained = float(left @ left - now @ now)
        size = _drawn(data, tried)[-1]
        if gained < LEAST_GAIN * rest or size < floor:
            break
        members = tried
    return members


def _best_shape(data: Data, kind: Kind, which: int, most: float, basis: Floats, left: Floats) -> tuple[float, Shape]:
    """The shape of the kind's grid that explains most of ``left``, and the sum of squares that it explains."""
    return _best_of(data, kind, which, kind.grid(most), basis, left)


def _best_of(
    data: Data, kind: Kind, which: int, shapes: Sequence[Shape], basis: Floats, left: Floats
) -> tuple[float, Shape]:
    best = (-1.0, shapes[0])
    for at in range(0, len(shapes), 64):
        some = shapes[at : at + 64]
        columns = np.stack([kind.columns(data, which, shape) for shape in some], axis=-1)
        before = np.einsum("nws,nws->ws", columns, columns)
        columns = _off(basis, columns)
        squares = np.einsum("nvs,nws->svw", columns, columns)
        along = np.einsum("n,nws->sw", left, columns)
        for i, shape in enumerate(some):
            if np.all(np.diag(squares[i]) > 1e-6 * before[:, i]) and np.all(before[:, i] > 0.0):
                gain = float(along[i] @ np.linalg.lstsq(squares[i], along[i], rcond=1e-9)[0])
                best = max(best, (gain, shape))
    return best


def _gain(data: Data, kind: Kind, which: int, shape: Shape, basis: Floats, left: Floats) -> float:
    columns = kind.columns(data, which, shape)
    square = float(np.sum(columns**2))
    columns = _off(basis, columns)
    if float(np.sum(columns**2)) < 1e-6 * square or square == 0.0:
        return -1.0
    along = np.einsum("nw,n->w", columns, left)
    return float(along @ np.linalg.lstsq(np.einsum("nv,nw->vw", columns, columns), along, rcond=1e-9)[0])


def _closer(
    data: Data, kind: Kind, which: int, shape: Shape, most: float, basis: Floats, left: Floats
) -> tuple[float, Shape]:
    """A shape near ``shape`` that explains more, by pattern search: it needs no slope, which a saw tooth has not."""
    best, factor = _gain(data, kind, which, shape, basis, left), kind.first
    while factor > 1.0 + 1e-5:
        moved = False
        for i, (low, high) in enumerate(kind.bounds(most)):
            for by in (factor, 1.0 / factor):
                trial = tuple(min(max(v * by, low), high) if j == i else v for j, v in enumerate(shape))
                gain = _gain(data, kind, which, trial, basis, left)
                if gain > best:
                    best, shape, moved = gain, trial, True
        if not moved:
            factor = 1.0 + 0.5 * (factor - 1.0)
    return best, shape


def _refined(data: Data, members: list[Member], most: float) -> list[Member]:
    """The members with all free shapes refined: smooth ones together, saw teeth by turns with them."""
    for _ in range(3):
        members = _together_refined(data, members, most)
        jagged = [i for i, m in enumerate(members) if m.kind.jagged and not m.fixed]
        if not jagged:
            break
        for i in jagged:
            others = [m for j, m in enumerate(members) if j != i]
            basis = _independent(columns_of(data, others))
            left = _off(basis, data.um)
            mine = members[i]
            near = _best_of(data, mine.kind, mine.which, _around(mine, most), basis, left)[1]
            members[i] = mine.with_shape(_closer(data, mine.kind, mine.which, near, most, basis, left)[1])
    return members


def _around(member: Member, most: float) -> list[Shape]:
    """A fine grid around a member's shape, itself first."""
    (low, high), (shortest, longest) = member.kind.bounds(most)
    first, second = member.shape
    firsts = np.clip(first * np.linspace(0.94, 1.06, 49), low, high)
    seconds = np.clip(second * np.linspace(0.85, 1.15, 19), shortest, longest)
    return [member.shape, *((float(a), float(b)) for a in firsts for b in seconds)]


def _together_refined(data: Data, members: list[Member], most: float) -> list[Member]:
    from scipy.optimize import least_squares

    free = [i for i, m in enumerate(members) if not (m.fixed or m.kind.jagged)]
    start = np.array([v for i in free for v in members[i].shape])
    low, high = (np.array([b[end] for i in free for b in members[i].kind.bounds(most)]) for end in (0, 1))
    if not start.size:
        return list(members)

    def put(values: Floats) -> list[Member]:
        at, made = 0, list(members)
        for i in free:
            made[i] = made[i].with_shape([float(v) for v in values[at : at + len(made[i].shape)]])
            at += len(made[i].shape)
        return made

    inside = np.clip(start, low + 1e-9 * (high - low), high - 1e-9 * (high - low))
    found = least_squares(
        lambda v: _residual(data, put(v)), inside, bounds=(low, high), x_scale=np.maximum(np.abs(inside), 0.1),
        diff_step=1e-5, max_nfev=20, xtol=1e-9, ftol=1e-12,
    )  # fmt: skip
    return put(np.asarray(found.x))


def _residual(data: Data, members: list[Member]) -> Floats:
    basis = _independent(columns_of(data, members))
    return _off(basis, data.um)


def _off(basis: Floats, values: Floats) -> Floats:
    """What of the values the basis does not hold. Not by BLAS: its threads cost more than such thin matrices give."""
    return np.asarray(values - np.einsum("nk,k...->n...", basis, np.einsum("nk,n...->k...", basis, values)))


def _independent(design: Floats) -> Floats:
    """An orthonormal basis of what the columns span; directions that carry nothing are left out."""
    unit = design / np.maximum(np.linalg.norm(design, axis=0), 1e-300)
    squares, turned = np.linalg.eigh(np.einsum("ni,nj->ij", unit, unit))
    kept = squares > 1e-10 * squares[-1]
    return np.asarray(np.einsum("ni,ij->nj", unit, turned[:, kept] / np.sqrt(squares[kept])))


def _sizes(data: Data, members: list[Member]) -> Floats:
    return np.asarray(np.linalg.lstsq(columns_of(data, members), data.um, rcond=1e-10)[0])


def _drawn(data: Data, members: list[Member]) -> list[float]:
    """Peak to peak of what each member draws."""
    sizes = _sizes(data, members)
    at, found = len(signatures.BASE), []
    for member in members:
        columns = member.columns(data)
        found.append(float(np.ptp(columns @ sizes[at : at + columns.shape[1]])))
        at += columns.shape[1]
    return found
