"""A system of one's own: what it costs here, in the loop, from Python, over arrays, and in other toolboxes."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from leadscrew.bench import fuzzy_peers, machine
from leadscrew.bench.fuzzy_peers import Missing
from leadscrew.bench.row import row
from leadscrew.bench.timing import interleaved, repeated
from leadscrew.fuzzy.evaluate import compiled
from leadscrew.fuzzy.system import System

WIDEST = 10.0
"""Where a universe has no end, points are drawn from this far on either side of 0."""


def points_of(system: System, count: int, seed: int = 1) -> np.ndarray:
    """Points drawn evenly from the universes of the inputs, one row a point."""
    ends = [(max(v.low, -WIDEST), min(v.high, WIDEST)) for v in system.inputs]
    low, high = np.array(ends).T
    return np.random.default_rng(seed).uniform(low, high, (count, len(ends)))


def bench_file(system: System, points: int = 100_000, rounds: int = 5) -> list[dict[str, Any]]:
    """Rows about one system; the ratio is a peer's time over ours from Python, of arrays over ours of arrays."""
    made, at = compiled(system), points_of(system, points)
    one = at[0].tolist()
    calls: dict[str, Callable[[], object]] = {
        "one": repeated(partial(made.scalar, *one), 2000),
        "many": partial(made.many, at),
    }
    seen = interleaved(calls, rounds)
    single, arrays = seen["one"] / 2000 * 1e9, seen["many"] / points * 1e9
    name = system.name or "system"
    rules = f"{len(system.rules)} rules"
    rows = [
        machine.row_of_load("before"),
        row(name, f"{rules}, one evaluation from Python", single / 1e3, "us"),
        row(name, f"{rules}, a point of {points:,} in arrays, one thread", arrays, "ns"),
    ]
    ours = made.many(at).reshape(points, -1)
    few = at[: min(2000, points)].tolist()
    try:
        found = fuzzy_peers.fuzzylite(system, few)
        rows.append(
            row(name, "fuzzylite 6 C++, in a loop", found.ns / 1e3, "us", ratio=found.ns / arrays,
                remark=f"ratio: against ours in arrays; {_apart(ours, found.outputs)}")
        )  # fmt: skip
    except Missing as why:
        rows.append(row(name, "fuzzylite 6 C++", unit="us", remark=str(why)))
    for peer in ("pyfuzzylite", "simpful", "skfuzzy"):
        rows += _python_peer(peer, system, at[:10_000].tolist(), ours, (single, arrays))
    return rows


def _python_peer(
    peer: str, system: System, points: list[list[float]], ours: np.ndarray, ns: tuple[float, float]
) -> list[dict[str, Any]]:
    name = system.name or "system"
    try:
        found = fuzzy_peers.ask(peer, system, points, 20)
    except Missing as why:
        return [row(name, peer, unit="us", remark=str(why))]
    what = f"{peer} {found.version}"
    rows = [row(name, f"{what}, one evaluation", found.ns / 1e3, "us", ratio=found.ns / ns[0],
                remark=f"against ours from Python; {_apart(ours, found.outputs)}")]  # fmt: skip
    if found.many_ns is not None:
        rows.append(row(name, f"{what}, in arrays", found.many_ns / 1e3, "us", ratio=found.many_ns / ns[1],
                        remark="against ours in arrays"))  # fmt: skip
    return rows


def _apart(ours: np.ndarray, theirs: np.ndarray) -> str:
    both = np.abs(theirs - ours[: len(theirs)])
    told = both[np.isfinite(both)]
    return f"outputs differ by at most {told.max():.1e}" if told.size else "no output to compare"
