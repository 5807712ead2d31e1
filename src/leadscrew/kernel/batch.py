"""Many runs of one loop, side by side and on all cores."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import nullcontext, suppress
from dataclasses import dataclass, field
from queue import Empty, SimpleQueue
from threading import Event, Thread
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.kernel import validate
from leadscrew.kernel.engines import ENGINES
from leadscrew.kernel.layout import numbers_of, reader_of
from leadscrew.kernel.linker import LANES
from leadscrew.kernel.one_thread import one_thread
from leadscrew.kernel.parameters import ParameterSpec, nearest, put
from leadscrew.kernel.run import Metrics, recorded
from leadscrew.util.errors import NameUnknown, ValueRefused, entry_point
from leadscrew.util.escape import html

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

MEMORY = 8 * 1024**3
"""Bytes of recorded signals above which a batch is refused."""


HEARD_S = 0.1
"""After which Ctrl-C is heard at the latest."""


@entry_point
@dataclass(repr=False)
class Batch:
    """The result of many runs: arrays with one row a run."""

    loop: Loop
    duration: float
    varied: dict[str, np.ndarray]
    metrics: dict[str, np.ndarray]
    diverged_at: np.ndarray
    """Seconds at which a run diverged, NaN for the ones that did not."""
    signals: dict[str, np.ndarray] = field(default_factory=dict)
    """Recorded signals, ``[run, row]``."""
    shape: tuple[int, ...] = ()

    def __len__(self) -> int:
        return len(self.diverged_at)

    @property
    def integration(self) -> dict[str, Any]:
        """What integrated the plant in every run, see :attr:`leadscrew.Loop.integration`."""
        return self.loop.integration

    def __repr__(self) -> str:
        lost = int(np.isfinite(self.diverged_at).sum())
        rows = ", ".join(
            f"{k} {np.nanmin(v):.4g}..{np.nanmax(v):.4g}" for k, v in self.metrics.items() if np.isfinite(v).any()
        )
        return f"<Batch {self.loop.name}: {len(self)} runs of {self.duration:g} s, {lost} diverged: {rows}>"

    def _repr_html_(self) -> str:
        rows = ""
        for name, values in self.metrics.items():
            known = values[np.isfinite(values)]
            cells = (np.percentile(known, q) for q in (5, 50, 95)) if len(known) else (np.nan,) * 3
            rows += f"<tr><td>{html(name)}</td>{''.join(f'<td>{c:.5g}</td>' for c in cells)}</tr>"
        head = "<tr><th>metric</th><th>5 %</th><th>median</th><th>95 %</th></tr>"
        return f"<h4>{html(self.loop.name)}: {len(self)} runs of {self.duration:g} s</h4><table>{head}{rows}</table>"

    @property
    def time(self) -> np.ndarray:
        """Seconds since the start, one for each recorded row."""
        return np.asarray(self.signals["time"][0])

    def __getitem__(self, name: str) -> np.ndarray:
        return recorded(self.signals, name)

    def grid(self, metric: str) -> np.ndarray:
        """A metric in the shape of the sweep's grid."""
        if metric not in self.metrics:
            raise NameUnknown(f"there is no metric {metric!r}{nearest(metric, list(self.metrics))}")
        return self.metrics[metric].reshape(self.shape or (-1,))

    def run(self, k: int) -> Metrics:
        """The metrics of one run."""
        return Metrics((name, float(v[k])) for name, v in self.metrics.items())


def _columns(varied: Mapping[str, Any], loop: Loop, runs: int | None) -> tuple[dict[str, np.ndarray], int]:
    """Each varied parameter as an array with one row a run, checked against its sheet."""
    found: dict[str, np.ndarray] = {}
    for key, values in varied.items():
        loop.split(key)
        entry = loop.sheet[key]
        array = numbers(entry, values)
        inner = np.shape(entry.default) if entry.type == "array" else ()
        if array.ndim == len(inner):
            array = array[None]
        if array.shape[1:] != inner:
            raise ValueRefused(f"{key}: expected the shape (runs, {', '.join(map(str, inner))}), got {array.shape}")
        if array.size == 0:
            raise ValueRefused(f"{key}: there is no value to run")
        if entry.type == "array":
            for row in array:
                entry.check(row, "batch")
        elif entry.choice is None:
            low, high = array.min(), array.max()
            for x in (float(low), float(high)):
                entry.check(int(x) if entry.type == "int" and x == int(x) else x, "batch")
        found[key] = array
    if runs is not None:
        validate.whole("runs", runs, 1, 2**31 - 1)
    lengths = {len(a) for a in found.values() if len(a) > 1} | ({runs} if runs is not None else set())
    if len(lengths) > 1:
        held = ", ".join(f"{k} has {len(a)}" for k, a in found.items())
        wanted = f", runs = {runs}" if runs is not None else ""
        raise ValueRefused(f"a batch needs the same number of values for every key: {held}{wanted}")
    n = validate.whole("runs", lengths.pop() if lengths else 1, 1, 2**31 - 1)
    return {k: np.ascontiguousarray(np.broadcast_to(a, (n, *a.shape[1:]))) for k, a in found.items()}, n


def numbers(entry: ParameterSpec, values: Any) -> np.ndarray:
    """Values of one parameter as an array; a choice may be given by names.

    Raises:
        ValueRefused: no numbers; no name of the choice.
    """
    if entry.choice is not None:
        return np.array([entry.stored(v, "batch") for v in np.ravel(values)], dtype=np.float64).reshape(
            np.shape(values)
        )
    try:
        return np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueRefused(f"{entry.key}: expected an array of numbers, one for each run") from None


def _places(loop: Loop, columns: Mapping[str, np.ndarray], n: int, duration: float) -> tuple[np.ndarray, np.ndarray]:
    """Where the varied numbers lie in all vectors laid end to end, and their values ``[place, run]``."""
    plan = loop.program.plan
    sizes = [max(1, len(plan.params.scalars)), max(1, plan.params.array_size), max(1, len(plan.state.scalars))]
    places: list[int] = []
    values: list[np.ndarray] = []
    derived: dict[str, list[str]] = {}
    for key, array in columns.items():
        slot, rest = loop.split(key)
        block = loop._parametered()[slot]
        if block.prepare is not None or block.initial is not None:
            derived.setdefault(slot, []).append(rest)
            continue
        leaf = plan.params.keys[key]
        start = leaf.at + (sizes[0] if leaf.kind == "array" else 0)
        for i in range(leaf.size if leaf.kind == "array" else 1):
            places.append(start + i)
            values.append(array.reshape(n, -1)[:, i])
    for slot, keys in derived.items():
        where, packed, inverse = _prepared(loop, slot, keys, columns, sizes, duration)
        moved = np.flatnonzero((packed != packed[-1]).any(axis=0))
        places += where[moved].tolist()
        values += [packed[inverse, m] for m in moved]
    return np.array(places, dtype=np.int64), np.array(values, dtype=np.float64).reshape(len(places), n)


def _prepared(
    loop: Loop, slot: str, keys: list[str], columns: Mapping[str, np.ndarray], sizes: list[int], duration: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What one block's parameters become at the door, for every set of values that occurs.

    Returns:
        the places of the numbers; the numbers ``[set, place]``, the loop's own set last; the set of each run.
    """
    block = loop._parametered()[slot]
    rows = np.concatenate([columns[f"{slot}.{k}"].reshape(len(columns[f"{slot}.{k}"]), -1) for k in keys], axis=1)
    _, firsts, inverse = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    kinds = [loop.sheet[f"{slot}.{k}"].type for k in keys]
    given = [columns[f"{slot}.{k}"][firsts] for k in keys]
    typed = [
        list(a) if kind == "array" else a.astype(np.int64).tolist() if kind in ("int", "choice") else a.tolist()
        for a, kind in zip(given, kinds, strict=True)
    ]
    flat = all("." not in k for k in keys)
    plan = loop.program.plan
    with_state = block.initial is not None and not slot.startswith("metrics.")
    prepare = loop.preparation(block, slot, duration)
    read = reader_of(prepare(block.params))
    made = []
    with one_thread() if len(firsts) >= 16 else nullcontext():
        for values in (*zip(*typed, strict=True), ()):
            params = block.params
            if flat:
                params = params._replace(**dict(zip(keys, values, strict=False)))
            else:
                for key, value in zip(keys, values, strict=False):
                    params = put(params, key.split("."), value)
            numbers = read(prepare(params))
            if with_state and block.initial is not None:
                numbers += numbers_of(block.initial(params))
            made.append(numbers)
    where = [*plan.params.places(slot, sizes[0], 0)]
    if with_state:
        where += plan.state.places(slot, sizes[2], sizes[0] + sizes[1])
    return np.array(where), np.array(made, dtype=np.float64), inverse.ravel()


def run_batch(
    loop: Loop,
    duration: float,
    varied: Mapping[str, Any],
    runs: int | None,
    record: str | Sequence[str] | None,
    every: int,
    threads: int | None,
    first: int,
    engine: str | None,
    progress: Callable[[float], None] | None,
) -> Batch:
    """See ``Loop.batch``."""
    if loop.continuous:
        raise ValueRefused("a batch needs a control period; a continuous loop (period=None) runs one at a time")
    columns, n = _columns(varied, loop, runs)
    periods = loop.periods(duration)
    every = validate.whole("every", every, 1, 2**53)
    threads = validate.whole("threads", threads if threads is not None else os.cpu_count() or 1, 1, 1024)
    first = validate.whole("first", first, 0, 2**31 - 1)
    names = loop.columns(record) if record is None or len(record) else []
    rows = -(-periods // every) if names else 0
    size = n * rows * len(names) * 8
    if size > MEMORY:
        raise ValueRefused(
            f"recording {n} runs of {rows} rows of {len(names)} signals needs {size / 1e9:.0f} GB; "
            "record fewer, or a larger every"
        )
    engine = validate.one_of("engine", engine or loop.engine, list(ENGINES))
    if engine == "python":
        return _one_by_one(loop, duration, columns, n, names, every, first)
    program = loop.program
    select = np.array([program.plan.columns.index(c) for c in names], dtype=np.int64)
    ends = periods * loop.period
    params, state = loop.values(ends)
    vectors = (*program.plan.params.pack(params), *program.plan.state.pack(state))
    places, values = _places(loop, columns, n, ends)
    table = np.zeros((n, max(1, len(names)), max(1, rows)) if names else (1, 1, 1))
    metrics = np.zeros((n, max(1, len(loop.metrics))))
    lost = np.full(n, -1, dtype=np.int64)
    entry = program.entry("lanes_recorded" if names else "lanes", engine)
    parts = 1 if threads == 1 and progress is None else 8 * threads
    chunk = max(LANES, -(-n // parts // LANES) * LANES)
    starts = list(range(0, n, chunk))

    def work(low: int) -> None:
        span = np.array([low, min(n, low + chunk), periods, every, first], dtype=np.int64)
        room = [np.empty(vectors[i].size * LANES) for i in (1, 3)]
        entry(*vectors, *room, places, values, span, select, table, metrics, lost)

    for done, _ in enumerate(_worked(work, starts, threads), start=1):
        if progress is not None:
            progress(done / len(starts))
    metrics[lost >= 0] = np.nan
    diverged_at = np.where(lost >= 0, (lost + 1) * loop.period, np.nan)
    signals = {c: table[:, i, :] for i, c in enumerate(names)}
    measured = {k: metrics[:, i].copy() for i, k in enumerate(loop.metrics)}
    return Batch(loop, duration, columns, measured, diverged_at, signals)


def _worked(work: Callable[[int], None], parts: Sequence[int], threads: int) -> Iterator[None]:
    """Works off the parts in threads, and says when each is done.

    Ctrl-C is heard at once: no further part is begun, and one that runs ends by itself, or with the process.
    """
    waiting: SimpleQueue[int] = SimpleQueue()
    done: SimpleQueue[BaseException | None] = SimpleQueue()
    given_up = Event()
    for part in parts:
        waiting.put(part)

    def worker() -> None:
        while not given_up.is_set():
            try:
                part = waiting.get_nowait()
            except Empty:
                return
            try:
                work(part)
                done.put(None)
            except BaseException as problem:
                done.put(problem)

    for _ in range(min(threads, len(parts))):
        Thread(target=worker, daemon=True).start()
    try:
        for _ in parts:
            problem = None
            while True:
                with suppress(Empty):
                    problem = done.get(timeout=HEARD_S)
                    break
            if problem is not None:
                raise problem
            yield
    finally:
        given_up.set()


def _one_by_one(
    loop: Loop, duration: float, columns: dict[str, np.ndarray], n: int, names: list[str], every: int, first: int
) -> Batch:
    """The batch on the Python engine: run after run."""
    done = []
    for k in range(n):
        kinds = {key: loop.sheet[key].type for key in columns}
        changes = {
            key: a[k] if kinds[key] == "array" else int(a[k]) if kinds[key] in ("int", "choice") else float(a[k])
            for key, a in columns.items()
        }
        done.append(
            loop.using(changes).run(
                duration, record=names or (), every=every if names else 0, engine="python", replicate=first + k
            )
        )
    diverged_at = np.array([r.diverged.time if r.diverged else np.nan for r in done])
    measured = {k: np.array([r.metrics[k] for r in done]) for k in loop.metrics}
    longest = -(-loop.periods(duration) // every)
    signals = {
        c: np.array([np.pad(r.signals[c], (0, longest - len(r.signals[c])), constant_values=np.nan) for r in done])
        for c in names
    }
    return Batch(loop, duration, columns, measured, diverged_at, signals)


__all__ = ["Batch", "run_batch"]
