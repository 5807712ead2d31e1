"""Which faults of the machine a circular test shows, and how much of each: least squares on their signatures.

The radial deviations of all turns, about the set-up centre, are the sum of the signatures of
:mod:`leadscrew.analysis.circular.signatures`, each times its size in um. Those without a shape of their own
(:data:`~leadscrew.analysis.circular.signatures.BASE`) always take part. Cyclic error, stick motion and stick-slip have
a lead, or a rise and a decay, or a period and a zone, that must be found; in turn, the one that explains most of what
is left joins, at the best shape of a grid, and all shapes are then refined together (variable projection: the sizes
follow from linear least squares for every trial of the shapes). It stops when the best explains less than 30 residual
variances, or draws less than ``floor_um``.

The uncertainty is the standard one of the fit, ``sqrt(s^2 diag((J' J)^-1))`` with ``s`` the standard deviation of what
is left and ``J`` over sizes and shapes: it covers scatter that is independent from point to point, and no error of the
instrument, no drift, and no fault that has no signature here.

What the data cannot tell apart is not guessed: signatures that are linearly dependent on the given points (with one
direction squareness and servo mismatch) have no value, and :class:`Together` says how much it would be if all were one
of them. ``condition`` is that of the signatures of unit length: 10 is easy, above 1000 the values lean on each other.

Method: Golub and Pereyra (1973) for the variable projection; the faults are those that ball-bar software names. The
mean of both scale errors cannot be distinguished from an error of the bar's length, nor from what both servos attenuate
at this feed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence, Set
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from leadscrew.analysis.circular import signatures
from leadscrew.analysis.circular.paths import TURN, CircularTest, Floats
from leadscrew.kernel.one_thread import one_thread
from leadscrew.util.errors import DataError

Shape = tuple[float, ...]
FEWEST_LEADS = 1.5
"""Fewer leads a radius look like scale and straightness."""


@dataclass(frozen=True)
class Kind:
    """One kind of signature with a shape."""

    name: str
    columns: Callable[[Data, int, Sequence[float]], Floats]
    grid: Callable[[float], list[Shape]]
    """The shapes to try; given the most leads a radius that the points resolve."""
    bounds: Callable[[float], list[tuple[float, float]]]
    parts: tuple[str, ...]
    """Names of the shape's values."""
    first: float
    """Factor of the first step of the search around the best of the grid."""
    jagged: bool = False
    """Whether the signature jumps, so that its slope says nothing."""


@dataclass(frozen=True)
class Member:
    """A signature of a kind, on one axis, with one shape."""

    kind: Kind
    which: int
    shape: Shape
    fixed: bool = False

    def columns(self, data: Data) -> Floats:
        """Its columns at the points."""
        return self.kind.columns(data, self.which, self.shape)

    def with_shape(self, shape: Sequence[float]) -> Member:
        """The same with another shape."""
        return replace(self, shape=tuple(float(v) for v in shape))


def columns_of(data: Data, members: Sequence[Member]) -> Floats:
    """All columns: the base, then each member's."""
    return np.column_stack((signatures.base(data.sign, *data.axes), *(m.columns(data) for m in members)))


@lru_cache(maxsize=8)
def _leads(most: float) -> list[Shape]:
    return [(float(k),) for k in np.arange(FEWEST_LEADS, max(most, FEWEST_LEADS + 0.1), 0.15)]


def _pairs(first: Sequence[float], second: Sequence[float]) -> list[Shape]:
    return [(a, b) for a in first for b in second]


KINDS = (
    Kind(
        "cyclic error",
        lambda d, which, shape: signatures.cyclic(d.axes[which], shape[0]),
        _leads,
        lambda most: [(1.0, max(most, FEWEST_LEADS + 0.2))],
        ("per_radius",),
        1.01,
    ),
    Kind(
        "stick motion",
        lambda d, which, shape: signatures.stick(d.axes[which], shape[0], shape[1]),
        lambda most: _pairs((0.2, 0.5, 1.0, 2.0, 4.0), (0.1, 0.3, 0.7, 1.5, 3.0, 6.0)),
        lambda most: [(0.01, 12.0), (0.02, 20.0)],
        ("rise_deg", "decay_deg"),
        1.3,
    ),
    Kind(
        "stick-slip",
        lambda d, which, shape: signatures.slip(d.axes[which], shape[0], shape[1]),
        lambda most: _pairs([float(v) for v in np.geomspace(0.6, 6.0, 80)], (4.0, 6.0, 9.0, 14.0, 20.0)),
        lambda most: [(0.4, 8.0), (2.0, 30.0)],
        ("period_deg", "zone_deg"),
        1.1,
        jagged=True,
    ),
)


@dataclass(frozen=True)
class Fault:
    """One fault and its size."""

    name: str
    axis: str
    """Axis, or both for what belongs to the pair."""
    um: float | None
    """Size as its signature defines it; None where the data cannot tell it from another fault."""
    uncertainty_um: float | None
    """Standard uncertainty of the fit alone."""
    drawn_um: float
    """Peak to peak of what it draws on this circle; of a radius lost or gained as a whole, that."""
    more: dict[str, float] = field(default_factory=dict)
    """Further values by name and unit: ``ppm``, ``urad``, ``ms``, ``lead_mm``, ``rise_deg``..."""


def faults_of(
    test: CircularTest, data: Data, members: Sequence[Member], design: Floats, sizes: Floats, uncertain: Floats,
    hidden: Set[int],
) -> list[Fault]:  # fmt: skip
    """One fault for each signature; of cyclic error the amplitude."""
    found = []
    for i, name in enumerate(signatures.BASE):
        shown = _named(name, test.axes)
        if i in hidden:
            found.append(Fault(shown, _axis(name, test.axes), None, None, 0.0))
            continue
        size = float(sizes[i])
        drawn = float(np.ptp(design[:, i] * size))
        found.append(Fault(shown, _axis(name, test.axes), size, float(uncertain[i]), drawn, _usual(name, size, test)))
    at = len(signatures.BASE)
    seen = {(m.kind.name, m.which): m for m in members}
    for kind in ("cyclic error", "stick motion", "stick-slip"):
        for which in (0, 1):
            if (kind, which) not in seen:
                axis = test.axes[which]
                found.append(Fault(f"{kind} {axis}", axis, 0.0, None, 0.0))
    for member in members:
        width = member.columns(data).shape[1]
        part, sure = sizes[at : at + width], uncertain[at : at + width]
        size = float(np.linalg.norm(part)) if width == 2 else float(part[0])
        unsure = float(np.linalg.norm(part * sure) / size) if width == 2 and size else float(sure[0])
        axis = test.axes[member.which]
        drawn = float(np.ptp(design[:, at : at + width] @ part))
        more = dict(zip(member.kind.parts, member.shape, strict=True))
        if "per_radius" in more:
            more = {"lead_mm": test.radius_mm / more["per_radius"], "phase_rad": math.atan2(part[1], part[0])}
        found.append(Fault(f"{member.kind.name} {axis}", axis, size, unsure, drawn, more))
        at += width
    return _with_whole_radius(found, test)


def _with_whole_radius(faults: list[Fault], test: CircularTest) -> list[Fault]:
    """With the mean of both scale errors as a fault of its own, where no scale is so wrong: a position loop that lags
    as ``1 / (1 + s / K)`` draws ``R / sqrt(1 + (v / (R K))^2)``.
    """
    at = [i for i, f in enumerate(faults) if f.name.startswith("scale ")]
    sizes = [um for i in at if (um := faults[i].um) is not None]
    if len(sizes) != 2:
        return faults
    mean = 0.5 * sum(sizes)
    if abs(mean) < 1e-3 * MOST_SCALE_PPM * test.radius_mm:
        return faults
    unsure = [faults[i].uncertainty_um or 0.0 for i in at]
    more = {"part_percent": 0.1 * mean / test.radius_mm}
    if mean < 0.0 and test.feed_mm_min is not None:
        lost = test.radius_mm / (test.radius_mm + 1e-3 * mean)
        more["gain_1_s"] = test.feed_mm_min / 60.0 / test.radius_mm / math.sqrt(lost**2 - 1.0)
    whole = Fault(LOST if mean < 0.0 else GAINED, "both", mean, 0.5 * math.hypot(*unsure), abs(mean), more)
    for i, size in zip(at, sizes, strict=True):
        rest = size - mean
        drawn = faults[i].drawn_um * abs(rest / size) if size else 0.0
        faults[i] = replace(faults[i], um=rest, drawn_um=drawn, more={"ppm": 1000.0 * rest / test.radius_mm})
    return [whole, *faults]


def _named(name: str, axes: tuple[str, str]) -> str:
    """The name with the axes of the test in place of X and Y."""
    what, _, axis = name.rpartition(" ")
    if axis[:1] in signatures.AXES and what:
        return f"{what} {axes[signatures.AXES.index(axis[0])]}{axis[1:]}"
    return name


def _axis(name: str, axes: tuple[str, str]) -> str:
    last = name.rsplit(" ", 1)[-1][:1]
    return axes[signatures.AXES.index(last)] if last in signatures.AXES else "both"


def _usual(name: str, size: float, test: CircularTest) -> dict[str, float]:
    """The same in the unit in which the fault is usually given."""
    if name.startswith("scale"):
        return {"ppm": 1000.0 * size / test.radius_mm}
    if name == "squareness":
        return {"urad": 1000.0 * size / test.radius_mm}
    if name == "servo mismatch" and test.feed_mm_min is not None:
        return {"ms": 60.0 * size / test.feed_mm_min}
    return {}


LOST, GAINED = "radius lost to the position loops", "radius gained by feed-forward"
MOST_SCALE_PPM = 500.0
"""Mean of both scale errors beyond which no scale is named: 40 K of thermal expansion of steel make 480."""

LEAST_GAIN = 30.0
"""Residual variances that a signature with a shape must explain to take part."""
MOST_MEMBERS = 8
BINS = 1800
"""Parts of a turn; where there are more points, shapes are searched on means of a part, and sizes fitted to all."""


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

    def binned(self) -> Data:
        """Means of the points of a direction in each of :data:`BINS` parts of the turn; none lies across a reversal."""
        at = np.floor(np.mod(self.phi, TURN) * (BINS / TURN)).astype(int) + BINS * (self.sign < 0)
        _, part, count = np.unique(at, return_inverse=True, return_counts=True)
        phi, um = (np.bincount(part, v) / count for v in (np.mod(self.phi, TURN), self.um))
        return Data(phi, np.bincount(part, self.sign) / count, um, self.radius_mm)


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


ON_REVERSAL = 0.75
"""Spacings of the points from a reversal within which a point takes no part."""
DEPENDENT = 1e-6
"""Smallest singular value, of the largest, below which signatures cannot be told apart."""


@dataclass(frozen=True)
class Together:
    """Faults that these points cannot tell apart, each with the size that it would have if it were alone."""

    alone_um: dict[str, float]

    def __str__(self) -> str:
        each = " or ".join(f"{size:.3f} um of {name}" for name, size in self.alone_um.items())
        return f"{' and '.join(self.alone_um)} cannot be distinguished by these points: {each}"


@dataclass(frozen=True)
class Diagnosis:
    """All faults; what is left; how well the points tell them apart."""

    faults: list[Fault]
    together: list[Together]
    left_rms_um: float
    """Root mean square of what no signature explains."""
    left_peak_um: float
    condition: float
    left: list[Floats] = field(repr=False)
    """What is left at each point, one array for each turn."""
    cyclic: list[Floats] = field(repr=False)
    """What the cyclic errors draw at each point, one array for each turn."""

    def __getitem__(self, name: str) -> Fault:
        """A fault by its name."""
        return next(f for f in self.faults if f.name == name)

    def ranked(self) -> list[Fault]:
        """By what they draw, largest first; without the centring, which is no fault of the machine."""
        kept = [f for f in self.faults if not f.name.startswith("centring")]
        return sorted(kept, key=lambda f: -f.drawn_um)

    def as_dict(self) -> dict[str, Any]:
        """Plain values."""
        return {
            "faults": [vars(f) for f in self.faults],
            "together": [{"alone_um": t.alone_um, "message": str(t)} for t in self.together],
            "left_rms_um": self.left_rms_um,
            "left_peak_um": self.left_peak_um,
            "condition": self.condition,
        }


@one_thread()
def diagnose(
    test: CircularTest, leads_mm: tuple[float | None, float | None] = (None, None), floor_um: float = 0.02
) -> Diagnosis:
    """The faults that the test shows.

    ``leads_mm``: pitch of each axis's cyclic error, where known; it is then no longer searched for. ``floor_um``: peak
    to peak below which cyclic error, stick motion and stick-slip are not looked for.

    Raises:
        DataError: a lead that the points of a turn cannot resolve.
    """
    turns = test.turns
    every = Data(
        np.concatenate([t.angle for t in turns]),
        np.concatenate([np.full(t.angle.size, float(t.sign)) for t in turns]),
        np.concatenate([t.deviation_um(test.radius_mm) for t in turns]),
        test.radius_mm,
    )
    data = every.without_reversals(ON_REVERSAL * max(t.spacing for t in turns))
    most = 0.25 / max(t.spacing for t in turns)
    members = []
    for which, lead in enumerate(leads_mm):
        if lead is not None:
            if not 0.0 < lead <= test.radius_mm or test.radius_mm / lead > most:
                raise DataError(
                    f"lead of {test.axes[which]} = {lead:g} mm: these points show cyclic errors from "
                    f"{test.radius_mm / most:.3g} to {test.radius_mm:g} mm"
                )
            members.append(Member(KINDS[0], which, (test.radius_mm / lead,), fixed=True))
    if max(t.x_mm.size for t in turns) > BINS:
        members = searched(data.binned(), members, min(most, 0.25 * BINS / TURN), floor_um)
    else:
        members = searched(data, members, most, floor_um)
    return _result(test, data, every, members, most)


def _result(test: CircularTest, data: Data, every: Data, members: list[Member], most: float) -> Diagnosis:
    design = columns_of(data, members)
    norms = np.linalg.norm(design, axis=0)
    _, singular, right = np.linalg.svd(design / norms, full_matrices=False)
    dependent = singular < DEPENDENT * singular[0]
    hidden = {int(i) for row in right[dependent] for i in np.flatnonzero(np.abs(row) > 1e-3)}
    sizes: Floats = np.asarray(np.linalg.lstsq(design, data.um, rcond=1e-10)[0])
    left = data.um - design @ sizes
    freedom = max(left.size - design.shape[1] - sum(len(m.shape) for m in members if not m.fixed), 1)
    scatter = math.sqrt(float(left @ left) / freedom)
    ends = np.cumsum([t.angle.size for t in test.turns])[:-1]
    uncertain = _uncertainty(data, members, design, sizes, scatter, most)
    return Diagnosis(
        faults=faults_of(test, data, members, design, sizes, uncertain, hidden),
        together=[_together(data, design, row) for row in right[dependent]],
        left_rms_um=math.sqrt(float(left @ left) / left.size),
        left_peak_um=float(np.abs(left).max()),
        condition=float(singular[0] / singular[~dependent][-1]),
        cyclic=np.split(_cyclic(every, members, sizes), ends),
        left=np.split(every.um - columns_of(every, members) @ sizes, ends),
    )


def _cyclic(data: Data, members: list[Member], sizes: Floats) -> Floats:
    drawn, at = np.zeros(data.phi.size), len(signatures.BASE)
    for member in members:
        columns = member.columns(data)
        if member.kind is KINDS[0]:
            drawn += columns @ sizes[at : at + columns.shape[1]]
        at += columns.shape[1]
    return drawn


def _together(data: Data, design: Floats, row: Floats) -> Together:
    group = [int(i) for i in np.flatnonzero(np.abs(row) > 1e-3)]
    alone = {}
    for keep in group:
        columns = [i for i in range(design.shape[1]) if i == keep or i not in group]
        found = np.linalg.lstsq(design[:, columns], data.um, rcond=1e-10)[0]
        alone[signatures.BASE[keep] if keep < len(signatures.BASE) else "another"] = float(found[columns.index(keep)])
    return Together(alone)


def _uncertainty(
    data: Data, members: list[Member], design: Floats, sizes: Floats, scatter: float, most: float
) -> Floats:
    """Standard uncertainty of each linear size, the freedom of the shapes included, but for a shape that its bound
    holds: a peak of one point has a height and no decay.
    """
    extra, at = [], len(signatures.BASE)
    for member in members:
        width = member.columns(data).shape[1]
        if not member.fixed:
            for i, (value, (low, high)) in enumerate(zip(member.shape, member.kind.bounds(most), strict=True)):
                if not 1.01 * low < value < high / 1.01:
                    continue
                step = 1e-4 * max(abs(value), 1e-3)
                ends = [member.with_shape([v + s * step if j == i else v for j, v in enumerate(member.shape)])
                        for s in (1.0, -1.0)]  # fmt: skip
                slope = (ends[0].columns(data) - ends[1].columns(data)) / (2.0 * step)
                extra.append(slope @ sizes[at : at + width])
        at += width
    jacobian = np.column_stack((design, *extra)) if extra else design
    jacobian = jacobian[:, np.linalg.norm(jacobian, axis=0) > 0.0]
    norms = np.linalg.norm(jacobian, axis=0)
    inverse = np.linalg.pinv((jacobian / norms).T @ (jacobian / norms), rcond=1e-13)
    variance = np.maximum(np.diag(inverse), 0.0) / norms**2
    return np.asarray(scatter * np.sqrt(variance[: design.shape[1]]))
