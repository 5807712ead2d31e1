"""The file of a HAL: what is wrong is told by file and key; what enables or stops is refused by rule."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from leadscrew.panel.hal import machine, plan, show, write_policy
from leadscrew.panel.hal.file import parsed, read
from leadscrew.util.errors import DataError

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "panel_hal.md").read_text(encoding="utf-8")
FILE = re.search(r"```toml\n(.*?)```", PAGE, re.S)[1]
# As ``halcmd -s show`` of LinuxCNC 2.9 prints a HAL with an axis, an E-stop chain and the user interface.
SHOWN = {
    "pin": """
pid float IN 0 pid.x.Dgain
pid float IN 20 pid.x.Pgain
pid float IN 0 pid.x.FF1
pid float IN 0 pid.x.bias
pid float IN 0.01 pid.x.command <== x-pos-cmd
pid bit   IN TRUE pid.x.enable <== x-enable
pid bit   IN TRUE pid.x.error-previous-target
pid float OUT 0.006 pid.x.error
pid float IN 0.006 pid.x.feedback <== x-pos-fb
pid float OUT 0.006 pid.x.output ==> x-vel-cmd
pid bit   OUT FALSE pid.x.saturated
pid u32   I/O 50 pid.x.tune-cycles
integ float OUT 0.006 drive.out ==> x-pos-fb
integ float IN 1 gain.y
motmod float IN 0 joint.0.motor-offset
motmod bit   IN FALSE motion.enable
motmod float IN 1 motion.adaptive-feed
halui float IN 0 halui.feed-override.scale
estop_latch float IN 0 latch.0.level
hm2_eth float IN 1 hm2_7i92.0.pwmgen.00.scale
hm2_eth u32   IN 5000000 hm2_7i92.0.watchdog.timeout_ns
timedelay float IN 0.5 spindle-brake.off-delay
__servo-thread s32   OUT 1846 servo-thread.time
""",
    "param": "pid s32   RW 2496 pid.x.do-pid-calcs.tmax\nhm2_eth float RO 4 hm2_7i92.0.rate\n",
    "sig": "float 0.01 x-pos-cmd ==> pid.x.command\nfloat 0.006 x-pos-fb <== drive.out ==> pid.x.feedback\n"
    "float 0.006 x-vel-cmd <== pid.x.output\nbit TRUE x-enable ==> pid.x.enable\n",
    "comp": "24 User halcmd24 24 ready\n16 User halui 10 ready\n11 RT pid ready\n12 RT integ ready\n"
    "13 RT motmod ready\n14 RT estop_latch ready\n15 RT hm2_eth ready\n"
    "17 RT timedelay ready\n5 RT __servo-thread ready\n",
    "funct": "pid 7fc4 7fc5 YES 1 pid.x.do-pid-calcs\nintegr 7fc4 7fc5 YES 1 drive\n",
    "thread": "1000000 YES servo-thread 1274 69108 pid.x.do-pid-calcs drive\n",
    "alias": "gain.y spindle-brake.off-delay\n",
}
HAL = show.listed(SHOWN)


def test_the_file_of_the_page_fits_and_makes_the_plots_that_it_names():
    file = parsed(FILE, "f.toml")
    asked = plan.plan(file, HAL)
    assert asked["kinds"] == "ffffb" and asked["loaded"] and asked["load"][0] == "depth=4000"
    assert asked["nets"][0] == [False, "x-pos-cmd", "sampler.0.pin.0"]
    assert asked["nets"][2] == [True, "leadscrew.2", "pid.x.error", "sampler.0.pin.2"]
    told = machine.describe(file, {"pid.Pgain": 20.0, "pid.FF1": 0.0}, {"pid.Pgain": 25.0, "pid.FF1": 0.0})
    gain = told["parameters"][0]
    assert (gain["group"], gain["label"], gain["low"], gain["high"], gain["value"]) == (
        "pid",
        "Pgain",
        0.0,
        120.0,
        25.0,
    )
    assert told["plots"][1]["traces"][0] == {"signal": "pid.x.error", "label": "following error", "role": "error",
                                             "factor": 1000.0, "unit": "um"}  # fmt: skip


def test_without_plots_there_is_one_for_each_kind_and_unit():
    text = FILE[: FILE.index("[[plots]]")]
    titles = [p["title"] for p in machine.plots(parsed(text, "f.toml"))]
    assert titles == ["Command and feedback", "Error", "Output", "Other"]


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('kind = "hal"', 'kind = "machine"', "kind = 'machine': expected kind = 'hal'"),
        ("schema_version = 1", "schema_version = 2", "schema_version"),
        ("window_s = 10.0", "windows_s = 10.0", "there is no key 'windows_s'; did you mean window_s"),
        ("period_s = 0.001", "period_s = -1.0", "period_s = -1.0"),
        ("low = 0.0\nhigh = 120.0", "low = 130.0\nhigh = 120.0", "low = 130 is not below high = 120"),
        ("safe = 20.0", "safe = 200.0", "parameters.1: safe = 200 is not in [0, 120]"),
        ("high = 120.0\n", "high = inf\n", "parameters.1.high"),
        ("high = 120.0\n", "high = true\n", "parameters.1.high"),
        ("high = 120.0\n", "", "the key 'parameters.1.high' is missing"),
        ("rate = 1.0", "rate = 0.01", "more than 10 s from low to high: give 0.12 or more"),
        ('role = "error"', 'role = "errors"', "signals.3.role"),
        ('hal = "pid.x.FF1"', 'hal = "pid.x.Pgain"', "'pid.x.Pgain' is there twice"),
        ('sources = ["x-vel-cmd"]', 'sources = ["x-vel"]', "did you mean x-vel-cmd"),
        ('sources = ["x-vel-cmd"]', 'sources = ["x-vel-cmd", "x-pos-fb"]', "one plot has one shown unit"),
        ('source = "x-pos-cmd"', 'source = "x-pos-cmd; stop"', "signals.1.source"),
        ("schema_version = 1", "schema_version == 1", "cannot be read as TOML"),
    ],
)
def test_a_wrong_file_is_refused_by_name_and_key(old, new, words):
    assert old in FILE
    with pytest.raises(DataError, match=re.escape(words)) as error:
        parsed(FILE.replace(old, new, 1), "f.toml")
    assert str(error.value).startswith("f.toml")


def test_a_file_that_is_not_there_is_told(tmp_path):
    with pytest.raises(DataError, match=r"none\.toml: cannot be read"):
        read(tmp_path / "none.toml")


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("pid.x.enable", "is a bit"),
        ("pid.x.error-previous-target", "is a bit"),
        ("motion.enable", "is a bit"),
        ("pid.x.command", "driven by the signal x-pos-cmd"),
        ("pid.x.output", "is written by its component"),
        ("pid.x.tune-cycles", "type = 'float'"),
        ("joint.0.motor-offset", "belongs to motmod"),
        ("motion.adaptive-feed", "belongs to motmod"),
        ("halui.feed-override.scale", "outside real time"),
        ("latch.0.level", "belongs to estop_latch"),
        ("gain.y", "'brake'"),
        ("spindle-brake.off-delay", "'brake'"),
        ("hm2_7i92.0.rate", "may only be read"),
        ("pid.x.none", "is not in this HAL"),
    ],
)
def test_what_enables_stops_moves_or_guards_is_refused(name, words):
    assert words in write_policy.refused(name, "float", HAL)


def test_whole_numbers_of_a_watchdog_and_of_the_thread_are_refused():
    assert "watchdog" in write_policy.refused("hm2_7i92.0.watchdog.timeout_ns", "int", HAL)
    assert "'tmax'" in write_policy.refused("pid.x.do-pid-calcs.tmax", "int", HAL)
    assert "servo-thread" in write_policy.refused("servo-thread.time", "float", HAL) or write_policy.refused(
        "servo-thread.time", "int", HAL
    )


@pytest.mark.parametrize("name", ["pid.x.Pgain", "pid.x.FF1", "pid.x.bias", "hm2_7i92.0.pwmgen.00.scale"])
def test_gains_may_be_written(name):
    assert write_policy.refused(name, "float", HAL) == ""


@pytest.mark.parametrize(
    "name",
    ["x.e-stop-delay", "X.EStop.level", "enabling", "drive-en", "axis.0.scale", "amp0.gain", "homing-speed",
     "home2.speed", "spindle-on-delay", "machine-is-on", "safety.level", "sto-delay",
     "charge-pump.rate", "emc.x", "run.speed"],
)  # fmt: skip
def test_names_that_enable_or_stop_are_refused_in_any_spelling(name):
    assert write_policy.by_name(name)


def test_a_sampler_that_is_read_by_somebody_is_not_taken():
    pins = SHOWN["pin"] + "sampler bit IN TRUE sampler.0.enable\n" + "".join(
        f"sampler {kind} IN 0 sampler.0.pin.{i}\n" for i, kind in enumerate(("bit", "float", "float", "float", "float"))
    )  # fmt: skip
    shown = {**SHOWN, "pin": pins, "comp": SHOWN["comp"] + "30 RT sampler ready\n",
             "funct": SHOWN["funct"] + "sampler 7fc4 7fc5 YES 0 sampler.0\n"}  # fmt: skip
    asked = plan.plan(parsed(FILE, "f.toml"), show.listed(shown))
    assert not asked["loaded"] and asked["columns"] == [1, 2, 3, 4, 0]
    with pytest.raises(show.HalRefused, match=r"cfg=\.\.\.,ffffb"):
        plan.plan(
            parsed(FILE, "f.toml"), show.listed({**shown, "comp": shown["comp"] + "31 User halsampler0 9 ready\n"})
        )
