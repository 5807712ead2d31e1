"""The folder of a report: ``report.html``, ``report.json`` and the runs, there when complete and replaced at once."""

from __future__ import annotations

import base64
import json
import platform
import time
from collections.abc import Callable, Mapping
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from leadscrew.report.drawing import Draw, draw_all
from leadscrew.report.report import KIND, StudyReport
from leadscrew.util import reading
from leadscrew.util.atomic import replace_folder, replaceable_folder
from leadscrew.util.errors import DataError
from leadscrew.util.escape import file_name
from leadscrew.util.strict_json import strict

if TYPE_CHECKING:
    from leadscrew.kernel.run import Run


def claimable(folder: str | Path) -> Path:
    """The folder, if a report may be written there: it does not exist, is empty, or holds an older report.

    Raises:
        DataError: it holds something else, or cannot be written.
    """
    return replaceable_folder(folder, _is_report, "a report of ours")


def _is_report(folder: Path) -> bool:
    try:
        found = reading.json_object(folder / "report.json")
    except DataError:
        return False
    return found.get("kind") == KIND and "schema_version" in found


def manifest(wall_s: float) -> dict[str, Any]:
    """What the report was made with."""
    from leadscrew._version import __version__

    return {
        "leadscrew": __version__,
        "created": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
        "wall time of the study": f"{wall_s:.2f} s",
        "platform": f"{platform.system()} {platform.machine()}, Python {platform.python_version()}",
        **{p: version(p) for p in ("llvmlite", "numpy", "scipy")},
    }


def run_folder(key: str) -> str:
    """Where the run ``scenario/controller`` is saved, in the folder of the report."""
    scenario, _, controller = key.partition("/")
    return f"runs/{file_name(f'{scenario}__{controller}' if controller else scenario)}"


def put(
    report: StudyReport,
    folder: str | Path,
    *,
    wall_s: float,
    runs: Mapping[str, Run] | None = None,
    origin: str = "",
    draw: Draw = draw_all,
    progress: Callable[[str, float], None] = lambda what, done: None,
) -> Path:
    """Writes a report, and the runs behind it, beside ``folder``, then puts it in its place; gives its page.

    Raises:
        DataError: see :func:`claimable`; or the disk refuses.
    """
    from leadscrew.report import html

    target, saved = Path(folder), dict(runs or {})
    with replace_folder(target, _is_report, "a report of ours") as beside:
        for at, (key, run) in enumerate(saved.items()):
            progress(f"saving {key}", at / len(saved))
            scenario, _, controller = key.partition("/")
            if origin and not run.loop.origin:
                run.loop.origin = {"study": origin, "controller": controller, "scenario": scenario, "changes": {}}
            run.save(beside / run_folder(key))
        drawn = draw(report, progress)
        page = html.page(report, manifest(wall_s), drawn)
        (beside / "report.html").write_text(page, encoding="utf-8", newline="\n")
        card: dict[str, Any] = {"numbers": [list(n) for n in report.key_numbers]}
        if report.key_picture is not None and report.key_picture.name in drawn:
            picture = _save_picture(drawn[report.key_picture.name].source, beside)
            card |= {"picture": picture, "alt": report.key_picture.caption}
        found = {**data(report, wall_s, target / "report.html"), "card": card, "manifest": manifest(wall_s)}
        text = json.dumps(found, indent=1, allow_nan=False, ensure_ascii=False)
        (beside / "report.json").write_text(text, encoding="utf-8", newline="\n")
    return target / "report.html"


def data(report: StudyReport, wall_s: float, page: Path) -> dict[str, Any]:
    """The report as the one JSON object that a command prints."""
    from leadscrew._version import __version__
    from leadscrew.studies import claims

    whole = {
        "study": report.name,
        "title": report.title,
        "version": __version__,
        "schema_version": claims.SCHEMA_VERSION,
        "kind": report.kind,
        "conclusion": list(report.conclusion),
        **report.data,
        "wall_s": wall_s,
        "report": str(page),
    }
    order = ("study", "title", "version", "schema_version", "kind", "wall_s", "conclusion")
    found: dict[str, Any] = strict({**{k: whole[k] for k in order if k in whole}, **whole})
    return found


def _save_picture(source: str, folder: Path) -> str:
    """Writes the key figure beside its page; gives the name of the file."""
    kind, _, content = source.partition(";base64,")
    name = "key.svg" if "svg" in kind else "key.png"
    (folder / name).write_bytes(base64.b64decode(content))
    return name
