"""What is wrong with a log is said, with place, value and fix; what is well is not called wrong."""

import re

import numpy as np
import pytest
from typer.testing import CliRunner

from leadscrew.cli import app
from leadscrew.logs import axis_log, look_at, read_axis_log
from leadscrew.logs.measure import motion
from leadscrew.logs.plausible import check_drive
from leadscrew.logs.signals import check_clipped, check_constant, check_numbers, jumps
from leadscrew.util.errors import DataError
from tests.fuzzy.formats_systems import shared
from tests.logs.records import arrays, moves

TIME, DRIVE, POSITION, COMMAND = moves()
RNG = np.random.default_rng(4)


def log(**changes):
    return axis_log(**arrays(**changes))


def kinds(found, severity="warning"):
    return {f.kind for f in found.findings if f.severity == severity}


def without(first, last):
    kept = np.r_[0:first, last : len(TIME)]
    return {role: values[kept] for role, values in arrays().items()}


def later(values, at, by):
    return np.where(np.arange(len(values)) >= at, values + by, values)


def put(values, at, what):
    changed = values.copy()
    changed[at] = what
    return changed


def test_a_sound_log_passes_without_a_word():
    found = log()
    assert found.findings == []
    assert found.encoder_step == pytest.approx(1e-6, rel=1e-9) and found.period == pytest.approx(1e-3, rel=1e-12)


REFUSED = {
    "position in mm called m": ({"position": 1e3 * POSITION, "command": None}, "top (speed|acc).* unit is wrong"),
    "command in mm, position in m": ({"command": 1e3 * COMMAND}, "command moves 9.* times as far"),
    "times in ms called s": ({"time": 1e3 * TIME}, "period of 1 s is too long .* --unit time=ms"),
    "times in s called ms": ({"time": 1e-3 * TIME}, "period of 1e-06 s is too short"),
    "velocity in mm/s": ({"velocity": 1e3 * np.gradient(POSITION, 1e-3)}, "velocity is 1000 times the derivative"),
    "drive and position swapped": ({"drive": POSITION, "position": DRIVE}, "drive like a position.* swapped"),
    "no command": ({"drive": POSITION, "position": DRIVE, "command": None}, "like a position.* swapped"),
    "position and command swapped": ({"position": COMMAND, "command": POSITION}, "ahead of its command.* swapped"),
    "drive and command swapped": ({"drive": COMMAND, "command": DRIVE}, "position follows the drive.* swapped"),
    "standstill": ({"position": 0.1 + 1e-6 * RNG.integers(0, 3, len(TIME)), "command": None}, "axis is at rest"),
    "chatter": ({"position": 1e-7 * (np.arange(len(TIME)) % 2), "command": None}, "only 2 different values .* at rest"),
    "noise only": ({"position": 1e-5 * RNG.normal(size=len(TIME)), "command": None}, "times its noise: the axis"),
    "never moves": ({"position": np.full(len(TIME), 0.2), "command": None}, "in every sample: the axis is at rest"),
    "zeros": (dict.fromkeys(("time", "drive", "position", "command"), 0.0 * TIME), "are 0 in every sample"),
    "drive not recorded": ({"drive": np.full(len(TIME), 1.5)}, "drive is 1.5 in every sample"),
    "jump of the encoder": ({"position": later(POSITION, 1700, 2e-4)}, r"jumps once, by \+0.0002 m at sample 1701 "),
    "small jump": ({"position": later(POSITION, 1700, 3e-5), "command": None}, r"once, by \+3e-05 m at sample 1701"),
    "one bad sample": ({"position": put(POSITION, 900, 0.0)}, r"jumps once, .* sample 901 \(0.9 s, back in the next"),
    "several jumps": (
        {"position": later(later(later(POSITION, 500, 1e-4), 1500, -3e-4), 2500, 1e-4)},
        r"3 times, by \+0.0001 m at sample 501 .*-0.000\d+ m at sample 1501 .* m at sample 2501 ",
    ),
    "a gap": (without(1000, 1100), r"gap of 0.101 s before sample 1001 .* --start 1.1 --end 2.999"),
    "clock set back": ({"time": later(TIME, 2000, -0.7)}, r"sample 2001: the time 1.3 s lies before the 1.999 s"),
    "clock starts again": ({"time": later(TIME, 2000, -2.0)}, "sample 2001: the time starts again .* 2 records"),
    "double stamp": ({"time": put(TIME, 11, TIME[10])}, "sample 12 has the time 0.01 s of the one before"),
    "no number": ({"drive": put(DRIVE, [4, 9], np.nan)}, r"sample 5: the drive .* 1 more .*\(the last sample 10\)"),
    "infinite": ({"position": put(POSITION, 4, np.inf)}, "sample 5: the position is infinite"),
    "clock that drifts": ({"time": np.cumsum(1e-3 * np.linspace(1.0, 1.3, len(TIME)))}, "period drifts from 0.0010"),
}  # fmt: skip


@pytest.mark.parametrize("changes", REFUSED.values(), ids=REFUSED)
def test_what_cannot_be_is_refused_in_one_sentence(changes):
    signals, said = changes
    with pytest.raises(DataError) as error:
        log(**signals)
    assert re.search(said, str(error.value)), error.value
    assert str(error.value).startswith("arrays: ") and "\n" not in str(error.value)


@pytest.mark.parametrize("count", [0, 1, 2, 19])
def test_a_log_of_two_rows_is_refused(count):
    with pytest.raises(DataError, match=rf"has {count} samples?: at least 20 are needed"):
        axis_log(**{role: values[:count] for role, values in arrays().items()})


def test_a_position_in_m_called_mm_is_flagged():
    found = log(position=1e-3 * POSITION, command=1e-3 * COMMAND)
    said = " ".join(f.sentence for f in found.findings)
    assert kinds(found) == {"unit"} and "slow for an axis" in said and "those of a mass of 2.0" in said


def test_a_short_move_in_a_long_rest_is_not_called_slow():
    """Of 20 s it moves for 10 ms, less than a thousandth: its top speed must not be read off the rest."""
    time = 1e-3 * np.arange(20_000)
    position = 5e-4 * np.clip((time - 10.0) / 0.01, 0.0, 1.0)
    found = axis_log(time, RNG.normal(size=len(time)), position)
    assert "slow for an axis" not in " ".join(f.sentence for f in found.findings)


@pytest.mark.parametrize(("unit", "said"), [("kN", "a mass of 2.0"), ("mN", "a mass of 0.02")])
def test_a_force_wrong_by_a_thousand_is_flagged_by_the_mass_that_it_means(unit, said):
    found = axis_log(TIME, DRIVE, POSITION, drive_unit=unit)
    assert kinds(found) == {"unit"}
    assert said in found.findings[0].sentence and "wrong by 1000" in found.findings[0].sentence
    assert axis_log(TIME, DRIVE, POSITION).findings == []


def test_the_mass_is_judged_only_where_the_force_is_known():
    assert axis_log(TIME, 1e-3 * DRIVE, POSITION, drive_unit="V").findings == []
    assert axis_log(TIME, 1e-3 * DRIVE, POSITION, drive_unit="V", force_per_drive=1e3).findings == []
    told = axis_log(TIME, 1e-3 * DRIVE, POSITION, drive_unit="V", force_per_drive=1.0)
    assert "a mass of 0.02" in told.findings[0].sentence and "--force-per-drive" in told.findings[0].sentence
    # A screw of 10 mm: 20 kg are 5.1e-5 kg m^2, and a torque in kN m called N m makes 5.1e-8 of it.
    turn = 0.01 / (2.0 * np.pi)
    screw = {"time": TIME, "position": POSITION / turn, "position_unit": "rad", "drive_unit": "N m"}
    assert axis_log(drive=DRIVE * turn, **screw).findings == []
    found = axis_log(drive=1e-3 * DRIVE * turn, **screw)
    assert "an inertia of 5.2" in found.findings[0].sentence and "kN m" in found.findings[0].sentence


def test_of_two_columns_of_one_name_it_is_said_which_was_taken(tmp_path):
    path = tmp_path / "twice.csv"
    rows = np.column_stack([TIME, DRIVE, POSITION, COMMAND])
    np.savetxt(path, rows, delimiter=",", header="time_s,force_N,position_m,position_m", comments="")
    found = read_axis_log(path)
    assert kinds(found) == {"columns"}
    said = found.findings[0].sentence
    assert "2 columns called 'position_m'" in said and "--column 'position=position_m (2)'" in said
    other = read_axis_log(path, {"position": "position_m (2)"})
    np.testing.assert_array_equal(other.position, COMMAND)


def test_a_clipped_drive_is_flagged_with_where_and_a_switched_one_is_not():
    found = log(drive=np.clip(DRIVE, -20.0, 20.0))
    assert kinds(found) == {"clipped"} and len(found.findings) == 2
    assert "largest value 20 for " in found.findings[0].sentence
    assert log(drive=np.where(np.sin(9.0 * TIME) > 0.0, 20.0, -20.0)).findings == []


def test_a_constant_command_and_few_samples_are_flagged():
    assert kinds(log(command=np.full(len(TIME), 0.1))) == {"constant"}
    assert "rows" in kinds(axis_log(**{role: values[:150] for role, values in arrays().items()}))


def test_signs_that_are_turned_are_said():
    assert kinds(log(drive=-DRIVE), "note") == {"sign"}
    assert kinds(log(velocity=-np.gradient(POSITION, 1e-3))) == {"sign"}
    assert kinds(log(command=-COMMAND)) == {"sign"}
    assert log(velocity=np.gradient(POSITION, 1e-3)).findings == []


def test_an_angle_that_turns_over_is_to_be_unwrapped():
    angle = 40.0 * POSITION / POSITION.max()
    with pytest.raises(DataError, match=r"turns over by a whole turn .* unwrap"):
        axis_log(TIME, DRIVE, np.mod(angle, 2.0 * np.pi), position_unit="rad")
    assert axis_log(TIME, DRIVE, angle, position_unit="rad").unit.position == "rad"


def test_a_clock_that_jitters_is_flagged_and_put_on_a_grid_to_which_position_and_drive_belong():
    stamps = TIME + 1e-4 * RNG.uniform(-1.0, 1.0, len(TIME))
    smooth = 0.05 * np.sin(3.0 * stamps)
    found = axis_log(stamps, DRIVE, smooth)
    assert kinds(found) == {"jitter"} and re.search(r"scatter by \d\.\d+ % of the period", found.findings[0].sentence)
    np.testing.assert_allclose(np.diff(found.time), found.period, rtol=1e-9)
    # On straight lines between true samples: error below T^2 max|x''| / 8.
    np.testing.assert_allclose(found.position, 0.05 * np.sin(3.0 * found.time), atol=1e-7)
    assert np.abs(smooth - 0.05 * np.sin(3.0 * found.time)).max() > 1e-5
    assert set(found.drive) <= set(DRIVE)


def test_stamps_that_were_rounded_are_even_and_values_stay_as_they_are():
    fine = 0.25 * TIME
    found = axis_log(np.round(fine, 3), DRIVE, 0.25 * POSITION)
    assert kinds(found, "note") == {"clock"} and found.period == pytest.approx(2.5e-4, rel=1e-5)
    np.testing.assert_array_equal(found.position, 0.25 * POSITION)
    np.testing.assert_allclose(found.time, fine, atol=6e-4)


def test_a_slow_record_whose_position_and_command_jump_together_is_not_whole():
    position = later(later(100.0 * np.sin(0.01 * np.arange(1000)), 300, 40.0), 700, -40.0) * 1e-3
    found = axis_log(0.1 * np.arange(1000), RNG.normal(size=1000), position, position + 1e-5)
    assert kinds(found) >= {"rate", "record"}
    assert "2 times, by +0.04 m at sample 301" in next(f.sentence for f in found.findings if f.kind == "record")


@pytest.mark.parametrize("step", [0.0, 1e-9, 1e-6, 2e-5])
@pytest.mark.parametrize("seed", range(3))
def test_no_noise_or_quantisation_makes_a_sound_log_a_broken_one(step, seed):
    rng = np.random.default_rng(seed)
    noisy = POSITION + rng.normal(0.0, 2e-6, len(TIME))
    found = log(
        position=np.round(noisy / step) * step if step else noisy, drive=DRIVE + rng.normal(0.0, 1.0, len(TIME))
    )
    assert found.findings == []
    if step >= 1e-6:
        assert found.encoder_step == pytest.approx(step, rel=1e-6)
    assert found.noise == pytest.approx(np.hypot(2e-6, step / np.sqrt(12.0)), rel=0.5)


def test_emps_passes_with_the_units_it_has():
    found = read_axis_log(shared("data/emps/DATA_EMPS.mat"), units={"drive": "V"})
    assert kinds(found) == set() and kinds(found, "note") == {"unit"}
    assert (found.period, found.unit) == (pytest.approx(1e-3, rel=1e-9), ("m", "V"))
    assert found.encoder_step == pytest.approx(5e-8, rel=1e-6)
    assert found.command is not None and len(found.time) == 24841


@pytest.mark.slow
@pytest.mark.parametrize("number", range(1, 19))
def test_every_axis_of_every_umich_file_that_was_recorded_is_read(number):
    path = shared(f"data/cnc_mill_umich/experiment_{number:02d}.csv")
    for axis, unit in (("X1", "mm"), ("Y1", "mm"), ("S1", "deg")):
        seen = look_at(
            path, {"position": f"{axis}_ActualPosition", "drive": f"{axis}_CurrentFeedback"},
            {"position": unit, "drive": "A"}, period=0.1,
        )  # fmt: skip
        assert seen.columns["command"] == f"{axis}_CommandPosition"
        assert seen.columns["velocity"] == f"{axis}_ActualVelocity"
        assert seen.log is not None and not [f for f in seen.findings if f.severity == "refused"]
        assert "rate" in kinds(seen.log)
    with pytest.raises(DataError, match="the drive is 0 in every sample"):
        read_axis_log(path, {"position": "Z1_ActualPosition", "drive": "Z1_CurrentFeedback"}, period=0.1)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("study", "controller", "scenario"),
    [("fsmc_ballscrew", "ours.pd_dob", "step_quintic"), ("vud_lathe", "corrected.vud_beta_e", "fig11a_step_m50")],
)
def test_our_own_runs_pass(study, controller, scenario, tmp_path):
    asked = ["simulate", study, "-c", controller, "-s", scenario, "--out", str(tmp_path / "run")]
    assert CliRunner().invoke(app, asked).exit_code == 0
    found = read_axis_log(tmp_path / "run")
    assert found.unit.position == "m" and found.encoder_step > 0.0


@pytest.mark.parametrize(
    ("counts", "kind"), [(5, "standstill"), (6, "step"), (20, "step"), (49, "step"), (50, ""), (400, "")]
)
def test_an_axis_stands_up_to_5_counts_and_its_speed_is_rounding_up_to_50(counts, kind):
    position = 1e-6 * np.concatenate([np.arange(counts + 1.0), np.arange(counts, 0.0, -1.0)])
    found = check_constant({"position": position, "drive": np.arange(len(position))}, 1e-6)
    assert [f.kind for f in found] == ([kind] if kind else [])
    assert not kind or found[0].severity == ("refused" if kind == "standstill" else "warning")


def test_a_value_above_a_million_millions_is_taken_for_the_wrong_column():
    assert check_numbers({"drive": np.array([0.0, -9.9e11])}, str) == []
    (found,) = check_numbers({"drive": np.array([0.0, -1.01e12])}, "sample {}".format)
    assert found.severity == "refused" and found.sentence.startswith("sample 1: the drive is -1.01e+12")


@pytest.mark.parametrize(("levels", "said"), [(29, False), (30, True)])
def test_a_drive_of_fewer_than_30_levels_is_switched_and_not_clipped(levels, said):
    up = np.arange(float(levels))
    drive = np.tile(np.concatenate([up, np.full(4, up[-1]), up[-2:0:-1]]), 3)
    found = check_clipped(drive, 1e-3 * np.arange(len(drive)), str)
    assert bool(found) is said and all(f"largest value {levels - 1}" in f.sentence for f in found)


@pytest.mark.parametrize(
    ("drive_off", "command_off", "swapped"), [(0.03, 0.5, True), (0.06, 0.5, False), (0.03, 0.2, False)]
)
def test_a_drive_is_taken_for_a_command_where_the_position_follows_it_to_a_thousandth(drive_off, command_off, swapped):
    """A part of cos to sin is a correlation of 1 / sqrt(1 + part^2): 0.9996, 0.9982; of the command 0.894, 0.981."""
    t = 1e-3 * np.arange(4000)
    sine, cosine = np.sin(np.pi * t), np.cos(np.pi * t)
    arrays = {"position": sine, "drive": sine + drive_off * cosine, "command": sine + command_off * cosine}
    found = check_drive(arrays, motion(sine, 1e-3), 1e-3, "m", None)
    assert ("swapped" in [f.kind for f in found]) is swapped


@pytest.mark.parametrize(
    ("every", "ramp", "period", "scale", "largest"),
    [
        (0.0, 0.0, 1e-3, (1.0, 0.0), 4.5),  # counts of 1: four and a half of them
        (0.0, 0.0, 1e-3, (0.0, 1.0), 12.0),  # noise of 1: twelve times
        (1.0, 0.0, 1e-3, (0.0, 0.0), 9.0),  # two of five steps stand out by 1 anyhow: eight times, beyond a step of 1
        (0.0, 100.0, 1e-3, (0.0, 0.0), 5.0),  # steps of 100: a twentieth
        (0.0, 1.0, 5e-3, (0.0, 0.0), 2.0),  # of a slow log: twice the usual step
    ],
)
def test_a_jump_is_what_stands_out_from_counts_noise_scatter_and_speed(every, ramp, period, scale, largest):
    k = np.arange(2000)
    smooth = every * (k % 5 == 0) + ramp * k
    for size, seen in ((0.97 * largest, False), (1.03 * largest, True)):
        found, sizes = jumps(smooth + size * (k >= 1003), period, *scale)
        assert found.tolist() == ([1003] if seen else []), size
        assert not seen or sizes[0] == pytest.approx(size)
