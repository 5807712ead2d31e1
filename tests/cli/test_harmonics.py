"""``leadscrew harmonics`` and ``leadscrew frequency-response``."""

import csv

import numpy as np
import pytest

from leadscrew.analysis.harmonics import least_squares
from tests.cli.conftest import strict_json

T = np.arange(8000) / 1000.0
SIZES = {0.7: 7.0, 2.1: 0.8, 3.5: 0.4, 16.9: 0.5, 33.8: 0.9}


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    """Eight seconds of error in mm: three lines of a motion, two of a spindle at 1014 1/min, a little noise."""
    y = sum(a * np.sin(2 * np.pi * f * T + k) for k, (f, a) in enumerate(SIZES.items()))
    y = 1e-3 * (y + 0.05 * np.random.default_rng(1).normal(size=len(T)))
    path = tmp_path_factory.mktemp("log") / "log.csv"
    path.write_text("time,error\n" + "\n".join(f"{t:.6f},{v:.9f}" for t, v in zip(T, y, strict=True)) + "\n")
    return path


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """A closed loop of a known integrator: feedback = integral of 20 times the error, no noise."""
    rng = np.random.default_rng(2)
    command = np.repeat(rng.normal(size=4000), 2)
    feedback, y = np.zeros(8000), 0.0
    for k in range(8000):
        feedback[k] = y
        y += 0.02 * (command[k] - y)
    path = tmp_path_factory.mktemp("swept") / "swept.csv"
    rows = zip(T, command, feedback, strict=True)
    path.write_text("time,command,feedback\n" + "\n".join(f"{a:.6f},{b:.9f},{c:.12f}" for a, b, c in rows) + "\n")
    return path


ASKED = ("--base", "0.7", "--orders", "3,5", "--scale", "1000", "--unit", "um")


def test_the_table_shows_the_amplitudes_of_the_library(call, log):
    shown = call("harmonics", log, *ASKED, "--spindle", 1000, "--teeth", 2, "--fit-spindle")
    rows = {" ".join(x.split()[:2]): x.split()[2:] for x in shown.stdout.splitlines() if x.startswith("order")}
    for name, size in (("order 1", 7.0), ("order 3", 0.8), ("order 5", 0.4)):
        assert float(rows[name][1]) == pytest.approx(size, abs=0.01)
        assert float(rows[name][2]) <= float(rows[name][1]) <= float(rows[name][3])
    speed = shown.stdout.split("spindle fitted: ")[1].split()[0]
    assert float(speed) == pytest.approx(1014.0, abs=0.01)
    assert "amplitude (µm)" in shown.stdout and shown.stderr == ""
    assert "8000 samples at 1000 Hz, 8 s" in shown.stdout


def test_a_line_that_was_not_named_is_pointed_out(call, log):
    assert "at 33.8 Hz, 0.90" in call("harmonics", log, *ASKED).stderr


def test_json_has_everything_and_is_what_least_squares_gives(call, log):
    found = strict_json(
        call("harmonics", log, "--base", 0.7, "--orders", "3,5", "--lines", "16.9,33.8", "--json").stdout
    )
    values = np.loadtxt(log, delimiter=",", skiprows=1)
    expected = least_squares(values[:, 0], values[:, 1], (0.7, 2.1, 3.5, 16.9, 33.8))
    assert found["amplitude"] == pytest.approx(expected.amplitudes.tolist(), rel=1e-9)
    assert found["line"] == ["order 1", "order 3", "order 5", "16.9 Hz", "33.8 Hz"]
    assert found["amplitude_low"] == pytest.approx(expected.confidence()[0].tolist(), rel=1e-9)
    assert found["kind"] == "leadscrew harmonics" and found["base_fitted_hz"] is None


def test_the_fitted_base_and_a_part_of_the_time(call, log):
    found = strict_json(call("harmonics", log, *ASKED, "--fit-base", "--from", 2, "--to", 7, "--json").stdout)
    assert found["base_fitted_hz"] == pytest.approx(0.7, abs=1e-3) and found["samples"] == 5001
    assert found["base_low_hz"] < found["base_fitted_hz"] < found["base_high_hz"]


@pytest.mark.slow
def test_picture_and_table_are_files(call, log, tmp_path):
    call("harmonics", log, *ASKED, "--plot", tmp_path / "p.png", "--csv", tmp_path / "t.csv")
    assert (tmp_path / "p.png").read_bytes().startswith(b"\x89PNG")
    rows = list(csv.reader((tmp_path / "t.csv").open()))
    assert len(rows) == 4 and {len(r) for r in rows} == {7} and rows[1][0] == "order 1"


def test_a_run_s_folder_is_a_log(call, study, tmp_path):
    call("simulate", study, "-c", "p", "-s", "small", "--out", tmp_path / "run", "--duration", 1)
    found = strict_json(call("harmonics", tmp_path / "run", "--lines", "5", "--json").stdout)
    assert found["signal"] == "error" and found["samples"] > 100


@pytest.mark.parametrize(
    ("asked", "says"),
    [
        (
            ("--lines", "700"),
            "a line at 700 Hz is not below half the sampling rate (500 Hz): sampled at 1000 Hz it folds",
        ),
        (("--signal", "eror", "--lines", "5"), "has no column 'eror'; did you mean error?"),
        ((), "no line to measure"),
        (("--orders", "3;5", "--base", "1"), "expected numbers with commas"),
        (("--base", "1", "--orders", "2.5"), "whole orders"),
        (("--lines", "5", "--from", "20"), "runs from 0 to 7.999 s"),
        (("--lines", "5", "--plot", "x.gif"), ".png, .svg, .pdf"),
        (("--lines", "5", "--level", "95"), "expected a probability"),
        (("--lines", "5", "--scale", "0"), "--scale"),
        (("--base", "30", "--fit-base"), "no fundamental within 5 % of 30 Hz"),
        (("--lines", "5", "--window", "best"), "window = 'best'"),
    ],
)
def test_what_cannot_be_done_is_refused_in_a_sentence(refused, log, asked, says):
    assert says in refused("harmonics", log, *asked)


# ---- frequency response
def integrator(hertz, loop):
    z = np.exp(2j * np.pi * np.asarray(hertz) / 1000.0)
    gain = 0.02 / (z - 1.0)
    return gain if loop else gain / (1.0 + gain)


def test_the_closed_loop_of_a_log_is_the_known_one(call, swept):
    found = strict_json(call("frequency-response", swept, "--segment", 2, "--low", 2, "--high", 30, "--json").stdout)
    exact = integrator(found["frequency_hz"], False)
    assert found["gain"] == pytest.approx(np.abs(exact).tolist(), rel=0.05)
    assert found["method"] == "H1" and min(found["coherence"]) > 0.99 and found["margins"] is None


def test_the_loop_gain_of_a_log_has_its_margins(call, swept):
    result = call("frequency-response", swept, "--segment", 2, "--loop-gain", "--low", 1, "--high", 60)
    gain = [x for x in result.stdout.splitlines() if x.startswith("phase margin")]
    # abs(0.02 / (z - 1)) is 1 at 3.183 Hz; there its phase is -90 deg less half a sample.
    assert gain and float(gain[0].split()[2]) == pytest.approx(89.4, abs=2.0)
    assert float(gain[0].split()[5]) == pytest.approx(3.183, rel=0.03)
    found = strict_json(call("frequency-response", swept, "--loop-gain", "--segment", 2, "--json").stdout)
    assert found["margins"]["sensitivity"] < 1.2 and found["method"] == "joint"


def test_times_in_ms_are_not_taken_for_seconds(call, refused, log, swept, tmp_path):
    for path, out in ((log, tmp_path / "log.csv"), (swept, tmp_path / "swept.csv")):
        lines = path.read_text().splitlines()
        rows = [f"{1000.0 * float(t):.3f},{rest}" for t, _, rest in (line.partition(",") for line in lines[1:])]
        out.write_text("\n".join([lines[0].replace("time", "time [ms]"), *rows]) + "\n")
    asked = (*ASKED[:4], "--lines", "16.9,33.8", "--from", 1, "--to", 7, "--json")
    found = strict_json(call("harmonics", tmp_path / "log.csv", *asked).stdout)
    assert found["amplitude"] == pytest.approx([1e-3 * a for a in SIZES.values()], rel=0.02)
    found = strict_json(call("frequency-response", tmp_path / "swept.csv", "--segment", 2, "--json").stdout)
    # Half the sampling rate of 1 kHz, and the known integrator at 3 Hz.
    assert max(found["frequency_hz"]) == pytest.approx(500.0, rel=0.01)
    at = min(range(len(found["gain"])), key=lambda k: abs(found["frequency_hz"][k] - 3.0))
    assert found["gain"][at] == pytest.approx(abs(integrator(found["frequency_hz"][at], False)), rel=0.05)
    (tmp_path / "odd.csv").write_text("time [mm],error\n" + "\n".join(f"{k},{k % 3}" for k in range(99)))
    said = refused("harmonics", tmp_path / "odd.csv", "--lines", 0.1)
    assert "odd.csv, column 'time [mm]': 'mm' is no unit of time" in said


@pytest.mark.slow
def test_response_files_hold_every_frequency(call, swept, tmp_path):
    call("frequency-response", swept, "--plot", tmp_path / "b.svg", "--csv", tmp_path / "b.csv", "--segment", 1)
    assert b"<svg" in (tmp_path / "b.svg").read_bytes()
    rows = list(csv.DictReader((tmp_path / "b.csv").open()))
    assert len(rows) == 500 and float(rows[0]["frequency_hz"]) == 1.0
    assert all(float(r["gain_low"]) <= float(r["gain"]) <= float(r["gain_high"]) for r in rows)


@pytest.mark.parametrize(
    ("asked", "says"),
    [
        (("--input", "feedback"), "expected two signals"),
        (("--loop-gain", "--excitation", "command"), "needs no --excitation"),
        (("--segment", "30"), "half of the record"),
        (("--period", "1", "--segment", "1"), "leave out --segment"),
        (("--method", "H9"), "method = 'H9'"),
        (("--output", "position"), "has no column 'position'"),
        (("--low", "0.01", "--high", "0.02"), "none of them there"),
    ],
)
def test_a_response_that_cannot_be_had_is_refused_in_a_sentence(refused, swept, asked, says):
    assert says in refused("frequency-response", swept, *asked)
