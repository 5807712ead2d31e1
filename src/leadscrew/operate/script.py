"""A session as a Python script of the public interface: it builds the machine, does what was done, and compares."""

from __future__ import annotations

from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any

from leadscrew._version import __version__
from leadscrew.operate.operated import MARK, Event, Session, Start
from leadscrew.util.atomic import atomic_write
from leadscrew.util.escape import python_docstring

WIDEST = 110
"""Characters of an event on one line."""

_HEAD = '''"""{title}: what was done to the running machine, done again.

Written by Leadscrew {version}. Run it with `python {name}`: it prints "identical" and ends with code 0 if all signals
are the same bits as in that run, else it says where they part first and ends with code 1.
"""

import sys

from leadscrew.operate import Event, Operated, Start

# one control period is {period:g} s; a period in an event is the number of periods that were done when it took effect
start = {start}
events = [
{events}]
periods = {periods}
digest = "{digest}"

machine = Operated(start)
for event in events:
    # advance() would give the rows of all signals; advance_to() only runs on
    machine.advance_to(event.period)
    if machine.digest[:{mark}] != event.mark:
        sys.exit(f"not identical: the signals part before t = {{event.period * machine.period_s:g}} s; next: {{event}}")
    machine.apply(event)  # as by hand: machine.set(...), machine.switch(...), with the ramp of that run
machine.advance_to(periods)

if machine.digest != digest:
    sys.exit(f"not identical: the signals part after the last event; digest {{machine.digest}}, expected {{digest}}")
print(f"identical: {{machine.period}} periods of {{len(machine.columns)}} signals, bit for bit")
'''


def text(session: Session, period_s: float, name: str = "session.py") -> str:
    """The script; ``period_s``: the control period, for its comments."""
    start = session.start
    title = " ".join(str(x) for x in (start.study, start.controller, start.scenario) if x)
    return _HEAD.format(
        title=python_docstring(title),
        version=__version__,
        name=python_docstring(name),
        period=period_s,
        start=_call(start, "\n    ", ",\n    ", ",\n"),
        events="".join(f"    # t = {e.period * period_s:g} s\n    {_event(e)},\n" for e in session.events),
        periods=session.periods,
        digest=session.digest,
        mark=MARK,
    )


def write(session: Session, period_s: float, path: str | Path) -> None:
    """Writes the script.

    Raises:
        DataError: it cannot be written.
    """
    atomic_write(text(session, period_s, Path(path).name), path)


def _event(event: Event) -> str:
    short = _call(event, "", ", ", "")
    return short if len(short) < WIDEST else _call(event, "\n        ", ",\n        ", ",\n    ")


def _call(value: Start | Event, before: str, between: str, after: str) -> str:
    """The expression that builds it, without what is not said."""
    said = {f.name: (getattr(value, f.name), {} if f.default is MISSING else f.default) for f in fields(value)}
    args = [f"{k}={_literal(v)}" for k, (v, default) in said.items() if v != default or k == "period"]
    return f"{type(value).__name__}({before}{between.join(args)}{after})"


def _literal(value: Any) -> str:
    if isinstance(value, float) and value in (float("inf"), float("-inf")):
        return f'float("{value}")'
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_literal, value))}]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{k!r}: {_literal(v)}" for k, v in value.items()) + "}"
    return repr(value)


__all__ = ["text", "write"]
