"""Every reader of files, by a command or a function that a user calls, with whole files to begin from.

A command has ``@`` where its file is. What a run folder holds is changed within a copy of the folder.
"""

from __future__ import annotations

import contextlib
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

CORPUS = Path(__file__).parents[1] / "corpus" / "0.1.0"
SEEDS = Path(__file__).with_name("seeds")


@dataclass(frozen=True)
class Target:
    """A reader: ``work`` is the words of a command, or a function of the file's path."""

    name: str
    seeds: tuple[Path, ...]
    work: str | Callable[[Path], Any]
    weight: int = 4
    """How many files it is given, beside the others; less where each takes long."""
    folder: Path | None = None
    """Whose copy the file is in."""


def _of(name: str) -> Callable[[Path], Any]:
    """A function by module and name, imported when it is called."""
    from importlib import import_module

    module, _, function = name.partition(":")
    return lambda path: getattr(import_module(module), function)(path)


def _loop(path: Path) -> None:
    """The loop of an experiment file, built but not run."""
    from leadscrew import experiment

    experiment.read(path).loop()


def _machine(path: Path) -> None:
    from leadscrew import resolve

    study = resolve.study(str(path))
    assert study.controllers


def _chunk(path: Path) -> None:
    from leadscrew.tune.checkpoints import Journal

    journal = Journal(path.parent / "journal", {"q": 1})
    journal.folder.mkdir(exist_ok=True)
    shutil.copy(path, journal.path(0))
    journal.get(0)


def _message(path: Path) -> None:
    from leadscrew.panel import messages, strict_json

    text = path.read_bytes().decode("utf-8", "replace")
    for reader in (messages.parse, strict_json.loads):
        with contextlib.suppress(ValueError, messages.Refused):
            reader(text)


def _preset(path: Path) -> None:
    from leadscrew.panel import presets

    presets.load(path.parent, path.stem)


def _manifest(path: Path) -> None:
    from leadscrew.export.folder import read_manifest

    read_manifest(path.parent)


@cache
def targets() -> tuple[Target, ...]:
    """All of them."""

    def seeds(*names: str) -> tuple[Path, ...]:
        found = tuple(p for n in names for p in sorted([*CORPUS.glob(n), *SEEDS.glob(n)]))
        assert found, names
        return found

    run = CORPUS / "runs" / "sampled"
    stage = seeds("logs/stage.csv")
    tables = (*stage, *seeds("operate/captures/step.csv", "*.halscope", "semicolons.csv", "sampler.txt", "loop.csv"))
    loop = (*seeds("loop.csv", "runs/continuous/signals.parquet"), run / "signals.parquet")
    return (
        Target("log text", tables, "log @", 12),
        Target("log parquet", seeds("operate/captures/step.parquet", "scatter/samples.parquet"), "log @", 8),
        Target("log mat", seeds("operate/captures/step.mat"), "log @", 8),
        Target("log run manifest", (run / "run.json",), "log @", 4, run),
        Target("log run signals", (run / "signals.parquet",), "log @", 2, run),
        Target("replay manifest", (run / "run.json",), "replay @", 3, run),
        Target("replay signals", (run / "signals.parquet",), "replay @", 1, run),
        Target("session", seeds("operate/session.toml"), _of("leadscrew.operate.session_file:read")),
        Target("capture", seeds("operate/captures/step.*"), _of("leadscrew.operate.captures:load"), 8),
        Target("following-error", loop, "following-error @ --json", 4),
        Target("harmonics", loop, "harmonics @ --spindle 3000 --json", 3),
        Target("frequency-response", seeds("runs/continuous/signals.parquet"), "frequency-response @ --json", 3),
        Target("identify axis", stage, "identify axis @ --force-per-drive 20 --refine none --json", 1),
        Target("identify linear", stage, "identify linear @ --max-order 1 --json", 1),
        Target("identify friction", seeds("runs/friction/signals.parquet"), "identify friction @ --json", 2),
        Target("identify friction-force", seeds("logs/contact.csv"), "identify friction-force @ --json", 1),
        Target("identify cutting-force", seeds("logs/turning_forces.csv"), "identify cutting-force @ --json", 4),
        Target("predict", loop, "predict @ --column feedback --json", 2),
        Target("design vud", seeds("moves/m50/signals.parquet"), "design vud @ --json", 3),
        Target("positioning", seeds("measured/positioning.csv"), "positioning @ --json", 6),
        Target("ballbar", seeds("measured/ballbar.csv"), "ballbar @ --radius 100 --feed 1000 --json", 4),
        Target("svg", seeds("tangent/leaf.svg", "*.svg"), "tangent show @ --json", 10),
        Target("dxf", seeds("*.dxf"), "tangent show @ --json", 10),
        Target("gcode", seeds("tangent/*.ngc", "*.ngc"), "tangent show @ --json", 10),
        Target("tangent measured", seeds("tangent/piece.csv"), _of("leadscrew.tangent.measurement:read_measured")),
        Target("tangent program", seeds("tangent/*.ngc"), _of("leadscrew.tangent.program:read_program")),
        Target("network", seeds("tangent/network.json"), _of("leadscrew.neural.performance:read_net")),
        Target("fuzzy fis", seeds("fuzzy/*.fis"), "fuzzy show @ --json", 6),
        Target("fuzzy fll", seeds("fuzzy/*.fll"), "fuzzy show @ --json", 6),
        Target("fuzzy fcl", seeds("fuzzy/*.fcl"), "fuzzy show @ --json", 6),
        Target("fuzzy xml", seeds("*.xml"), "fuzzy show @ --json", 6),
        Target("experiment", seeds("*_experiment.toml"), _loop, 2),
        Target("controller", seeds("controllers/*.toml"), _of("leadscrew.resolve:from_controller_file")),
        Target("machine", seeds("machines/*.toml", "axis_report/axis.toml"), _machine, 3),
        Target("hal file", seeds("*_hal.toml"), _of("leadscrew.panel.hal.file:read")),
        Target("preset", seeds("operate/presets/*.json"), _preset),
        Target("manifest", seeds("exports/c99/manifest.json"), _manifest, 2),
        Target("journal", seeds("tuning/journal/chunk_0000001.npz"), _chunk, 6),
        Target("belief", seeds("axis_report/axis.json"), _of("leadscrew.identify.excite.belief:_read"), 3),
        Target("message", seeds("message.json"), _message, 6),
    )
