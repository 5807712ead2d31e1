"""The panel at a real LinuxCNC HAL: what it shows, what it writes and never writes, and HAL as it was afterwards."""

from __future__ import annotations

import json
import math
import os
import re
import shutil
import sys
from functools import lru_cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from leadscrew.export import hal_run
from tests.tools import missing

pytestmark = pytest.mark.slow
ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "panel_hal.md").read_text(encoding="utf-8")
AXIS = next(x for x in re.findall(r"```text\n(.*?)```", PAGE, re.S) if x.startswith("loadrt threads"))
FILE = re.search(r"```toml\n(.*?)```", PAGE, re.S)[1]
OMEGA = 2 * math.pi
"""Of the command: 1 Hz."""


@pytest.fixture(scope="module")
def place():
    if why := hal_run.lacking():
        missing("linuxcnc", why)
    with hal_run.workplace() as found:
        yield found


@pytest.fixture(scope="module")
def inside(place):
    """Runs a scenario in halrun at the page's axis, once; gives what it saw."""

    @lru_cache
    def run(name, before_start="", **files):
        (place / "machine_hal.toml").write_text(FILE, encoding="utf-8")
        for file, text in files.items():
            (place / file.replace("_", ".")).write_text(text, encoding="utf-8")
        out = place / f"{name}.json"
        paths = os.pathsep.join([str(ROOT), str(ROOT / "src")])
        command = f"loadusr -w env PYTHONPATH={paths} {sys.executable} -m tests.panel.hal_scenarios {name} {out}"
        axis = AXIS.replace("\nstart\n", f"\n{before_start}\nstart\n")
        hal_run.run(place, f"{axis}\n{command}\n", speed=1, timeout=90.0)
        told = json.loads(out.read_text(encoding="utf-8"))
        assert "error" not in told, told["error"]
        return told

    return run


def test_eight_signals_come_without_a_gap_and_hal_is_left_as_it_was(inside):
    told = inside("sampled")
    assert told["same"] == []
    rows = np.array(told["rows"])
    assert rows.shape[1] == 8 and told["state"]["lost"] == 0
    assert abs(len(rows) / 1e-3 / told["took"] / 1e6 - 1.0) < 0.1  # 1 kHz
    t = np.arange(len(rows)) * 1e-3
    command, cosine = rows[:, 0], rows[:, 5]
    phase = math.atan2(command[0] / 5.0, cosine[0] / 5.0)
    assert np.abs(command - 5.0 * np.sin(OMEGA * t + phase)).max() < 1e-4
    error = rows[:, told_column(told, "pid.x.error")]
    assert np.abs(error[1:] - (command - rows[:, 1])[:-1]).max() < 1e-5  # pid: error-previous-target
    assert told["state"]["running"] == "running"
    assert told["state"]["figures"]["rms"] == pytest.approx(1e3 * np.sqrt(np.mean(error**2)), rel=0.05)
    described = told["machine"]
    assert described["simulated"] is False and "no safety device" in described["notice"]
    assert not any(described["can"][k] for k in ("start", "stop", "reset", "switch", "compare"))
    assert [p["title"] for p in described["plots"]] == ["Position", "Following error", "Velocity"]
    assert told["during"]["thread"][0][-1] == "sampler.0"  # behind all that is sampled
    assert told["cpu"] < 0.5 and told["cpu_helper"] < 0.5, "one of them polls without a pause"


def told_column(told, name):
    return [c["name"] for c in told["machine"]["columns"]].index(name)


def rms_theory(gain):
    """Following error of a velocity loop around an integrator under the sine of 5 mm, rms in mm."""
    return 5.0 / math.sqrt(2) * OMEGA / math.hypot(OMEGA, gain)


def test_a_gain_takes_effect_in_the_signals_and_nothing_else_can_be_written(inside):
    told = inside("written")
    assert told["set"]["old"] == {"pid.Pgain": 20.0} and told["getp"] == 100.0
    slow, fast = (float(np.sqrt(np.mean(np.square(told[k])))) for k in ("slow", "fast"))
    assert slow == pytest.approx(rms_theory(20.0), rel=0.05)
    assert fast == pytest.approx(rms_theory(100.0), rel=0.1)
    assert all(told["refused"]) and all(told["helper"]) and all(told["never"].values())
    assert "[0, 120]" in told["refused"][0] and "not among the parameters" in told["refused"][6]
    assert told["untouched"] == []
    assert told["notices"] == ["pid.Pgain was changed from 100 to 60, and not by this panel"]
    assert told["taken_over"] == 60.0 and told["undone"] == 20.0 and told["redone"] == 100.0


def test_a_parameter_with_a_rate_moves_as_a_ramp_and_safe_values_return(inside):
    told = inside("written")
    at = np.array(told["ramp"])
    inner = at[(at[:, 1] > 0.05) & (at[:, 1] < 0.95)]
    slope, begin = np.polyfit(inner[:, 0], inner[:, 1], 1)
    assert slope == pytest.approx(1.0, abs=0.05) and abs(begin) < 0.3 and at[-1, 1] == 1.0
    assert told["safe"] == [20.0, 0.0]
    assert told["left"] == [20.0, 0.0] and told["same"] == []


def test_what_was_tuned_stays_where_the_file_says_so_and_floods_of_writes_are_refused(inside):
    told = inside("kept")
    assert [bool(s) for s in told["said"]] == [False] * 20 + [True] * 5
    assert "writes_per_s" in told["said"][-1]
    assert told["last"] == told["getp"] == 39.0


def test_a_panel_that_is_killed_leaves_hal_as_it_was_and_can_attach_again(inside):
    told = inside("killed")
    assert told["gain"] == 100.0 and told["after"] == 20.0 and told["same"] == [] and told["ended"]
    assert "another panel is attached" in told["another"]
    assert told["left_over"] and told["rows"] > 800 and "was killed" in told["said"][0]
    assert told["state"]["running"] == "stopped" and "has ended" in told["state"]["message"]
    assert "has ended" in told["lost_helper"]
    assert [x for x in told["again"] if "pid.x.Pgain" not in x[1]] == []  # nobody was left to write it back


def test_lost_periods_are_counted_where_they_were_lost_and_never_joined(inside):
    told = inside("overrun")
    blocks = told["blocks"]
    ends = [first + len(values) for first, values in blocks]
    gaps = [later[0] - end for end, later in zip(ends, blocks[1:], strict=False)]
    lost = [g for g in gaps if g]
    assert len(lost) == 2 and all(g >= 0 for g in gaps)
    assert 350 < lost[0] < 700 and 700 < lost[1] < 1100
    number = np.concatenate([first + np.arange(len(v)) for first, v in blocks])
    command = np.concatenate([v for _, v in blocks])
    basis = np.column_stack([np.sin(OMEGA * number * 1e-3), np.cos(OMEGA * number * 1e-3)])
    fit = np.linalg.lstsq(basis, command, rcond=None)[0]
    assert np.abs(basis @ fit - command).max() < 1e-3  # one period wrong would be 0.03 mm
    assert told["broken"] == 1 and told["lost"] > 300
    assert told["rows"] - 1 + told["lost"] == told["period"]
    assert len([n for n in told["notices"] if "were lost" in n]) == 1
    for capture in told["captures"]:
        assert capture["rows"] <= 200


def test_a_free_channel_of_another_sampler_is_used_and_gives_what_halsampler_prints(inside):
    told = inside(
        "shared",
        "loadrt sampler depth=4000,4000 cfg=f,bffffs\naddf sampler.0 servo-thread\nnet x-pos-cmd => sampler.0.pin.0",
    )
    assert told["same"] == []
    theirs = np.array([float(w[1]) for w in told["theirs"]])
    ours = np.concatenate([v for _, v in told["ours"]])
    assert all(a[0] + len(a[1]) == b[0] for a, b in pairwise(told["ours"]))
    piece = ours[200:1200]
    windows = np.lib.stride_tricks.sliding_window_view(theirs, len(piece))
    assert np.abs(windows - piece).max(axis=1).min() < 1e-6  # it prints six decimals


def test_a_sampler_without_a_free_channel_is_told_with_the_line_that_helps(inside):
    told = inside(
        "taken", "loadrt sampler depth=4000 cfg=f\naddf sampler.0 servo-thread\nnet x-pos-cmd => sampler.0.pin.0"
    )
    assert told["same"] == [] and "cfg=...,ffffb" in told["said"]


WRONG = [
    ("x-pos-fb", "x-pos-fbk", "did you mean x-pos-fb"),
    ('"pid.x.error"', '"pid.x.Igain"', "an input that no signal drives"),
    ('"pid.x.error"', '"wave.update.tmax"', "is a parameter of HAL"),
    ('"servo-thread"', '"servo"', "did you mean servo-thread"),
    ("period_s = 0.001", "period_s = 0.002", "has 0.001 s"),
    ('hal = "pid.x.Pgain"', 'hal = "pid.x.enable"', "is a bit"),
    ('hal = "pid.x.Pgain"', 'hal = "pid.x.command"', "driven by the signal x-pos-cmd"),
    ('hal = "pid.x.Pgain"', 'hal = "pid.x.output"', "is written by its component"),
    ('hal = "pid.x.Pgain"', 'hal = "pid.x.pgain"', "did you mean pid.x.Pgain"),
    ('hal = "pid.x.Pgain"', 'hal = "gain.x"', "'home'"),
    ('hal = "pid.x.Pgain"', 'hal = "wave.update.tmax"', "s32"),
    ("high = 120.0\nsafe = 20.0", "high = 15.0\nsafe = 5.0", "is 20 now, outside of [0, 15]"),
]


def test_a_file_that_does_not_fit_is_refused_with_a_sentence_and_hal_untouched(inside):
    wrong = json.dumps([w[:2] for w in WRONG])
    told = inside("faults", "loadrt timedelay names=home-delay", wrong_json=wrong)
    for (_, _, words), (new, said, same) in zip(WRONG, told["said"], strict=True):
        assert words in said and said.startswith("file: "), (new, said)
        assert same == [], (new, same)


def test_a_change_is_seen_within_a_few_ticks(inside):
    told = inside("latency")
    shown = told["shown"]
    assert shown[len(shown) // 2] <= 4


def test_the_whole_panel_attaches_shows_writes_and_leaves(inside):
    told = inside("served")
    assert told["set"]["ok"], told["set"]
    assert told["getp"] == 100.0
    assert not told["start"]["ok"] and "never starts" in told["start"]["error"]
    assert told["same"] == [] and told["left"] == 20.0 and told["code"] == 0


def test_a_person_sees_the_real_machine_and_types_a_gain(inside):
    if shutil.which("chromium") is None:
        missing("chromium", "Chromium is not installed")
    told = inside("in_browser")
    assert told["getp"] == 100.0 and told["wrong"] == []
    assert "REAL MACHINE: X axis" in told["notice"]
    assert told["buttons"] == [True, True, True, False]
    error = np.array(told["seen"])
    assert np.sqrt(np.mean(error[-1000:] ** 2)) == pytest.approx(rms_theory(100.0), rel=0.1)
    assert np.abs(error[:2000]).max() > 1.2  # 1.5 mm with the gain that it had before
