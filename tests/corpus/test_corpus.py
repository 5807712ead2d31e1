"""Files that version 0.1.0 wrote are still read, with the same numbers. ``0.1.0/README.md`` says what wrote each."""

import json
import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import typer
from click.testing import CliRunner

from leadscrew import __version__
from leadscrew.cli import app
from leadscrew.experiment import read
from leadscrew.export.folder import read_manifest
from leadscrew.fuzzy import formats
from leadscrew.kernel.run import load
from leadscrew.neural.performance import read_net
from leadscrew.operate import captures, session_file
from leadscrew.panel import presets
from leadscrew.tune.checkpoints import Journal
from tests.tools import missing

OLD = Path(__file__).with_name("0.1.0")
COMMAND = typer.main.get_command(app)


@pytest.fixture
def call(monkeypatch):
    """Calls the command line in the folder of the corpus; gives its JSON."""
    monkeypatch.chdir(OLD)

    def run(*words, code=0):
        done = CliRunner().invoke(COMMAND, [*map(str, words), "--json"])
        assert done.exit_code == code, done.output
        return json.loads(done.stdout)

    return run


# ---- runs and sessions
@pytest.fixture
def replayed(tmp_path):
    """Replays in a process of its own whose BLAS rounds as on the processor that the corpus was written on: SciPy's
    matrix exponential, and so the plant of the lathe, hangs on that in its last bits. Gives exit code and output.
    """
    own = {"OPENBLAS_CORETYPE": "Haswell", "LEADSCREW_CACHE_DIR": str(tmp_path / "cache")}

    def run(*words):
        command = [sys.executable, "-m", "leadscrew", "replay", *map(str, words)]
        done = subprocess.run(command, cwd=OLD, env={**os.environ, **own}, capture_output=True, text=True, check=False)
        return done.returncode, done.stdout

    return run


@pytest.mark.parametrize(
    "run",
    ["sampled", *(pytest.param(name, marks=pytest.mark.slow) for name in ("continuous", "cut", "friction"))],
)
def test_a_run_is_replayed_with_the_same_bits(replayed, run):
    found = json.loads(replayed(f"runs/{run}", "--json")[1])
    assert found["identical"] and found["written_by"] == "0.1.0" and found["replayed_by"] == __version__


@pytest.mark.slow
def test_a_run_of_turning_is_replayed_and_says_that_the_plant_is_another_one_now(replayed):
    """Turning was stepped by semi-implicit Euler in 0.1.0 and is exact now: ``docs/changed_numbers.md``."""
    code, said = replayed("runs/noise")
    first, second, *_ = said.splitlines()
    assert code == 1 and first.startswith("not identical: ")
    assert second.strip() == f"the run was written by Leadscrew 0.1.0 and replayed by Leadscrew {__version__}"


@pytest.mark.slow
def test_a_session_is_replayed_with_the_same_bits(replayed):
    found = json.loads(replayed("operate/session.toml", "--json")[1])
    assert found["identical"] and (found["rows"], found["events"]) == (200, 2)


def test_a_run_whose_bits_changed_says_which_versions_wrote_and_replayed_it(tmp_path, replayed):
    run = shutil.copytree(OLD / "runs" / "sampled", tmp_path / "run")
    table = pq.read_table(run / "signals.parquet")
    values = table.column("output").to_numpy().copy()
    values[7] = np.nextafter(values[7], 2)
    at = table.column_names.index("output")
    pq.write_table(table.set_column(at, "output", pa.array(values)), run / "signals.parquet")
    manifest = (run / "run.json").read_text(encoding="utf-8")
    for version, words in (('"0.0.9"', "Leadscrew 0.0.9"), ("null", "an unknown version of Leadscrew")):
        changed = manifest.replace('"leadscrew": "0.1.0"', f'"leadscrew": {version}')
        (run / "run.json").write_text(changed, encoding="utf-8")
        code, said = replayed(run)
        assert code == 1
        first, second, *_ = said.splitlines()
        assert first.startswith("not identical: output at row 7, t = 0.007 s: saved ")
        assert second.strip() == f"the run was written by {words} and replayed by Leadscrew {__version__}"


def test_the_noise_of_an_old_run_and_of_an_old_experiment_is_the_same_stream():
    assert load(OLD / "runs" / "noise")[0]["replicate"] == 3
    assert read(OLD / "scatter" / "worst" / "settling_2um_1.toml").replicate == 2


def test_a_recorded_run_is_read_as_a_log(call):
    found = call("predict", "runs/noise", "--column", "feedback")
    assert found["scores"][1]["rmse"] == pytest.approx(5.885405807214091, rel=1e-9)


def test_what_the_panel_kept_is_read():
    session = session_file.read(OLD / "operate" / "session.toml")
    assert (session.start.study, session.start.seed, session.periods) == ("vud_lathe", 4, 200)
    assert [(e.period, e.do, dict(e.changes), e.controller) for e in session.events] == [
        (60, "set", {"controller.tau": 0.8}, ""), (100, "switch", {}, "ours.pd"),
    ]  # fmt: skip
    taken = [captures.load(OLD / "operate" / "captures" / f"step.{form}") for form in captures.FORMATS]
    assert all(c.rows.tobytes() == taken[0].rows.tobytes() and c.trigger_row == 10 for c in taken)
    assert taken[0].signal("output").sum() == 100.0
    preset = presets.load(OLD / "operate" / "presets", "soft")
    assert (preset.controller, dict(preset.values)) == ("ours.pd", {"controller.kp": 0.2})
    replayed = pq.read_table(OLD / "operate" / "replayed" / "signals.parquet")
    assert replayed.num_rows == 200 and session_file.read(OLD / "operate" / "replayed" / "session.toml") == session


# ---- files that are written by hand or by a command, and read by others


def test_a_machine_file_is_a_study(call):
    found = call("list", "machines/stage.toml")
    assert [c["name"] for c in found["controllers"]] == ["ours.cascade", "ours.cascade_model"]
    assert [c["name"] for c in call("list", "machines/linear.toml")["controllers"]] == ["ours.pid"]
    start = ("-s", "move", "--engine", "python", "--duration", "0.02")
    found = call("simulate", "machines/stage.toml", "-c", "ours.cascade_model", *start)
    assert found["metrics"]["max_error"] == 0.009351489980261338


@pytest.mark.parametrize(
    ("file", "controller", "values"),
    [
        ("tuned", "corrected.vud_beta_e", {"output_gain": 2.998988756305377, "tau": 0.9}),
        ("vud", "vud_beta_e", {"rate_full_scale_mm": 25.117999999999995}),
        ("npid", "npid_slope", {"k": 2.059151205472804, "es_um": 0.3631925255148547}),
        ("friction", "ours.pd_dob", {"hat.coulomb": 6.239727694462783, "inertia": 0.00021630492584009953}),
    ],
)
def test_a_controller_file_sets_its_values(call, file, controller, values):
    found = call("list", f"controllers/{file}.toml")
    assert found["controller"] == controller
    now = {p["key"]: p["value"] for p in found["parameters"]}
    assert {key: now[key] for key in values} == values


@pytest.mark.parametrize(
    ("file", "metric", "value"),
    [
        ("experiments/fuzzy_step.toml", "rms_error", 49.430762910228495),
        ("scatter/worst/settling_2um_1.toml", "rms_error", 49.69880428063459),
        ("cut_report/cut.toml", "iae", 3.0),
    ],
)
def test_an_experiment_file_runs_as_it_did(call, file, metric, value):
    assert call("simulate", file, "--engine", "python", "--duration", "0.02")["metrics"][metric] == value


def test_a_fuzzy_system_has_the_same_output_in_every_format(call):
    found = call("fuzzy", "eval", "fuzzy/axis.fll", "e=0.3", "de=-0.2", "--engine", "python")
    assert found["outputs"] == {"u": 0.060975609756097546}
    for file in ("axis.fis", "axis.fcl", "axis.fll"):
        system = formats.read(OLD / "fuzzy" / file)
        assert [len(variable.terms) for variable in system.inputs] == [5, 5] and len(system.rules) == 25
    learned = formats.read(OLD / "fuzzy" / "learned.fis")
    position = learned.inputs[1]
    assert (position.name, position.low, position.high) == ("position (mm)", -0.002, 59.922)


def test_a_network_of_the_tangent_study_is_read():
    net = read_net(OLD / "tangent" / "network.json")
    assert len(net.hidden) == 6 and net.hidden[0][0] == 0.32399433655946575


# ---- logs and measured files


def test_logs_are_read_with_units_and_sampling(call):
    stage = call("log", "logs/stage.csv")
    assert stage["rows"] == 4000 and set(stage["roles"]) == {"time", "command", "drive", "position"}
    contact = call("log", "logs/contact.csv")
    assert contact["rows"] == 2538 and contact["units"]["position"] == "um"


def test_a_screw_compensation_is_written_again_byte_for_byte(call, tmp_path):
    found = call("positioning", "measured/positioning.csv", "--compensation", tmp_path / "x.comp")
    assert (tmp_path / "x.comp").read_bytes() == (OLD / "measured" / "x.comp").read_bytes()
    assert found["targets_mm"] == saved("measured/positioning.json")["targets_mm"]


def test_a_fit_says_what_a_test_move_has_to_excite(call):
    found = call("excite", "identified/axis.json", "--tell", "friction", "--travel", "0,50")
    assert found["predicted"][0]["value"] == 19.99205933518533


def test_drawings_programs_and_cut_lines_are_read(call, tmp_path):
    drawing = call("tangent", "show", "tangent/leaf.svg")
    assert drawing["length_mm"] == pytest.approx(548.9770869081773, rel=1e-12)
    found = call(
        "tangent", "compensate", "tangent/leaf.ngc", "--measured", "tangent/piece.csv", "-o", tmp_path / "leaf2.ngc"
    )
    assert found["before_rms_deg"] == pytest.approx(1.724817358632049, rel=1e-9)
    assert (tmp_path / "leaf2.ngc").read_bytes() == (OLD / "tangent" / "leaf2.ngc").read_bytes()


# ---- results


def saved(name):
    return json.loads((OLD / name).read_text(encoding="utf-8"))


def test_saved_results_hold_what_they_held():
    for name, *keys, value in (
        ("tuning/tuned.json", "held_out", "values", "worst:settling_2um", 0.634),
        ("comparison/compare.json", "ranking", 0, "ours.pd"),
        ("tuning/compared.json", "pairs", 0, "difference", "value", -0.32962499999999995),
        ("scatter/summary.json", "over", "plant.full_duty_speed_mm_s", "normal:296:12"),
        ("certificate.json", "certified", True),
        ("identified/friction.json", "parameters", "coulomb", "value", 6.239727694462783),
        ("measured/ballbar.json", "quantities_um", 0, "value", 7.862363015320284),
        ("excite/proposal.json", "period_s", 0.001),
    ):
        found = saved(name)
        for key in keys:
            found = found[key]
        assert found == value, name
    assert pq.read_table(OLD / "scatter" / "samples.parquet").num_rows == 16


def test_a_checkpoint_of_the_tuner_is_opened_again(tmp_path):
    folder = shutil.copytree(OLD / "tuning" / "journal", tmp_path / "journal")
    journal = Journal(folder, json.loads((folder / "question.json").read_text())["question"], resume=True)
    assert journal.chunks == 6
    assert journal.get(0)["settling_2um"][[0, 3]].tolist() == [0.979, 0.664]


# ---- exports


@pytest.mark.parametrize("target", ["c99", "hal", "fmu2", "fmu3"])
def test_an_export_is_known_by_its_manifest(target):
    manifest = read_manifest(OLD / "exports" / target)
    assert (manifest["target"], manifest["cycles"], manifest["golden"]["verdict"]) == (target, 200, "identical")
    lines = (OLD / "exports" / target / "golden.csv").read_text(encoding="utf-8").splitlines()
    assert len([line for line in lines if line[0] == "-"]) == 200
    if target.startswith("fmu"):
        with zipfile.ZipFile(OLD / "exports" / target / "pd.fmu") as fmu:
            model = ElementTree.fromstring(fmu.read("modelDescription.xml"))
        assert model.get("fmiVersion") == f"{target[3]}.0" and model.get("modelName") == "ours.pd"


def test_exported_c_still_gives_its_golden_vectors(call):
    if shutil.which("gcc") is None:
        missing("gcc", "gcc is not installed")
    verdicts = call("verify-export", "exports/c99")["verdicts"]
    assert {v["verdict"] for v in verdicts if "gcc" in v["target"]} == {"identical"}


# ---- the corpus itself


def test_no_path_of_a_machine_is_in_the_corpus():
    for path in OLD.rglob("*"):
        data = path.read_bytes() if path.is_file() else b""
        assert not any(word in data for word in (b"/home/", b"/root/")), path
        assert len(data) < 200_000, path
