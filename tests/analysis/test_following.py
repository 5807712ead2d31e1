"""Following errors: lags that are known, rounding, rows out of order, counters that wrap, refusals."""

import numpy as np
import pytest

from leadscrew.analysis.following import Log, following, lag_of_error, pair_of, read_logs, shift
from leadscrew.analysis.following_anomalies import Track, decimals, digits, faults, period_of, steps, stretches, wrap_of
from leadscrew.util.errors import DataError, ValueRefused

T, LAG = 0.01, 0.0123


def wandering(seconds=60.0, period=T, seed=1):
    """Smooth command, and an actual position that is the command ``LAG`` earlier: exact, from the sines themselves."""
    rng = np.random.default_rng(seed)
    t = np.arange(round(seconds / period)) * period
    waves = [(rng.uniform(2, 20), rng.uniform(0.05, 0.5), rng.uniform(0, 6)) for _ in range(5)]

    def at(times):
        position = sum(a * np.sin(2 * np.pi * f * times + p) for a, f, p in waves)
        speed = sum(2 * np.pi * f * a * np.cos(2 * np.pi * f * times + p) for a, f, p in waves)
        return position, speed

    (c, cv), (a, av) = at(t), at(t - LAG)
    return Track("X", c, a, cv, av)


def test_a_pure_delay_is_found_by_the_shift_to_a_hundredth_of_a_period():
    x = wandering()
    one = np.zeros(len(x.command), int)
    found = shift(x.command_speed, x.actual_speed, one, np.arange(len(one)) // 100, T)
    assert found.value == pytest.approx(LAG, abs=0.01 * T)


def test_the_shift_of_several_periods_is_found_too():
    x = wandering()
    one = np.zeros(len(x.command) - 7, int)
    found = shift(x.command_speed[7:], x.actual_speed[:-7], one, np.arange(len(one)) // 100, T)
    assert found.value == pytest.approx(LAG + 7 * T, abs=0.01 * T)


def test_a_loop_with_a_velocity_gain_shows_its_inverse_as_lag():
    kv, v = 40.0, np.repeat([30.0, -10.0, 5.0, -30.0], 200)
    found = lag_of_error(v / kv + 0.02, v, np.zeros(800), np.arange(800) // 20)
    assert found.value == pytest.approx(1.0 / kv, rel=1e-9)
    assert found.low <= found.value <= found.high


def test_intervals_of_the_lag_hold_the_truth_in_about_95_of_100_noisy_logs():
    rng, held = np.random.default_rng(5), 0
    for _ in range(400):
        v = rng.uniform(-50, 50, 300)
        shared = np.repeat(rng.normal(size=30), 10)  # errors within a group are alike
        found = lag_of_error(
            0.008 * v + 0.1 * shared + 0.05 * rng.normal(size=300), v, np.ones(300), np.repeat(range(30), 10)
        )
        held += found.low <= 0.008 <= found.high
    assert 0.92 <= held / 400 <= 0.98


def test_an_axis_that_moved_one_way_says_that_an_offset_would_count_as_lag():
    v = np.linspace(10.0, 20.0, 100)
    found = lag_of_error(0.01 * v, v, np.zeros(100), np.arange(100) // 10)
    assert found.value == pytest.approx(0.01) and "one way" in found.why


def test_rounding_that_meets_the_same_places_every_period_widens_the_interval():
    # 3 mm/s in periods of 0.1 s is 3 steps of 0.1 mm: rounding never averages out, the true lag of 8 ms reads 33.3.
    v = np.full(200, 3.0)
    command = 0.02 + 0.3 * np.arange(200)
    error = np.round(command, 1) - np.round(command - 0.008 * 3.0 - 0.05, 1)
    found = lag_of_error(error, v, np.full(200, 0.1), np.arange(200) // 10, 0.1)
    assert found.value == pytest.approx(0.1 / 3.0) and found.half == pytest.approx(0.1 / 6.0, rel=1e-6)


def test_three_written_digits_are_a_step_of_1_above_100_and_of_a_tenth_below():
    written = np.array([141.0, 198.0, 72.4, 99.9, 8.53, 0.0])
    assert digits(written) == 3 and decimals(written) == 2
    assert steps(written) == pytest.approx([1.0, 1.0, 0.1, 0.1, 0.01, 0.01])
    assert digits(np.array([np.pi, 1.0])) is None
    assert steps(np.array([0.25, 12.75, 100.5])) == pytest.approx([0.01, 0.01, 0.1])


def test_a_log_cut_and_shuffled_is_evaluated_stretch_by_stretch_and_called_out_of_order():
    x = wandering(60.0)
    order = np.concatenate(
        [np.arange(k, k + 100) for k in np.random.default_rng(2).permutation(np.arange(0, 6000, 100))]
    )
    mixed = Track("X", *(c[order] for c in (x.command, x.actual, x.command_speed, x.actual_speed)))
    found = following([Log("mixed", {"X": mixed}, T)])
    cuts = stretches([mixed], T)
    assert 30 <= cuts[-1] <= 59
    assert [f.kind for f in found.findings["mixed"]] == ["order"]
    assert f"jumps {cuts[-1]} times" in found.findings["mixed"][0].sentence
    # The error of a pure delay is the lag times the speed, to second order.
    assert found.together[0].shift.value == pytest.approx(LAG, abs=0.02 * T)
    in_order = following([Log("kept", {"X": x}, T)])
    assert not in_order.findings["kept"]
    assert found.together[0].lag.value == pytest.approx(in_order.together[0].lag.value, rel=1e-12)


def test_a_counter_that_wraps_between_command_and_actual_makes_no_error():
    t = np.arange(2000) * T
    run = 53.0 * t
    c, a = (np.mod(run - late + 500.0, 100.0) - 50.0 for late in (0.0, 0.4))
    track = Track("S", c, a, np.full(2000, 53.0), np.full(2000, 53.0))
    found = following([Log("spindle", {"S": track}, T)])
    assert wrap_of(track, T) == pytest.approx(100.0, abs=0.6)
    assert found.together[0].worst == pytest.approx(0.4, abs=0.6)
    assert found.findings["spindle"][0].kind == "wrap" and stretches([track], T)[-1] == 0


def test_torn_frozen_and_double_rows_are_named_and_the_torn_one_left_out():
    x = wandering()
    c = x.command.copy()
    c[500] += 60.0
    table = np.column_stack([c, x.actual])
    table[900] = table[899]
    table[1000] = table[10]
    found = following([Log("odd", {"X": Track("X", c, x.actual, x.command_speed, x.actual_speed)}, T, None, table)])
    said = {f.kind: f.sentence for f in found.findings["odd"]}
    assert "data row 501" in said["torn"] and "1 row equal" in said["frozen"] and "1 row stands" in said["duplicate"]
    assert found.together[0].rows == len(c) - 1 and found.together[0].worst < 30.0


def test_phases_are_counted_without_regard_to_capitals_and_means_go_by_direction():
    v = np.tile(np.repeat([10.0, -10.0], 50), 4)
    c = np.cumsum(v) * T
    log = Log("a", {"X": Track("X", c, c - 0.01 * v - 0.05, v, v)}, T, ["End", "end", "Cut", "cut "] * 100)
    found = following([log])
    rows = {r.phase: r for r in found.together}
    assert list(rows) == ["all", "cut", "end"] and rows["end"].rows == 200
    assert rows["all"].mean_forward == pytest.approx(0.15) and rows["all"].mean_backward == pytest.approx(-0.05)
    assert rows["all"].lag.value == pytest.approx(0.01) and rows["all"].gain.value == pytest.approx(100.0)
    assert sum(f.kind == "label" for f in found.findings["a"]) == 2


def test_a_wrong_period_is_noticed_from_positions_and_velocities():
    x = wandering()
    wrong = following([Log("a", {"X": x}, 10 * T)])
    assert any(f.kind == "period" and "0.01 s" in f.sentence for f in wrong.findings["a"])
    assert period_of([x], np.zeros(len(x.command), int)) == pytest.approx(T, rel=0.01)


@pytest.mark.parametrize(
    ("logs", "said"),
    [
        ([], "expected one log or more"),
        ([Log("a", {}, 0.1)], "has no axis"),
        ([Log("a", {"X": Track("X", np.zeros(2), np.zeros(2))}, 0.1)], "2 rows"),
        ([Log("a", {"X": wandering()}, -1.0)], "period = -1.0"),
        ([Log("a", {"X": wandering()}, 0.1), Log("b", {"X": wandering()}, 0.2)], "b: period 0.2 s, but a has 0.1 s"),
    ],
)
def test_what_cannot_be_evaluated_is_refused_in_a_sentence(logs, said):
    with pytest.raises((ValueRefused, DataError), match=said):
        following(logs)


def test_files_without_times_need_a_period_and_files_without_axes_a_pair(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("cmd,act\n" + "\n".join(f"{k},{k - 0.5}" for k in range(50)) + "\n")
    with pytest.raises(DataError, match=r"--period 0\.1"):
        read_logs([path])
    with pytest.raises(DataError, match="--pair X=COMMAND,ACTUAL"):
        read_logs([path], period=0.1)
    (log,) = read_logs([path], period=0.1, pairs=dict([pair_of("X=cmd,act")]))
    row = following([log]).together[0]
    assert row.worst == row.rms == 0.5 and row.mean_forward == 0.5 and row.lag.value == pytest.approx(0.05)
    with pytest.raises(ValueRefused, match="AXIS=COMMAND,ACTUAL"):
        pair_of("cmd,act")
    with pytest.raises(DataError, match="named twice"):
        read_logs([path, path], period=0.1)


def test_a_column_of_times_gives_the_period_and_velocities_are_differences_where_none_are_logged(tmp_path):
    x = wandering(20.0)
    path = tmp_path / "b.csv"
    rows = np.column_stack([np.arange(len(x.command)) * T, x.command, x.actual])
    np.savetxt(path, rows, delimiter=",", header="time,command,feedback", comments="")
    (log,) = read_logs([tmp_path])
    found = following([log])
    assert log.period == pytest.approx(T) and list(log.tracks) == ["axis"]
    assert found.together[0].shift.value == pytest.approx(LAG, abs=0.05 * T)
    assert [f.kind for f in found.findings[str(path)]] == ["order"]


def quick(seconds=6.0, period=1e-3):
    """A command in mm at 1 kHz and an axis that follows 5 ms later."""
    t = np.arange(round(seconds / period)) * period

    def at(times):
        return 50.0 * np.sin(1.3 * times) + 20.0 * np.sin(3.1 * times)

    return t, at(t), at(t - 0.005)


def written(folder, header, *columns):
    path = folder / "log.csv"
    np.savetxt(path, np.column_stack(columns), delimiter=",", header=header, comments="", fmt="%.9g")
    return path


def odd(path, **more):
    logs = read_logs([path], **more)
    (findings,) = following(logs).findings.values()
    return {f.kind: f.sentence for f in findings}


def test_units_of_the_headers_are_kept_and_actual_values_in_another_one_are_taken_to_it(tmp_path):
    t, command, actual = quick()
    path = written(tmp_path, "time [ms],command [mm],position [m]", 1e3 * t, command, 1e-3 * actual)
    row = following(read_logs([path])).together[0]
    assert row.unit == "mm" and row.lag.value == pytest.approx(0.005, rel=0.01)
    assert row.as_dict()["unit"] == "mm" and row.as_dict()["max"] == row.worst and row.lag.rows == row.moving
    plain = written(tmp_path, "time,command,position", 1e3 * t, command, 1e-3 * actual)
    told = {"time": "ms", "command": "mm", "actual": "m"}
    again = following(read_logs([plain], units=told)).together[0]
    assert again.lag == row.lag and again.unit == "mm"
    with pytest.raises(ValueRefused, match="furlong"):
        read_logs([plain], units={"position": "furlong"})
    with pytest.raises(ValueRefused, match="--unit drive=N: allowed are time, position"):
        read_logs([plain], units={"drive": "N"})
    with pytest.raises(DataError, match="expected both along or both around"):
        read_logs([plain], units={"time": "ms", "command": "mm", "actual": "deg"})


def test_logged_velocities_in_another_unit_are_taken_to_that_of_the_command(tmp_path):
    t, command, actual = quick()
    v = np.gradient(command, t)
    head = "time [s],command [mm],position [mm],command_velocity [mm/min],velocity [mm/min]"
    path = written(tmp_path, head, t, command, actual, 60.0 * v, 60.0 * np.gradient(actual, t))
    row = following(read_logs([path])).together[0]
    # A lag of five periods tears no row.
    assert row.rows == len(t) and row.lag.value == pytest.approx(0.005, rel=0.01)
    assert row.top_speed == pytest.approx(np.abs(v).max(), rel=1e-6)


def test_an_axis_in_two_units_in_two_logs_is_refused(tmp_path):
    t, command, actual = quick(1.0)
    for name, unit in (("a", "mm"), ("b", "m")):
        (tmp_path / name).mkdir()
        written(tmp_path / name, f"time [s],command [{unit}],position [{unit}]", t, command, actual)
    with pytest.raises(ValueRefused, match=r"axis is in mm in .*, m in .*: compare logs in one unit"):
        following(read_logs([tmp_path / "a" / "log.csv", tmp_path / "b" / "log.csv"]))


def test_columns_that_log_knows_are_found_where_there_is_one_of_each(tmp_path):
    t, command, actual = quick(2.0)
    path = written(tmp_path, "time (s),angle (deg),torque (N m),reference (deg)", t, actual, 0.0 * t, command)
    (log,) = read_logs([path])
    assert np.allclose(log.tracks["axis"].command, command) and log.tracks["axis"].unit == "deg"


def test_a_part_of_the_time_is_taken_and_a_gap_outside_of_it_does_no_harm(tmp_path):
    t, command, actual = quick()
    late = np.where(t > 5.5, t + 2.0, t)
    path = written(tmp_path, "time,command,position", late, command, actual)
    with pytest.raises(DataError, match="--start"):
        read_logs([path])
    (log,) = read_logs([path], end=5.0)
    assert len(log.tracks["axis"].command) == 5001
    with pytest.raises(DataError, match=r"no row from 50 to inf s: its rows are of 0 to 7\.999 s"):
        read_logs([path], start=50.0)


def test_what_cannot_be_one_axis_is_said(tmp_path):
    t, command, actual = quick()
    head = "time [s],command [mm],position [mm]"
    good = odd(written(tmp_path, head, t, command, actual))
    assert set(good) == {"order"}
    jump = np.where(t >= 4.0, actual + 4.0, actual)
    said = odd(written(tmp_path, head, t, command, jump))
    assert "jumps once where the command does not, most by 4 mm at data row 4001" in said["jump"]
    spike = actual.copy()
    spike[4000] += 4.0
    assert "jump" in odd(written(tmp_path, head, t, command, spike))
    force = 33.0 * np.sign(np.gradient(actual))
    assert "hardly one signal" in odd(written(tmp_path, head, t, command, force))["unlike"]
    fast = odd(written(tmp_path, head.replace("[mm]", "[m]"), t, command, actual))
    assert "--unit position=mm" in fast["unit"]


def test_a_jump_that_the_command_makes_too_is_no_fault_of_the_encoder_but_cuts_the_log(tmp_path):
    t, command, actual = quick()
    whole = following(read_logs([written(tmp_path, "time,command,position", t, command, actual)])).together[0]
    # Two pieces in the wrong order, without a velocity that would show it.
    order = np.r_[np.arange(3000, 6000), np.arange(3000)]
    path = written(tmp_path, "time,command,position", t, command[order], actual[order])
    (log,) = read_logs([path])
    cut = stretches(list(log.tracks.values()), log.period)
    assert cut[-1] == 1 and np.flatnonzero(np.diff(cut)) == [2999]
    said = odd(path)
    assert "jumps 1 time" in said["order"] and "jump" not in said
    row = following([log]).together[0]
    assert row.top_speed == pytest.approx(whole.top_speed, rel=1e-3)
    assert row.shift.value == pytest.approx(0.005, rel=0.01) and row.shift.rows <= whole.shift.rows - 4


@pytest.mark.parametrize(("lag", "most"), [(0.0, 0.15), (0.02, 0.55)])
def test_a_row_is_torn_from_one_and_a_half_periods_of_travel_and_twice_the_lag_on(lag, most):
    """10 mm/s in periods of 10 ms: 0.15 mm, and 0.4 mm more at a lag of 20 ms; the scale rounds to 1 um."""
    v = np.where(np.arange(400) % 100 < 50, 10.0, -10.0)
    command = np.round(np.cumsum(v) * 0.01 + 7.123, 3)
    for off, torn in ((most - 0.004, False), (most + 0.004, True)):
        actual = np.round(command - lag * v, 3)
        actual[230] = np.round(command[230] - off, 3)
        found = faults(Track("X", command, actual, v, v), 0.01)
        assert found[230] == torn and found.sum() == torn
