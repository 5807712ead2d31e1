"""What a run gives: signals, metrics, and the manifest that says how to get the same bits again."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.kernel.layout import is_branch
from leadscrew.kernel.linker import LIMITS
from leadscrew.kernel.notes import Note
from leadscrew.kernel.parameters import nearest
from leadscrew.kernel.views import view
from leadscrew.util.atomic import atomic_folder
from leadscrew.util.errors import DataError, Diverged, NameUnknown, entry_point
from leadscrew.util.escape import html

if TYPE_CHECKING:
    from pandas import DataFrame

    from leadscrew.figures.figure import Figure
    from leadscrew.kernel.loop import Loop


@entry_point
class Metrics(dict[str, float]):
    """Metrics by name, as items or attributes."""

    def __getattr__(self, name: str) -> float:
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f"there is no metric {name!r}{nearest(name, list(self))}") from None


@dataclass(frozen=True)
class Divergence:
    """Where a loop was lost."""

    time: float
    period: int
    state: str
    value: float
    bound: float | None = None
    place: str = ""
    """File, line and division that lost it, where the Python engine saw one."""

    def __str__(self) -> str:
        what = "is not finite"
        if self.bound is not None:
            what = f"left its bound of {self.bound:g}"
        if self.bound == LIMITS["int"]:
            what = "is beyond 2^53, up to which a state keeps whole numbers exactly"
        place = f"; first lost at {self.place}" if self.place else ""
        return f"diverged at t = {self.time:g} s (period {self.period}): {self.state} {what}{place}"


def recorded(signals: dict[str, np.ndarray], name: str) -> np.ndarray:
    """A recorded signal; a NamedTuple signal's own name gives its first number.

    Raises:
        NameUnknown: it was not recorded; names the nearest.
    """
    if name in signals:
        return signals[name]
    for key, value in signals.items():
        if key.startswith(f"{name}."):
            return value
    raise NameUnknown(f"{name!r} was not recorded{nearest(name, list(signals))}")


@entry_point
@dataclass(frozen=True)
class Run:
    """The result of one run."""

    loop: Loop
    signals: dict[str, np.ndarray]
    metrics: Metrics
    diverged: Divergence | None
    engine: str
    wall_s: float
    duration: float
    start: float = 0.0
    replicate: int = 0
    """Which stream of noise it had."""
    every: int = 1
    notes: tuple[Note, ...] = ()
    """What the metrics do not show: a loop that moves away from its target, fuzzy inputs outside of their universes."""
    explained: Callable[[list[str]], dict[str, str]] | None = field(default=None, repr=False, compare=False)
    """Takes names of metrics and gives the reason why each has no value."""

    @cached_property
    def metrics_without_value(self) -> dict[str, str]:
        """Why a metric is NaN, by its name."""
        lost = [k for k, v in self.metrics.items() if np.isnan(v)]
        if self.diverged is not None:
            return dict.fromkeys(lost, f"the run diverged at t = {self.diverged.time:g} s")
        return self.explained(lost) if lost and self.explained is not None else {}

    @property
    def time(self) -> np.ndarray:
        """Seconds since the start, one for each recorded row."""
        return self.signals["time"]

    def __getitem__(self, name: str) -> np.ndarray:
        """A recorded signal; a NamedTuple signal's own name gives its first number."""
        return recorded(self.signals, name)

    def signal(self, name: str, example: Any) -> Any:
        """The last value of a signal in its own type."""
        if not is_branch(example):
            return float(self.signals[name][-1])
        return type(example)(*(self.signal(f"{name}.{f}", v) for f, v in zip(example._fields, example, strict=True)))

    def check(self) -> Run:
        """The run, if it did not diverge.

        Raises:
            Diverged: with this run inside.
        """
        if self.diverged is not None:
            raise Diverged(f"{self.loop.name} {self.diverged}", self)
        return self

    @property
    def manifest(self) -> dict[str, Any]:
        """Everything needed to run it again."""
        return {
            **self.loop.manifest(self.engine),
            "replicate": self.replicate,
            "start_s": self.start,
            "duration_s": self.duration,
            "every": self.every,
            "record": list(self.signals),
            "wall_s": self.wall_s,
            "diverged": None
            if self.diverged is None
            else {**self.diverged.__dict__, "value": repr(self.diverged.value)},
            "metrics": {k: v if np.isfinite(v) else None for k, v in self.metrics.items()},
            "notes": [n._asdict() for n in self.notes],
            "metrics_without_value": self.metrics_without_value,
        }

    def save(self, folder: str | Path) -> Path:
        """Writes ``signals.parquet`` and ``run.json`` into a folder that appears only when complete.

        Raises:
            DataError: the folder exists already and is not empty, or cannot be written.
        """
        import pyarrow as pa
        import pyarrow.parquet as pq

        with atomic_folder(folder) as beside:
            table = pa.table({k: pa.array(v) for k, v in self.signals.items()})
            pq.write_table(table, beside / "signals.parquet")
            (beside / "run.json").write_text(
                json.dumps(strict(self.manifest), indent=1, allow_nan=False), encoding="utf-8"
            )
        return Path(folder)

    def to_dataframe(self) -> DataFrame:
        """The signals as a pandas ``DataFrame``, a column each, by time.

        Raises:
            ImportError: pandas is not installed.
        """
        try:
            import pandas as pd
        except ImportError as error:
            raise ImportError("to_dataframe() needs pandas: pip install pandas, or leadscrew[pandas]") from error

        rows = {name: values for name, values in self.signals.items() if name != "time"}
        return pd.DataFrame(rows, index=pd.Index(self.time, name="time"))

    def plot(self, signals: str | Sequence[str] | None = None) -> Figure:
        """A Matplotlib figure: command, true output, error and output against time, or a panel for each of ``signals``.

        A notebook shows it as it is; ``leadscrew.plot_runs`` draws several runs over one another.
        """
        return view("run_figure")(self, signals)

    def _repr_html_(self) -> str:
        cells = {k: html(self.metrics_without_value.get(k, f"{v:.6g}")) for k, v in self.metrics.items()}
        rows = "".join(f"<tr><td>{html(k)}</td><td>{v}</td></tr>" for k, v in cells.items())
        state = f"<p><b>{html(str(self.diverged))}</b></p>" if self.diverged else ""
        notes = "".join(f"<p>{html(n.message)}</p>" for n in self.notes)
        return f"<h4>{html(self.loop.name)}: {self.duration:g} s</h4>{state}<table>{rows}</table>{notes}"

    def __repr__(self) -> str:
        metrics = ", ".join(f"{k}={v:.4g}" for k, v in self.metrics.items())
        return f"<Run {self.loop.name} {self.duration:g} s{f' {self.diverged}' if self.diverged else ''}: {metrics}>"


def strict(value: Any) -> Any:
    """A value that JSON can hold: numbers that are not finite become their names."""
    if isinstance(value, dict):
        return {k: strict(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [strict(v) for v in value]
    return repr(value) if isinstance(value, float) and not np.isfinite(value) else value


MANIFEST: dict[str, Any] = {
    "parameters": dict, "origin": dict | None, "metrics": dict | None, "metrics_without_value": dict | None,
    "blocks": dict, "record": list, "replicate": int, "every": int, "engine": str, "duration_s": float | int,
    "start_s": float | int, "seed": int | None, "bound": float | int | str | None,
}  # fmt: skip
"""What stands in the manifest of a run, where something does."""


@entry_point
def load(folder: str | Path) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Manifest and signals of a saved run.

    Raises:
        DataError: no run folder, or an incomplete or foreign one.
    """
    from leadscrew.util import parquet, reading

    path = Path(folder)
    path = path.parent if path.name == "run.json" else path
    if path.name.startswith(".") and path.name.endswith(".partial"):
        raise DataError(f"{path} is a run that was cut off while it was being written")
    for file in ("run.json", "signals.parquet"):
        if not (path / file).is_file():
            raise DataError(f"{path} is not a run folder: {file} is missing")
    manifest = reading.json_object(path / "run.json")
    if manifest.get("schema_version") != 1:
        raise DataError(f"{path}/run.json: schema_version = {manifest.get('schema_version')!r}; this version reads 1")
    if "replicate" not in manifest and "run" in manifest:  # its name in 0.1.0
        manifest["replicate"] = manifest.pop("run")
    for key, kind in MANIFEST.items():
        if key in manifest and not isinstance(manifest[key], kind):
            raise DataError(f"{path}/run.json: is not a whole manifest: {key} = {str(manifest[key])[:40]!r}")
    named = {"inf": np.inf, "-inf": -np.inf, "nan": np.nan}
    known = manifest.get("parameters") or {}
    manifest["parameters"] = {k: named.get(v, v) if isinstance(v, str) else v for k, v in known.items()}
    return manifest, parquet.read(path / "signals.parquet").numbers
