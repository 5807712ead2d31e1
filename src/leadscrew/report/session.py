"""A session as one HTML page: what was done with old and new values, the error under each setting, the run's lines."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew import resolve
from leadscrew.figures.formats import integrated
from leadscrew.figures.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION
from leadscrew.figures.table import as_typed, number, unit
from leadscrew.kernel.parameters import ParameterSpec
from leadscrew.operate.change import Change
from leadscrew.operate.operated import Event, Rerun, Session
from leadscrew.operate.profile import Profile
from leadscrew.report.page import page, paragraphs, picture, table
from leadscrew.report.report import TextTable
from leadscrew.util.atomic import atomic_write
from leadscrew.util.errors import LeadscrewError

if TYPE_CHECKING:
    from leadscrew.figures.figure import Figure
    from leadscrew.operate.operated import Operated


@dataclass
class Stretch:
    """The run between two changes."""

    first: int
    """Its first period."""
    events: list[int]
    """Numbers, from 1 on, of the changes that it begins with; none for the start."""
    rows: int = 0
    squares: np.ndarray = field(default_factory=lambda: np.zeros(0))
    largest: np.ndarray = field(default_factory=lambda: np.zeros(0))

    @property
    def rms(self) -> np.ndarray:
        """Of each error."""
        return np.sqrt(self.squares / max(1, self.rows))

    def add(self, errors: np.ndarray) -> None:
        """Further rows of the errors, in their order of time."""
        if not self.rows:
            self.squares, self.largest = np.zeros(errors.shape[1]), np.zeros(errors.shape[1])
        self.rows += len(errors)
        self.squares = self.squares + np.square(errors).sum(axis=0)
        self.largest = np.maximum(self.largest, np.abs(errors).max(axis=0, initial=0.0))


@dataclass(frozen=True)
class Judged:
    """An error that the report gives figures of."""

    column: str
    label: str
    factor: float
    unit: str


def judged(profile: Profile, columns: list[str], units: dict[str, str]) -> list[Judged]:
    """The true errors in the units in which the profile shows them, else in those of the loop."""
    shown = {t.signal: t for plot in profile.plots for t in plot.traces}
    found = []
    for column in columns:
        own = column.removeprefix("y.")
        if own == "true_error" or own.startswith("true_error."):
            trace = shown.get(own) or shown.get(own.replace("true_error", "error", 1))
            axis = "Y: " if column != own else ""
            label = f"{axis}{own.replace('_', ' ')}"
            found.append(
                Judged(column, label, trace.factor, trace.unit) if trace else Judged(column, label, 1.0, units[column])
            )
    return found


class Envelope:
    """The smallest and the largest value of each column in every bucket of periods: what a plot can show."""

    def __init__(self, columns: list[str], periods: int, period_s: float, buckets: int = 1500) -> None:
        self.columns = columns
        self.size = max(1, math.ceil(periods / buckets))
        self.period_s = period_s
        self._left = np.zeros((0, len(columns)))
        self._low: list[np.ndarray] = []
        self._high: list[np.ndarray] = []

    def feed(self, columns: list[str], rows: np.ndarray) -> None:
        """Further rows; a column that they do not have is NaN."""
        at = {c: i for i, c in enumerate(columns)}
        wanted = np.full((len(rows), len(self.columns)), np.nan)
        for i, c in enumerate(self.columns):
            if c in at:
                wanted[:, i] = rows[:, at[c]]
        whole = np.concatenate([self._left, wanted])
        n = len(whole) // self.size
        self._keep(whole[: n * self.size].reshape(n, self.size, len(self.columns)))
        self._left = whole[n * self.size :]

    def _keep(self, buckets: np.ndarray) -> None:
        if buckets.size:
            self._low.append(buckets.min(axis=1))
            self._high.append(buckets.max(axis=1))

    def lines(self) -> tuple[np.ndarray, np.ndarray]:
        """Times, and the columns at them: two values a bucket unless it is one period."""
        if len(self._left):
            self._keep(self._left[None])
            self._left = self._left[:0]
        if not self._low:
            return np.zeros(0), np.zeros((0, len(self.columns)))
        low, high = np.concatenate(self._low), np.concatenate(self._high)
        t = np.arange(len(low)) * self.size * self.period_s
        if self.size == 1:
            return t, low
        return np.repeat(t, 2), np.stack([low, high], axis=1).reshape(2 * len(low), -1)


ROLES = {"command": BLACK, "feedback": SKY, "actual": BLUE, "error": VERMILION, "output": GREEN, "disturbance": ORANGE,
         "other": PURPLE}  # fmt: skip

NUMBERED = 40
"""Changes that the picture numbers at most."""
APART = 0.03
"""Part of the run by which two numbers in the picture are apart at least; those of closer changes stand as one."""
LAST = ("error", "actual", "command")
"""Drawn over the others, in this order."""


class _Account:
    """What the report needs of the run, gathered while the session runs again."""

    def __init__(self, session: Session) -> None:
        self.session = session
        self.changes: list[tuple[Event, Change]] = []
        starts = sorted({0, *(e.period for e in session.events if e.period < session.periods)})
        self.stretches = [Stretch(p, [i + 1 for i, e in enumerate(session.events) if e.period == p]) for p in starts]
        self.errors: list[Judged] = []
        self.envelope: Envelope | None = None
        self.sheets: dict[str, dict[str, ParameterSpec]] = {}
        """Data sheets of what could be set, by the controller that ran."""
        self.done = 0

    def look(self, operated: Operated, rows: np.ndarray) -> None:
        """Further rows."""
        self.sheets.setdefault(operated.controller, operated.sheet)
        if self.envelope is None:
            self.errors = judged(operated.profile, operated.columns, operated.units)
            signals = [t.signal for p in operated.profile.plots for t in p.traces]
            columns = list(dict.fromkeys([*signals, *(f"y.{s}" for s in signals if f"y.{s}" in operated.columns)]))
            self.envelope = Envelope(columns, self.session.periods, operated.period_s)
        self.envelope.feed(operated.columns, rows)
        at = {c: i for i, c in enumerate(operated.columns)}
        errors = np.stack([rows[:, at[e.column]] * e.factor for e in self.errors], axis=1) if self.errors else None
        if errors is not None:
            for stretch, following in zip(self.stretches, [*self.stretches[1:], None], strict=True):
                low = max(0, stretch.first - self.done)
                high = len(rows) if following is None else min(len(rows), following.first - self.done)
                if low < high:
                    stretch.add(errors[low:high])
        self.done += len(rows)

    def told(self, event: Event, change: Change) -> None:
        """A change that was made."""
        self.changes.append((event, change))


def html(session: Session, title: str = "") -> str:
    """The page; the session is run again for it.

    Raises:
        LeadscrewError: it cannot be run again.
    """
    account = _Account(session)
    rerun = session.run(record=(), look=account.look, on_event=account.told)
    operated, start = rerun.operated, session.start
    named = " ".join(str(x) for x in (start.study, start.controller, start.scenario) if x)
    parts = [
        *paragraphs(_opening(session, rerun)),
        _at_start(start.changes, operated),
        _done(account, operated),
        _figures(account, operated.period_s),
        picture(_drawn(account, operated), "session", "the run's signals against time", _caption(account))
        if account.done
        else "",
    ]
    return page(title or f"Session: {named}", parts)


def write(session: Session, path: str | Path, title: str = "") -> None:
    """Writes the page.

    Raises:
        DataError: it cannot be written.
    """
    atomic_write(html(session, title), path)


def _opening(session: Session, rerun: Rerun) -> list[str]:
    operated, start = rerun.operated, session.start
    seed = operated.loop.seed
    by = integrated(operated.loop.integration)
    lines = [
        f"{_machine(operated)}; this page was made on {datetime.now(UTC):%Y-%m-%d at %H:%M} UTC",
        f"A simulated machine was operated for {session.periods * operated.period_s:g} s: {session.periods} periods of "
        f"{operated.period_s:g} s{', two axes on a circle' if start.circle else ''}, seed {seed}"
        + (f", plant integrated by {by}" if by else ""),
        f"Digest of all signals: `{session.digest}`",
        "For this page the session was run again: "
        + ("every signal has the same bits" if rerun.identical else f"NOT identical, {rerun.difference}"),
    ]
    return [*lines, f"The loop was lost: {operated.diverged}"] if operated.diverged else lines


def _machine(operated: Operated) -> str:
    """The study's title, or what a loop of one's own is called."""
    try:
        return resolve.study(operated.start.study).title
    except LeadscrewError:
        return operated.loop.name


def _at_start(changes: Mapping[str, Any], operated: Operated) -> str:
    sheet = {**operated.sheet, **operated.at_start}
    rows = [(k, as_typed(v), unit(sheet[k].unit) if k in sheet else "") for k, v in changes.items()]
    heads = ("parameter", "value", "unit")
    return table(TextTable(heads, rows, [False, True, False], title="Changed at the start")) if rows else ""


def _done(account: _Account, operated: Operated) -> str:
    rows = []
    sheet = {k: e for known in (*account.sheets.values(), operated.sheet) for k, e in known.items()}
    for i, (event, change) in enumerate(account.changes):
        new = change.new if change.new else dict(event.changes)
        for j, key in enumerate(dict.fromkeys([*change.old, *new])):
            entry = sheet.get(key, sheet.get(key.removeprefix("x.")))
            rows.append(
                (
                    str(i + 1) if j == 0 else "",
                    f"{event.period * operated.period_s:g}",
                    key,
                    as_typed(change.old.get(key)),
                    as_typed(new.get(key)),
                    unit(entry.unit) if entry is not None else "",
                    event.how,
                    event.why or "hand",
                )
            )
    columns = ("no.", "t (s)", "parameter", "before", "after", "unit", "how", "by")
    if not rows:
        return "<p>Nothing was changed.</p>"
    return table(TextTable(columns, rows, [True, True, False, True, True, False, False, False], title="What was done"))


def _figures(account: _Account, period_s: float) -> str:
    rows, columns = [], ["after no.", "from (s)", "to (s)"]
    for e in account.errors:
        of = f" ({unit(e.unit)})" if e.unit else ""
        columns += [f"{e.label}: rms{of}", f"largest{of}"]
    for stretch in account.stretches:
        if stretch.rows:
            first = stretch.first * period_s
            after = ", ".join(map(str, stretch.events)) or "start"
            figures = [number(float(x)) for pair in zip(stretch.rms, stretch.largest, strict=True) for x in pair]
            rows.append((after, f"{first:g}", f"{first + stretch.rows * period_s:g}", *figures))
    right = [False, *[True] * (len(columns) - 1)]
    shown = TextTable(columns, rows, right, title="Error under each setting")
    return table(shown) if rows and account.errors else ""


def _caption(account: _Account) -> str:
    assert account.envelope is not None
    thinned = (
        f"; smallest and largest value of every {account.envelope.size} periods" if account.envelope.size > 1 else ""
    )
    return f"The run; dashed lines: the changes by their number{thinned}."


def _drawn(account: _Account, operated: Operated) -> Figure:
    from leadscrew.figures.figure import Figure

    assert account.envelope is not None
    t, lines = account.envelope.lines()
    at = {c: i for i, c in enumerate(account.envelope.columns)}
    plots = operated.profile.plots
    figure = Figure(figsize=(8.0, 0.6 + 1.9 * len(plots)), layout="constrained")
    axes = figure.subplots(len(plots), 1, sharex=True, squeeze=False)[:, 0]
    for ax, plot in zip(axes, plots, strict=True):
        for trace in sorted(plot.traces, key=lambda t: LAST.index(t.role) if t.role in LAST else -1):
            for column, style in ((trace.signal, "-"), (f"y.{trace.signal}", "--")):
                if column in at:
                    label = trace.label if style == "-" else f"Y: {trace.label}"
                    style = ":" if trace.role == "command" else style
                    ax.plot(t, trace.factor * lines[:, at[column]], style, color=ROLES[trace.role], label=label, lw=0.9)
        for event, _ in account.changes:
            ax.axvline(event.period * operated.period_s, color="0.6", linestyle="--", linewidth=0.7)
        ax.set_ylabel(f"{plot.title} ({plot.unit})" if plot.unit else plot.title, fontsize="small")
        ax.legend(frameon=False, fontsize="x-small", loc="center left", bbox_to_anchor=(1.0, 0.5))
        ax.grid(color="0.92", linewidth=0.6)
        ax.margins(x=0)
    for period, text in _numbered([e.period for e, _ in account.changes], account.session.periods):
        axes[0].annotate(text, (period * operated.period_s, 1.0), xycoords=("data", "axes fraction"),
                         fontsize="x-small", ha="center", va="bottom")  # fmt: skip
    axes[-1].set_xlabel("time (s)")
    figure.align_ylabels(axes)
    return figure


def _numbered(periods: list[int], whole: int) -> list[tuple[int, str]]:
    """Where the changes have their numbers in the picture: first and last number of those that come close together."""
    groups: list[list[int]] = []
    for i, period in enumerate(periods if len(periods) <= NUMBERED else []):
        if groups and period - periods[groups[-1][0]] < APART * whole:
            groups[-1].append(i)
        else:
            groups.append([i])
    return [(periods[g[0]], f"{g[0] + 1}" if len(g) == 1 else f"{g[0] + 1}-{g[-1] + 1}") for g in groups]
