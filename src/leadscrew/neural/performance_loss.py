"""What a performance network is trained to: the cells of a table, and to go the right way between them.

    cells     P - T on the 13 x 13 levels
    near      0.3 (P - bilinear T) on |E|, |EC| <= 1.5, 13 x 13 points
    way       0.045 max(P sign(E), 0) on 49 x 49 points of the whole range
    origin    10 P(0, 0), where the network has biases (without it is 0)
    ridge     0.003 w of every weight

``plain`` is cells and ridge; ``safe`` all of them. Source: ours; the paper trains by the cells alone.
"""

from __future__ import annotations

import numpy as np

from leadscrew.kernel.one_thread import one_thread
from leadscrew.neural.genetic import Cost
from leadscrew.neural.performance import LEVELS, looked_up
from leadscrew.neural.performance_shape import Shape

RIDGE = 3e-3
NEAR, NEAR_WEIGHT = 1.5, 0.3
WAY_POINTS, WAY_WEIGHT = 49, 0.045
ORIGIN_WEIGHT = 10.0


def points_of(e: np.ndarray, ec: np.ndarray) -> np.ndarray:
    """All pairs ``(E, EC)``, E fastest, ``(n, 2)``."""
    across, up = np.meshgrid(e, ec)
    return np.column_stack([across.ravel(), up.ravel()])


CELLS = points_of(LEVELS, LEVELS)
"""The 169 cells."""


def rmse_of(shape: Shape, table: np.ndarray) -> Cost:
    """The cost of rows of weights: root mean square difference to the cells, in levels."""
    wanted = table.ravel()

    def cost(rows: np.ndarray) -> np.ndarray:
        return np.asarray(np.sqrt(np.mean((shape.outputs(rows, CELLS) - wanted) ** 2, axis=1)))

    return cost


class Loss:
    """Residuals of a row of weights and their derivatives, for least squares."""

    def __init__(
        self, shape: Shape, table: np.ndarray, safe: bool, ridge: float = RIDGE, near_weight: float = NEAR_WEIGHT
    ) -> None:
        self.shape, self.ridge = shape, ridge
        parts = [(CELLS, np.asarray(table, float).ravel(), 1.0)]
        self.way = np.empty(0)
        if safe:
            places = np.linspace(-NEAR, NEAR, 13)
            near = points_of(places, places)
            parts.append((near, np.array([looked_up(table, e, ec) for e, ec in near]), near_weight))
            places, count = np.linspace(-6.0, 6.0, WAY_POINTS), 1.0
            whole = points_of(places, places)
            if shape.biases == "none":
                # An odd network does on the left what it does on the right.
                whole, count = whole[whole[:, 0] > 0.0], 2.0
            else:
                parts.append((np.zeros((1, 2)), np.zeros(1), ORIGIN_WEIGHT))
            self.way = np.sign(whole[:, 0])
            parts.append((whole, np.zeros(len(whole)), WAY_WEIGHT * np.sqrt(count)))
        self.points = np.concatenate([points for points, _, _ in parts])
        self.wanted = np.concatenate([wanted for _, wanted, _ in parts])
        self.scale = np.concatenate([np.full(len(points), weight) for points, _, weight in parts])
        self._last: tuple[np.ndarray, tuple[np.ndarray, np.ndarray]] | None = None

    def both(self, row: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Residuals and their derivatives by the weights."""
        if self._last is not None and np.array_equal(self._last[0], row):
            return self._last[1]
        p, by = self.shape.slopes(row, self.points)
        scale = self.scale.copy()
        if self.way.size:
            scale[-self.way.size :] *= p[-self.way.size :] * self.way > 0.0
        values = np.concatenate([scale * (p - self.wanted), self.ridge * row])
        slopes = np.concatenate([scale[:, None] * by, self.ridge * np.eye(row.size)])
        self._last = (row.copy(), (values, slopes))
        return values, slopes

    def residuals(self, row: np.ndarray) -> np.ndarray:
        """What least squares makes small."""
        return self.both(row)[0]

    def jacobian(self, row: np.ndarray) -> np.ndarray:
        """Its derivatives."""
        return self.both(row)[1]


def polish(row: np.ndarray, loss: Loss, box: float = 15.0, most: int = 200) -> np.ndarray:
    """The row of weights at the foot of the valley: least squares inside ``-box .. box`` (SciPy, trust region)."""
    from scipy.optimize import least_squares

    inside = np.clip(row, -0.999 * box, 0.999 * box)
    with one_thread():
        found = least_squares(
            loss.residuals, inside, jac=loss.jacobian, bounds=(-box, box), method="trf", max_nfev=most, xtol=1e-9,
            ftol=1e-9,
        )  # fmt: skip
    return np.asarray(found.x)
