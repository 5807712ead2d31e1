"""Feed-forward table: any controller, with a torque added that is known from earlier passes of the same motion.

    output = inner(command, feedback) + u(x),      x = n (t - t_0) / period_s  modulo n

``u`` is the straight line between the ``n`` values of ``table`` at equal intervals of one period; behind the last value
comes the first again. ``t_0`` is the first sample, or an align: the motion has to start there too.

A controller with a disturbance observer need not be told. With ``d = L (q - J v)``, ``q' = T - F_hat - d`` and ``T``
its own torque, ``J v' = T + u - F`` gives ``d' = L (F - F_hat - u - d)``: the observer treats the table as it treats
the friction model, and what it still finds is what the table does not have yet.
:func:`leadscrew.controllers._trial_learning.taught` makes the next table of it.

A limit of the inner controller's output does not count the table. Bumpless start as the inner controller's, less the
first value of the table.
"""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np

from leadscrew.controllers._wrapping import around, same_kind, wrapped
from leadscrew.kernel.block import Block
from leadscrew.kernel.by_position import prepared
from leadscrew.kernel.parameters import Doc, Gt, Le, Unit
from leadscrew.util.errors import ValueRefused, entry_point

Table = Annotated[np.ndarray, Doc("added to the output, at equal intervals of one period; in the unit of the output")]
PeriodS = Annotated[float, Unit("s"), Gt(0), Le(1e4), Doc("time after which the table starts again")]
Place = Annotated[float, Doc("where in the table, 0 to n")]


def checked(table: Any) -> np.ndarray:
    """The table as a row of numbers.

    Raises:
        ValueRefused: none, not in a row, or one that is not finite.
    """
    values = np.array(table, dtype=np.float64)
    if values.ndim != 1 or values.size < 1 or not np.isfinite(values).all():
        raise ValueRefused(f"table of shape {values.shape} (feed_forward_table): expected finite numbers in one row")
    return values


@entry_point
def feed_forward_table(inner: Block, table: Any = (0.0,), period_s: float = 1.0, name: str = "") -> Block:
    """The controller ``inner`` with a table added; its parameters are those of ``inner`` below ``inner.``.

    Raises:
        BlockError: ``inner`` is not a sampled controller with parameters and state, or takes other signals.
        ValueRefused: a table that is not a row of finite numbers, or a period out of range.
    """
    part = wrapped(inner, "feed_forward_table")
    law = part.law
    params_type = around("TableParams", inner.params, ("table", Table), ("period_s", PeriodS))
    state_type = around("TableState", inner.state, ("place", Place))

    def prepare(params: Any, dt: float) -> Any:
        ready = prepared(inner, dt, params.inner)
        values = checked(params.table)
        n = float(values.size)
        plan_type = around("TablePlan", ready, ("table", np.ndarray), ("count", float), ("stride", float))
        return plan_type(ready, values, n, n * dt / params.period_s % n)

    def align(params, command, feedback, output):
        """The state from which the next output is ``output``."""
        return state_type(part.align(params.inner, command, feedback, output - params.table[0]), 0.0)

    def with_table(p, s, command, feedback, dt):
        """The inner controller and the table."""
        k = int(s.place)
        here = p.table[k]
        behind = p.table[k + 1 if k + 1.0 < p.count else 0]
        after, u = law(p.inner, s.inner, command, feedback, dt)
        place = s.place + p.stride
        return state_type(after, place - p.count if place >= p.count else place), u + here + (s.place - k) * (
            behind - here
        )

    return same_kind(
        with_table, part, params_type(inner.params, checked(table), period_s), state_type(inner.state, 0.0),
        "A table of earlier passes is added.", prepare=prepare, align=align, name=name or f"{inner.name}_table",
    )  # fmt: skip
