"""Runs a saved run again and compares it bit for bit."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew import names, userfile
from leadscrew._version import __version__
from leadscrew.experiment import Experiment
from leadscrew.kernel.engines import without_numba
from leadscrew.kernel.parameters import renamed
from leadscrew.kernel.run import load
from leadscrew.util.errors import CodeNotTrusted, DataError, LeadscrewError

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop


@dataclass(frozen=True)
class Replay:
    """What came of it."""

    folder: Path
    identical: bool
    difference: str
    """Where the two part first, in words; empty where they do not."""
    causes: tuple[str, ...]
    """What is known to differ from when the run was saved: versions, platform, source of the blocks."""
    rows: int
    signals: tuple[str, ...]
    wall_s: float
    written_by: str
    """The version of Leadscrew that wrote the run; empty where its manifest does not say it."""


def versions(what: str, written_by: str) -> str:
    """Which version of Leadscrew wrote a run or session, and which one replayed it: one sentence."""
    writer = f"Leadscrew {written_by}" if written_by else "an unknown version of Leadscrew"
    return f"the {what} was written by {writer} and replayed by Leadscrew {__version__}"


def replay(folder: str | Path) -> Replay:
    """Builds the loop of a run folder again from its manifest, runs it, compares every signal bit for bit.

    Raises:
        DataError: no run folder, or its manifest does not say how to build the loop.
        CodeNotTrusted: its manifest names Python that may not run, see :mod:`leadscrew.userfile`.
    """
    manifest, saved = load(folder)
    path = Path(folder)
    path = path.parent if path.name == "run.json" else path
    loop = rebuilt(manifest, str(path))
    try:
        number, every, engine = (
            int(manifest["replicate"]),
            int(manifest["every"]),
            without_numba(str(manifest["engine"])),
        )
        duration, start = float(manifest["duration_s"]), float(manifest["start_s"])
        record = [name for name in manifest["record"] if name != "time"]
    except (KeyError, TypeError, ValueError) as error:
        raise _malformed(str(path), error) from None
    if start != 0.0:
        raise DataError(f"{path} is a part of a live loop, from t = {start:g} s on; only runs from 0 can be replayed")
    held = max(map(len, saved.values()), default=0)
    rows = -(-loop.periods(duration) // every) if saved and every > 0 else 0
    if rows > held + 1:
        raise DataError(f"{path}: signals.parquet has {held} rows, but a run of {duration:g} s would have {rows}")
    with warnings.catch_warnings(), _of(str(path), manifest["origin"]):
        warnings.simplefilter("ignore")
        run = loop.run(duration, record=record, every=every if saved else 0, engine=engine, replicate=number)
    difference = first_difference(saved, run.signals) or _other_end(manifest, run)
    return Replay(
        path, not difference, difference, (*_causes(manifest, loop.manifest(engine)), *_files(manifest["origin"])),
        len(saved.get("time", ())), tuple(saved), run.wall_s, str(manifest.get("leadscrew") or ""),
    )  # fmt: skip


def rebuilt(manifest: Mapping[str, Any], where: str) -> Loop:
    """The loop of a manifest: built as its origin says, then with every parameter as saved."""
    origin = manifest.get("origin")
    if not isinstance(origin, dict) or not origin.get("study"):
        raise DataError(
            f"{where}/run.json does not say how to build its loop (origin is empty): it was made in Python, "
            "not by leadscrew simulate or run"
        )
    kinds = {
        "study": str, "controller": str | None, "scenario": str | None, "changes": dict | None, "substeps": int | None,
    }  # fmt: skip
    for key, kind in kinds.items():
        if not isinstance(origin.get(key), kind):
            what = "a whole number" if key == "substeps" else "a name, or a table"
            raise DataError(f"{where}/run.json: origin.{key} = {str(origin[key])[:40]!r}: expected {what}")
    controller = origin.get("controller")
    try:
        experiment = Experiment(
            names.FromFile(origin["study"], f"{where}/run.json"),
            None if controller is None else names.FromFile(controller, f"{where}/run.json"),
            origin.get("scenario"), origin.get("changes") or {}, substeps=origin.get("substeps"),
        )  # fmt: skip
        saved, seed, bound = dict(manifest["parameters"]), manifest["seed"], manifest["bound"]
    except (KeyError, TypeError, ValueError) as error:
        raise _malformed(where, error) from None
    with _of(where, origin):
        loop = experiment.loop()
        now = loop.parameters
        # Before there was last_percent, a window without from_time was the whole run.
        whole = {f"{k.removesuffix('.from_time')}.last_percent": 100.0 for k in saved if k.endswith(".from_time")}
        saved = {k: v for k, v in whole.items() if k in now} | renamed(saved, now)
        changed = {k: v for k, v in saved.items() if k not in now or not np.array_equal(now[k], v)}
        loop = loop.using(changed, seed=seed, **({} if bound is None else {"bound": bound}))
    loop.origin = origin
    return loop


@contextmanager
def _of(where: str, origin: Mapping[str, Any]) -> Iterator[None]:
    """Errors say whose loop cannot be built, and which of its files have changed."""
    try:
        yield
    except CodeNotTrusted:
        raise
    except LeadscrewError as error:
        raise type(error)("; ".join([f"{where}/run.json: {error}", *_files(origin)])) from error


def _malformed(where: str, error: Exception) -> DataError:
    return DataError(f"{where}/run.json: is not a whole manifest ({type(error).__name__}: {error})")


def first_difference(saved: Mapping[str, np.ndarray], now: Mapping[str, np.ndarray]) -> str:
    """The earliest row in which two sets of signals differ in any bit, in words; empty where they are the same."""
    if list(saved) != list(now):
        odd = sorted(set(saved) ^ set(now)) or ["their order"]
        return f"the recorded signals differ: {', '.join(odd)}"
    found: tuple[int, str] | None = None
    for name, values in saved.items():
        a, b = (np.ascontiguousarray(x, dtype=np.float64).view(np.uint64) for x in (values, now[name]))
        n = min(len(a), len(b))
        rows = np.flatnonzero(a[:n] != b[:n])
        if rows.size and (found is None or rows[0] < found[0]):
            found = (int(rows[0]), name)
    if found is not None:
        row, name = found
        time = f", t = {saved['time'][row]:g} s" if "time" in saved else ""
        return f"{name} at row {row}{time}: saved {float(saved[name][row])!r}, now {float(now[name][row])!r}"
    lengths = {len(v) for v in saved.values()}, {len(v) for v in now.values()}
    return "" if lengths[0] == lengths[1] else f"saved {max(lengths[0])} rows, now {max(lengths[1])}"


def _other_end(manifest: Mapping[str, Any], run: Any) -> str:
    """How the two runs end differently, where no signal shows it."""
    if (manifest.get("diverged") is None) != (run.diverged is None):
        return f"saved {'without' if manifest.get('diverged') is None else 'with'} divergence, now the other way round"
    metrics = manifest.get("metrics") or {}
    for name, value in run.metrics.items():
        now = value if np.isfinite(value) else None
        older = now is None and "metrics_without_value" not in manifest  # that version gave some of them a number
        if name in metrics and metrics[name] != now and not older:
            return f"metric {name}: saved {metrics[name]!r}, now {now!r}"
    return ""


def _causes(saved: Mapping[str, Any], now: Mapping[str, Any]) -> tuple[str, ...]:
    names = ["module", "period_s", "sample_s", "substeps", "method", "computation_delay_s",
             "transport_delay_s", "blocks", "platform", "versions"]  # fmt: skip
    if "rtol" in saved:
        names += ["rtol", "atol"]
    elif saved.get("period_s", 0) is None:  # older manifests name a method that a continuous loop did not use
        names = [n for n in names if n not in ("substeps", "method")]
    return tuple(f"{n}: saved {saved.get(n)}, now {now[n]}" for n in names if saved.get(n) != now[n])


def _files(origin: Mapping[str, Any]) -> tuple[str, ...]:
    """The files of fuzzy systems that are others than when the run was saved."""
    files = origin.get("files")
    if not isinstance(files, dict):
        return ()
    return tuple(f"{p} is not the file that it was" for p, was in files.items() if userfile.digest(Path(p)) != was)
