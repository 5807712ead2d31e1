"""The ``machine`` message: what a simulated machine is, how it is shown, and all that can be set."""

from __future__ import annotations

import math
from dataclasses import asdict
from functools import lru_cache
from pathlib import PurePath
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from leadscrew import catalogue, resolve
from leadscrew.kernel.parameters import nearest
from leadscrew.operate.profile import Profile
from leadscrew.panel.strict_json import plain
from leadscrew.util.errors import CodeNotTrusted, LeadscrewError, NameUnknown

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from leadscrew.kernel.parameters import ParameterSpec
    from leadscrew.operate.operated import Operated
    from leadscrew.panel.explanations import Explanations
    from leadscrew.study_data import Study

NOTICE = "Simulated machine: nothing moves."


@lru_cache(maxsize=8)
def study_of(name: str) -> Study | None:
    """The study of that name or file; None where the machine is a loop without one.

    Raises:
        CodeNotTrusted: a file names it, and it may not run.
    """
    try:
        return resolve.study(name)
    except CodeNotTrusted:
        raise
    except LeadscrewError:
        return None


def describe(
    operated: Operated, profile: Profile, whys: Explanations, named: Sequence[str], own: Sequence[str] = (),
    defaults: Mapping[str, Any] = MappingProxyType({}),
) -> dict[str, Any]:  # fmt: skip
    """The message, without the run's number; ``named`` and ``own``: studies and controllers of the command line;
    ``defaults``: of parameters that this run began with another value of.
    """
    start, study = operated.start, study_of(operated.start.study)
    scenarios, controllers = (study.scenarios, study.controllers) if study else ({}, {})
    scenario = scenarios.get(start.scenario or "")
    return {
        "kind": "machine",
        "simulated": True,
        "notice": NOTICE,
        "title": study.title if study else operated.loop.name,
        "paper": study.paper if study else "",
        "study": start.study,
        "controller": operated.controller or None,
        "scenario": start.scenario,
        "period_s": operated.period_s,
        "duration_s": scenario.duration_s if scenario else None,
        "seed": start.seed if start.seed is not None else operated.loop.seed,
        "circle": start.circle,
        "window_s": profile.window_s,
        "notes": profile.notes,
        "columns": [{"name": c, "unit": operated.units.get(c, "")} for c in operated.columns[1:]],
        "plots": [asdict(p) for p in profile.plots],
        "readouts": [asdict(r) for r in profile.readouts],
        "parameters": parameters(operated, defaults),
        "disturbances": [_disturbance(d) for d in profile.disturbances],
        "views": list(whys.views),
        "why_not_views": whys.reason,
        "can": {
            "start": True, "hold": True, "stop": True, "reset": True, "speed": True, "switch": bool(study),
            "compare": True, "circle": profile.circle,
        },
        "controllers": [
            *({"name": n, "bumpless": b.align is not None} for n, b in controllers.items()),
            *({"name": n, "bumpless": _bumpless(start.study, n)} for n in own if study and n not in controllers),
        ],
        "scenarios": [{"name": s.name, "doc": s.doc, "duration_s": s.duration_s} for s in scenarios.values()],
        "studies": [{"name": n, "title": _title(n)} for n in studies(named)],
    }  # fmt: skip


def studies(named: Sequence[str]) -> list[str]:
    """The machines that a page may choose: the catalogue's, and what the command line named."""
    known = catalogue.study_names()
    return [*known, *(n for n in named if n not in known)]


def _title(name: str) -> str:
    """What a page calls a machine: a study by its title, a machine file by its name without the folders."""
    return found.title if (found := study_of(name)) else PurePath(name).name


@lru_cache(maxsize=8)
def _bumpless(study: str, controller: str) -> bool:
    """Whether a controller that the command line named can take over without a jump of the output."""
    from leadscrew.resolve import controller as found

    known = study_of(study)
    try:
        return known is not None and found(known, controller).align is not None
    except LeadscrewError:
        return False


def check_names(study: str, controller: str | None, scenario: str | None, named: Sequence[str],
                own: Sequence[str]) -> None:  # fmt: skip
    """Passes names that a page may choose. No other reaches what would read, or run, a file of that name.

    Raises:
        NameUnknown: a machine, controller or scenario that neither the catalogue has nor the command line named.
    """
    _one_of("there is no machine", study, studies(named))
    found = study_of(study)
    if controller is not None:
        _one_of(f"{study} has no controller", controller, [*(found.controllers if found else ()), *own])
    if scenario is not None:
        _one_of(f"{study} has no scenario", scenario, list(found.scenarios) if found else [])


def _one_of(refusal: str, name: str, known: Sequence[str]) -> None:
    if name not in known:
        raise NameUnknown(f"{refusal} {name!r}{nearest(name, list(known))}")


def parameters(operated: Operated, defaults: Mapping[str, Any] = MappingProxyType({})) -> list[dict[str, Any]]:
    """Every parameter, settable in the run or not, with its value now."""
    values = operated.values()
    live = [_parameter(e, values.get(k, e.default), "") for k, e in operated.sheet.items()]
    still = [_parameter(e, values.get(k, e.default), operated.fixed[k]) for k, e in operated.at_start.items()]
    return [{**p, "default": plain(defaults.get(p["key"], p["default"]))} for p in (*live, *still)]


def _parameter(entry: ParameterSpec, value: Any, why_not: str) -> dict[str, Any]:
    group, _, label = entry.key.partition(".")
    return {
        "key": entry.key,
        "group": group,
        "label": label or entry.key,
        "type": entry.type,
        "unit": entry.unit,
        "doc": entry.doc,
        "choices": [] if entry.choice is None else list(entry.choice.names),
        "low": entry.above if math.isfinite(entry.above) else None,
        "high": entry.below if math.isfinite(entry.below) else None,
        "low_open": entry.above_open,
        "high_open": entry.below_open,
        "default": plain(entry.default),
        "value": plain(value),
        "live": not why_not,
        "why_not": why_not,
    }


def _disturbance(found: Any) -> dict[str, Any]:
    fields = [asdict(f) for f in found.fields]
    return {"name": found.name, "label": found.label, "doc": found.doc, "fields": fields}


__all__ = ["NOTICE", "check_names", "describe", "parameters", "studies", "study_of"]
