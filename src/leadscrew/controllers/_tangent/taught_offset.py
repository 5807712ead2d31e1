"""Taught offsets: a tangential axis's controller with a table of offsets added, sample by sample.

    d(k) = clip(inner(command, feedback) + u(k), -max_offset, max_offset)

``u`` is ``table``: what earlier pieces of the same path have shown to be needed
(:func:`leadscrew.tangent.piece_learning.next_offsets` makes it). ``k`` counts samples from the first one, or from an
align. Behind the last of the ``samples`` samples the last value is held, or the table starts again (``laps=1``: a
closed path cut lap behind lap). ``samples = 0`` means the whole table. The array may be longer, so that pieces of
different length share one compiled loop.

:func:`taught_alone` is the table without feedback. The two limits are the axis's: +-15 deg in the study. An inner
controller with a limit of its own does not count the table in it.

Bumpless start as the inner controller's, less the first value of the table; alone, the table starts at its first value,
and the output is what the table says.

Source: ours, for the study ``sofnn_tangent``. The table with a period of its own and straight lines
between its places is :func:`leadscrew.controllers.feed_forward_table`.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, NamedTuple, cast

import numpy as np

from leadscrew.controllers._tangent.believed import MOST_DEG, MaxOffset, within
from leadscrew.controllers._wrapping import around
from leadscrew.kernel.block import Block, make
from leadscrew.kernel.by_position import prepared
from leadscrew.kernel.parameters import Doc, Ge, Unit, checked_replace
from leadscrew.util.errors import BlockError, ValueRefused, entry_point

Table = Annotated[np.ndarray, Unit("deg"), Doc("offset added, by sample")]
Samples = Annotated[int, Ge(0), Doc("samples of the table that are used; 0: all")]
Laps = Annotated[Literal["hold", "repeat"] | int, Doc("behind the last sample: its value, or the table again")]


class TaughtParams(NamedTuple):
    """The table."""

    table: Table = np.zeros(1)
    samples: Samples = 0
    laps: Laps = 0
    max_offset: MaxOffset = MOST_DEG


class TaughtPlan(NamedTuple):
    """The table, and where it ends."""

    table: np.ndarray
    last: int
    laps: int
    max_offset: float


class TaughtState(NamedTuple):
    """Where in the table."""

    at: Annotated[int, Doc("sample of the piece")] = 0


def taught_params(table: Any, samples: int, laps: Laps, max_offset: float) -> TaughtParams:
    """The parameters of a table, its option by name."""
    params = TaughtParams(np.array(table, dtype=np.float64), samples, 0, max_offset)
    checked: TaughtParams = checked_replace(params, {"laps": laps}, "taught")
    return checked


def plan(params: Any, dt: float) -> TaughtPlan:
    """The table, checked.

    Raises:
        ValueRefused: a table that is not a row of finite numbers, or one shorter than ``samples``.
    """
    table = np.array(params.table, dtype=np.float64)
    if table.ndim != 1 or table.size < 1 or not np.isfinite(table).all():
        raise ValueRefused(f"table of shape {table.shape} (taught_offset): expected finite numbers in one row, deg")
    if params.samples > table.size:
        raise ValueRefused(
            f"samples = {params.samples} (taught_offset): expected 0 to {table.size}, the table's length"
        )
    return TaughtPlan(table, (params.samples or table.size) - 1, params.laps, params.max_offset)


def following(p, at):
    """The sample after ``at``."""
    return at + 1 if at < p.last else (0 if p.laps == 1 else at)


def align_alone(params, command, feedback, output):
    """The state at the table's first value."""
    return TaughtState(0)


def alone(p, s, command, feedback, dt):
    """The offset of the table."""
    return TaughtState(following(p, s.at)), within(p.table[s.at], p.max_offset)


@entry_point
def taught_alone(table: Any = (0.0,), samples: int = 0, laps: Laps = "hold", max_offset: float = MOST_DEG) -> Block:
    """The table without feedback: iterative learning alone."""
    params = taught_params(table, samples, laps, max_offset)
    return make(
        "controller", alone, params, TaughtState(), prepare=plan, align=align_alone, name="taught_alone", unit="deg",
        drive="position", doc="Offsets of a tangential axis from a table, without feedback; deg.",
    )  # fmt: skip


@entry_point
def taught_offset(
    inner: Block,
    table: Any = (0.0,),
    samples: int = 0,
    laps: Laps = "hold",
    max_offset: float = MOST_DEG,
    name: str = "",
) -> Block:
    """The controller ``inner`` with a table added; its parameters are those of ``inner`` below ``inner.``.

    It takes what ``inner`` takes: numbers, or the command and reading of a cut line.

    Raises:
        BlockError: ``inner`` is not a sampled controller with parameters and state, or takes other signals.
    """
    if inner.kind != "controller" or inner.continuous or inner.params is None or inner.state is None:
        raise BlockError(f"taught_offset({inner.name}): needs a sampled controller with parameters and state")
    if inner.signals != ("command", "feedback", "dt") or inner.initial is not None:
        raise BlockError(f"taught_offset({inner.name}): needs a controller that takes command, feedback and dt")
    law = inner.step
    align_inner: Any = inner.align
    params_type = around("TaughtOffsetParams", inner.params, ("taught", TaughtParams))
    state_type = around("TaughtOffsetState", inner.state, ("taught", TaughtState))

    def prepare(params: Any, dt: float) -> Any:
        ready = prepared(inner, dt, params.inner)
        return around("TaughtOffsetPlan", ready, ("taught", TaughtPlan))(ready, plan(params.taught, dt))

    def align(params, command, feedback, output):
        """The state from which the next output is ``output``."""
        rest = output - params.taught.table[0]
        return state_type(align_inner(params.inner, command, feedback, rest), TaughtState(0))

    def with_table(p, s, command, feedback, dt):
        """The inner controller and the table, within the axis's limits."""
        after, d = law(p.inner, s.inner, command, feedback, dt)
        taught = TaughtState(following(p.taught, s.taught.at))
        return state_type(after, taught), within(d + p.taught.table[s.taught.at], p.taught.max_offset)

    cast(Any, with_table).takes_cut_line = getattr(law, "takes_cut_line", False)
    params = taught_params(table, samples, laps, max_offset)
    return make(
        "controller", with_table, params_type(inner.params, params), state_type(inner.state, TaughtState()),
        prepare=prepare, align=None if align_inner is None else align, name=name or f"{inner.name}_taught",
        unit="deg", drive=inner.drive, doc=f"{inner.doc} A table of earlier pieces is added.",
    )  # fmt: skip
