"""From a log to a machine: every command of the page, in order, with the output that it shows."""

import json
import subprocess
import sys

import pytest

from leadscrew.export.folder import compiler_path
from tests.docs import sessions
from tests.docs.snippets import ROOT
from tests.fuzzy.formats_systems import shared
from tests.tools import missing

PAGE = ROOT / "docs" / "log_to_machine.md"
STEPS = sessions.steps_of(PAGE)
REAL = [s for s in STEPS if "emps" in s.command]
"""Commands that need the log of the real axis."""
OURS = [s for s in STEPS if s not in REAL]
TRUE = {
    "mass": 60.0,
    "offset": 4.0,
    "friction.forward.coulomb": 20.0,
    "friction.forward.viscous": 65.0,
    "delay_s": 1e-3,
}
"""Of the stage that makes the log."""
NEAR = 0.02
"""From the search on, which rounds in another way on another kind of processor, says the page: 1.2 % was seen."""
TOOLS = {"python3": f'exec {sys.executable} "$@"'}


def typed(folder, steps):
    """What the commands print, typed one after the other in this folder; compared with what is shown."""
    if compiler_path() is None:
        missing("gcc", "there is no C compiler on this machine")
    script = sessions.prepare(PAGE, folder, TOOLS, steps)
    done = subprocess.run(
        ["bash", str(script)], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=900
    )
    sessions.compare(PAGE, done.stdout, steps, rel=NEAR, since="leadscrew tune")


@pytest.mark.slow
def test_every_command_from_a_simulated_log_to_a_component_does_what_it_shows(tmp_path):
    typed(tmp_path, OURS)
    fitted = json.loads((tmp_path / "stage_report" / "axis.json").read_text(encoding="utf-8"))["parameters"]
    for key, true in TRUE.items():
        assert fitted[key]["low"] <= true <= fitted[key]["high"], key
    assert sorted(p.name for p in (tmp_path / "stage_report").iterdir()) == [
        "axis.json", "axis.toml", "friction.png", "parameters.png", "position.png", "report.html", "residual.png",
    ]  # fmt: skip


@pytest.mark.slow
def test_the_same_commands_take_the_log_of_a_real_axis(tmp_path):
    (tmp_path / "DATA_EMPS.mat").symlink_to(shared("data/emps/DATA_EMPS.mat"))
    typed(tmp_path, REAL)


def test_each_command_takes_what_an_earlier_one_wrote():
    """Nothing is typed that the page does not make, but for the log of the real axis."""
    made = {"make_log.py", "stage.csv", "DATA_EMPS.mat"}
    for step in STEPS:
        words = step.command.split()
        written = {words[i + 1] for i, w in enumerate(words) if w in ("-o", "--out", "--report")}
        read = {w.split("/")[0] for w in words if w.endswith((".toml", ".csv", ".mat", ".py", ".json"))} - written
        assert read <= made, step.command
        made |= written
    commands = {s.command.split()[1] for s in OURS}
    assert {"log", "identify", "excite", "list", "simulate", "tune", "compare", "ballbar", "export"} <= commands
    assert len(REAL) >= 5 and all(s.shown for s in STEPS if s.command.startswith("leadscrew"))
