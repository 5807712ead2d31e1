"""A session as a TOML file that a person can read, keep under version control and run again.

::

    schema_version = 2
    kind = "session"
    leadscrew = "0.9.0"
    periods = 5000
    digest = "9f2b..."                  # SHA-256 of all signals

    [start]
    study = "vud_lathe"
    controller = "corrected.vud_beta_e"
    scenario = "sequence"

    [[event]]
    period = 1200                       # periods done when it took effect
    do = "set"
    how = "ramped"
    over = 100
    before = "02d6..."                  # first digits of the checksum of the rows before it; [marks]: after N periods

    [event.set]
    controller.output_full_scale_v = 9.0
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from leadscrew import legacy, names
from leadscrew._version import __version__
from leadscrew.experiment_file import Engine
from leadscrew.file_schema import Name, Table, validated
from leadscrew.operate.operated import Event, Rerun, Session, Start
from leadscrew.toml_file import flat
from leadscrew.toml_file import read as table_of
from leadscrew.toml_file import text as toml
from leadscrew.util.atomic import atomic_folder, atomic_write
from leadscrew.util.errors import DataError, ValueRefused

KIND = "session"
Count = Annotated[int, Field(ge=0, lt=2**53)]


class StartTable(Table):
    """What the machine was."""

    study: Name
    controller: str | None = None
    scenario: str | None = None
    seed: Count | None = None
    engine: Engine | None = None
    circle: bool = False
    changes: dict[str, Any] = Field(default_factory=dict, alias="set")


class EventTable(Table):
    """What was done to it."""

    period: Count
    do: Literal["set", "switch"]
    controller: str = ""
    how: Literal["aligned", "ramped", "at once", "not bumpless"]
    over: Count = 0
    by: str = ""
    why: str = ""
    compare: bool = True
    before: str = ""
    changes: dict[str, Any] = Field(default_factory=dict, alias="set")


class SessionFile(Table):
    """The keys of the file."""

    schema_version: Literal[1, 2]
    kind: Literal["session"]
    leadscrew: str = ""
    periods: Count
    digest: Annotated[str, Field(pattern="^[0-9a-f]{64}$")]
    marks: dict[Annotated[str, Field(pattern="^[0-9]{1,16}$")], str] = Field(default_factory=dict)
    start: StartTable
    event: list[EventTable] = Field(default_factory=list)
    files: dict[str, str] = Field(default_factory=dict)


def text(session: Session) -> str:
    """The session as the text of its file."""
    start = session.start
    head = {
        "schema_version": legacy.CURRENT,
        "kind": KIND,
        "leadscrew": __version__,
        "periods": session.periods,
        "digest": session.digest,
        "start": {
            "study": start.study,
            "controller": start.controller,
            "scenario": start.scenario,
            "seed": start.seed,
            "engine": start.engine,
            "circle": start.circle or None,
            "set": dict(start.changes),
        },
        "files": dict(start.files),
        "marks": {str(k): v for k, v in session.marks.items()},
    }
    return "\n".join([toml(head), *map(_event, session.events)])


def _event(event: Event) -> str:
    table = {
        "period": event.period,
        "do": event.do,
        "controller": event.controller or None,
        "how": event.how,
        "over": event.over or None,
        "by": event.by or None,
        "why": event.why or None,
        "compare": None if event.compare else False,
        "before": event.mark or None,
        "set": dict(event.changes),
    }
    return toml({"event": table}).replace("[event]", "[[event]]", 1)


def write(session: Session, path: str | Path) -> None:
    """Writes the file.

    Raises:
        DataError: it cannot be written.
    """
    atomic_write(text(session), path)


def read(path: str | Path) -> Session:
    """A session from its file; files that it names are looked for beside it.

    Nothing runs here. Python that it names runs by the rule of :mod:`leadscrew.userfile`, when the machine is built.

    Raises:
        DataError: no such file, bad TOML, no session, an unknown key or a value of the wrong type; names file and key.
    """
    where = Path(path)
    table = table_of(where)
    if table.get("kind") != KIND:
        said = f"its kind is {table['kind']!r}" if "kind" in table else "it has no kind"
        raise DataError(f"{where}: is not a session: {said}, expected kind = {KIND!r}")
    found = validated(SessionFile, table, where)
    events = tuple(_event_of(e, where, found.schema_version) for e in found.event)
    _in_order(events, found.periods, str(where))
    s = found.start
    start = Start(
        names.from_file(s.study, where), None if s.controller is None else names.from_file(s.controller, where),
        s.scenario, legacy.completed(found.schema_version, s.controller, dict(flat(s.changes)), "controller."),
        s.seed, s.engine, s.circle,
        {names.from_file(k, where): v for k, v in found.files.items()},
    )  # fmt: skip
    marks = {int(k): v for k, v in found.marks.items()}
    return Session(start, events, found.periods, found.digest, marks, found.leadscrew)


def _event_of(e: EventTable, where: Path, version: int) -> Event:
    changes = legacy.completed(version, e.controller, dict(flat(e.changes)), "controller.")
    return Event(
        e.period, e.do, changes, names.from_file(e.controller, where), e.over, e.how, e.by, e.why,
        compare=e.compare, mark=e.before,
    )  # fmt: skip


def _in_order(events: tuple[Event, ...], periods: int, where: str) -> None:
    """Events follow one another, up to the end; a switch names its controller."""
    last = 0
    for i, event in enumerate(events):
        if not last <= event.period <= periods:
            raise DataError(
                f"{where}: event {i + 1} has period = {event.period}; allowed are {last} to {periods}: events stand in "
                "the order of time"
            )
        if (event.do == "switch") != bool(event.controller):
            raise DataError(f"{where}: event {i + 1}: a switch, and nothing else, names a controller")
        last = event.period


def check_folder(folder: Path) -> None:
    """The folder can be written.

    Raises:
        ValueRefused: it is there and not empty.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise ValueRefused(f"--out {folder} exists already; choose another folder or remove it")


def write_folder(session: Session, rerun: Rerun, folder: Path) -> None:
    """Writes ``signals.parquet`` and ``session.toml``.

    Raises:
        DataError: it cannot be written.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    with atomic_folder(folder) as beside:
        pq.write_table(pa.table({k: pa.array(v) for k, v in rerun.signals.items()}), beside / "signals.parquet")
        write(session, beside / "session.toml")
