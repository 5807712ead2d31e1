"""Writes the files of a corpus with the installed version of Leadscrew: ``python tests/corpus/make_corpus.py FOLDER``.

The corpus of a released version is committed once and never written again; this script says how it was made, and makes
that of the next release, by ``commands.txt``. It needs gcc. All names are relative, so that no path of a machine is
inside.
"""

import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"

FOLDERS = ("runs", "moves", "logs", "fuzzy", "machines", "identified", "controllers", "experiments", "tuning",
           "measured", "tangent", "exports", "operate")  # fmt: skip
COMMANDS = Path(__file__).with_name("commands.txt").resolve()

EXPERIMENT = """\
# The lathe's step under the fuzzy system beside it.
schema_version = 1
study = "vud_lathe"
controller = "../fuzzy/axis.fll"
scenario = "fig11a_step_m50"
duration = 0.2

[set]
controller.scale_e = 0.02
controller.scale_de = 1
controller.scale_output = -1
"""


def stage_log() -> None:
    """The log of ``docs/log_to_machine.md``, shorter."""
    import numpy as np

    from leadscrew import Loop
    from leadscrew.controllers._axis_cascade import axis_cascade
    from leadscrew.plants._servo_axis import servo_axis
    from leadscrew.references._waypoints import waypoints
    from leadscrew.sensors._counts import axis_reading

    friction = {"coulomb": 20.0, "static": 20.0, "viscous": 65.0}
    stage = servo_axis(
        mass=60.0,
        force_per_drive=20.0,
        offset=4.0,
        **{f"friction.{way}.{name}": value for way in ("forward", "backward") for name, value in friction.items()},
    )
    loop = Loop(
        reference=waypoints(
            [0, 40, 20, 60, 58, 30, 31, 0, 15, 5, 8, 0],
            dwell=0.05,
            max_velocity=150.0,
            max_acceleration=1500.0,
            max_jerk=5e4,
        ),
        controller=axis_cascade(kpos=40.0, kvp=0.4, kvi=0.0, lower=-10.0, upper=10.0),
        plant=stage,
        sensor=axis_reading(resolution=1e-3, noise=1e-3),
        period=1e-3,
        computation_delay=1e-3,
        seed=3,
        metrics={},
    )
    run = loop.run(4.0, record=("command.position", "output", "feedback"))
    table = np.column_stack([run.time, run["command.position"], run["output"], run["feedback"]])
    head = "time (s),command (mm),drive (V),position (mm)"
    np.savetxt("logs/stage.csv", table, delimiter=",", fmt="%.6g", header=head, comments="")


def thinned(path: Path, step: int) -> None:
    """Keeps the headings of a log and every so many rows."""
    lines = path.read_text(encoding="utf-8").splitlines()
    rows = next(i for i, line in enumerate(lines) if line[:1] in "-0123456789")
    path.write_text("\n".join([*lines[:rows], *lines[rows::step], ""]), encoding="utf-8")


def operated() -> None:
    """A session, its script, captures in three formats, a preset: what the panel keeps."""
    from leadscrew.operate import captures, session_file
    from leadscrew.operate.captures import Capture
    from leadscrew.operate.operated import Operated, Start
    from leadscrew.panel import presets
    from leadscrew.panel.records import text_of

    machine = Operated(Start("vud_lathe", "corrected.vud_beta_e", "sequence", seed=4))
    machine.advance(60)
    machine.set({"controller.tau": 0.8})
    machine.advance(40)
    machine.switch("ours.pd")
    rows, _ = machine.advance(100)
    session_file.write(machine.session(), Path("operate/session.toml"))
    Path("operate/operated.py").write_text(text_of((machine.session(), machine.period_s), "py"), encoding="utf-8")
    names = ("time", "command", "feedback", "output")
    kept = rows[:, [machine.columns.index(n) for n in names]].copy()
    units = {"time": "s", "command": "mm"}
    capture = Capture("step", names, units, machine.period_s, 100, 10, kept, {"study": "vud_lathe"})
    for form in captures.FORMATS:
        captures.save(capture, "operate/captures", "step", form)
    presets.save(presets.Preset("vud_lathe", "ours.pd", {"controller.kp": 0.2}), Path("operate/presets"), "soft")


def called(line: str) -> None:
    """Runs a command as it stands; ``> FILE`` keeps what it prints."""
    words, _, kept = line.partition(" > ")
    done = subprocess.run(
        [sys.executable, "-m", "leadscrew", *shlex.split(words)], capture_output=True, text=True, check=False
    )
    if done.returncode:
        sys.exit(f"{line}\nexit code {done.returncode}\n{done.stdout}{done.stderr}")
    if kept:
        Path(kept).write_text(done.stdout, encoding="utf-8")


def main() -> None:
    os.umask(0o022)
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True)
    os.chdir(folder)
    for name in FOLDERS:
        Path(name).mkdir()
    shutil.copy(EXAMPLES / "axis.fll", "fuzzy/axis.fll")
    shutil.copy(EXAMPLES / "ballbar.csv", "measured/ballbar.csv")
    shutil.copy(EXAMPLES / "positioning.csv", "measured/positioning.csv")
    shutil.copy(EXAMPLES / "turning_forces.csv", "logs/turning_forces.csv")
    Path("experiments/fuzzy_step.toml").write_text(EXPERIMENT, encoding="utf-8")
    stage_log()
    operated()
    first, *rest = COMMANDS.read_text(encoding="utf-8").splitlines()
    called(first)
    thinned(Path("logs/contact.csv"), 4)
    for line in rest:
        called(line)
    shutil.copy("axis_report/axis.json", "identified/axis.json")
    for made in [*Path().rglob("*.png"), *Path().rglob("*.html")]:
        made.unlink()


if __name__ == "__main__":
    main()
