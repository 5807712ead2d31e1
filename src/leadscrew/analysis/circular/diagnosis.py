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
mean of both scale errors cannot be told from an error of the bar's length, nor from what both servos attenuate at this
feed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from leadscrew.analysis.circular import signatures
from leadscrew.analysis.circular.faults import Fault, faults_of
from leadscrew.analysis.circular.paths import CircularTest, Floats
from leadscrew.analysis.circular.search import Data, searched
from leadscrew.analysis.circular.shapes import KINDS, Member, columns_of
from leadscrew.kernel.errors import DataError
from leadscrew.kernel.one_thread import one_thread

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
        return f"{' and '.join(self.alone_um)} cannot be told apart from these points: {each}"


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
