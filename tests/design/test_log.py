"""Logs at the door of a design: what is read, what is put right and said, what is refused in one sentence."""

import math

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from leadscrew.design import Move, MoveLog, read_moves
from leadscrew.design.files import checked
from leadscrew.util.errors import DataError, NameUnknown, ValueRefused
from tests.design.moves import TABLE_1, glide, rows, swapped, write

SIGNALS = ("time", "command", "feedback", "output")


def test_the_sign_of_ec_is_put_right_where_the_target_is_positive_and_that_is_said():
    log = read_moves(TABLE_1)
    assert log.turned == ("r=50", "r=190")
    by_name = {m.name: m for m in log.moves}
    assert by_name["r=50"].change[1] == -0.420 and by_name["r=-50"].change[1] == 0.423
    for move in log.moves:
        assert np.sign(move.change[1:10]).tolist() == np.sign(np.diff(move.error)[:9]).tolist()


def test_one_unit_of_ec_is_the_change_that_the_digest_found():
    log = read_moves(TABLE_1)
    found = [190.0 * log.scale((m,))[0] for m in log.moves]
    assert found == pytest.approx([25.93, 25.50, 25.88, 26.03], abs=0.005)


@pytest.mark.parametrize("only", [None, "-190", "-50", "50", "190"])
@pytest.mark.parametrize("pair", [("ec", "rho"), ("e", "ec"), ("e", "rho")])
def test_swapped_columns_are_refused_and_named(tmp_path, pair, only):
    path = write(tmp_path / "log.csv", swapped(*pair, only))
    with pytest.raises(DataError, match="columns look swapped") as said:
        read_moves(path)
    new = dict(zip(pair, reversed(pair), strict=True))
    assert f"{new.get('ec', 'ec')} is the change of {new.get('e', 'e')} per row" in str(said.value)


@pytest.mark.parametrize("pair", [("k", "r"), ("k", "e"), ("k", "rho"), ("r", "e"), ("r", "ec"), ("r", "rho")])
def test_swaps_with_the_number_or_the_target_are_refused(tmp_path, pair):
    with pytest.raises(DataError):
        read_moves(write(tmp_path / "log.csv", swapped(*pair)))


def test_every_move_of_table_1_alone_is_accepted(tmp_path):
    for r in ("-190", "-50", "50", "190"):
        log = read_moves(write(tmp_path / "log.csv", [row for row in rows() if row["r"] == r]))
        assert [m.name for m in log.moves] == [f"r={r}"] and log.rows == 20


def test_three_rows_are_too_few(tmp_path):
    with pytest.raises(DataError, match=r"log\.csv: 2 rows after the start of a move: a rule base needs 10 at least"):
        read_moves(write(tmp_path / "log.csv", rows()[:3]))


def test_ten_rows_after_the_start_of_a_move_are_enough(tmp_path):
    assert read_moves(write(tmp_path / "log.csv", rows()[:11])).rows == 10
    with pytest.raises(DataError, match="9 rows after the start of a move"):
        read_moves(write(tmp_path / "log.csv", rows()[:10]))


@pytest.mark.parametrize("column", ["e", "ec", "rho"])
def test_constant_data_is_refused(tmp_path, column):
    path = write(tmp_path / "log.csv", [{**r, column: "0.25"} for r in rows()])
    with pytest.raises(DataError, match=rf"{column} is always 0\.25"):
        read_moves(path)


def test_a_duty_of_the_other_sense_or_of_no_sense_is_refused(tmp_path):
    other = [{**r, "rho": -float(r["rho"])} for r in rows()]
    with pytest.raises(DataError, match="rho has the sign of e"):
        read_moves(write(tmp_path / "log.csv", other))
    none = [{**r, "rho": 0.1 * (-1) ** k} for k, r in enumerate(rows())]
    with pytest.raises(DataError, match="rho does not drive e to zero"):
        read_moves(write(tmp_path / "log.csv", none))


def test_columns_that_are_something_else_are_refused(tmp_path):
    noise = np.random.default_rng(1).uniform(-1.0, 1.0, (84, 3)).round(3)
    path = write(
        tmp_path / "log.csv",
        [{**r, "e": a, "ec": b, "rho": c} for r, (a, b, c) in zip(rows(), noise.tolist(), strict=True)],
    )
    with pytest.raises(DataError, match="ec is not the change of e per row"):
        read_moves(path)


def test_missing_columns_and_values_out_of_range_name_row_and_column(tmp_path):
    path = write(tmp_path / "log.csv", rows(), ("k", "r", "e", "rho"))
    with pytest.raises(DataError, match="the column 'ec' is missing"):
        read_moves(path)
    high = [*rows()]
    high[4] = {**high[4], "rho": "1.5"}
    with pytest.raises(DataError, match=r"row 6, column 'rho': 1\.5 is outside \[-1, 1\]"):
        read_moves(write(path, high))
    with pytest.raises(DataError, match="cannot be read"):
        read_moves(tmp_path / "none.csv")
    with pytest.raises(ValueRefused, match="one log at least"):
        read_moves([])
    with pytest.raises(ValueRefused, match="interval_s = 0"):
        read_moves(TABLE_1, 0.0)


# ---- signals against time
def test_signals_are_taken_every_interval_and_the_largest_change_between_any_two(tmp_path):
    path = write(tmp_path / "move.csv", glide(-80.0), SIGNALS)
    log = read_moves(path)
    (move,) = log.moves
    assert log.layout == "measured" and log.rows == 20 and not log.turned
    assert move.error == pytest.approx([-80.0 * math.exp(-0.4 * k) for k in range(21)])
    assert move.change[1:] == pytest.approx(np.diff(move.error))
    assert log.peak_change == pytest.approx(80.0 * (1.0 - math.exp(-0.4)))
    half = read_moves(path, 0.05)
    assert half.rows == 40 and half.peak_change == pytest.approx(80.0 * (1.0 - math.exp(-0.2)))


def test_times_in_ms_and_positions_in_m_give_the_same_moves_as_in_s_and_mm(tmp_path):
    si = read_moves(write(tmp_path / "a.csv", glide(-80.0), SIGNALS)).moves[0]
    size = {"time": 1e3, "feedback [m]": 1e-3, "command": 1.0, "output [%]": 1e2}
    names = ("time [ms]", "feedback [m]", "command", "output [%]")
    rows = [{n: r[n.split()[0]] * size.get(n, size.get(n.split()[0], 1.0)) for n in names} for r in glide(-80.0)]
    (move,) = read_moves(write(tmp_path / "b.csv", rows, names)).moves
    assert move.error == pytest.approx(si.error) and move.change == pytest.approx(si.change)
    assert move.duty == pytest.approx(si.duty)
    with pytest.raises(DataError, match=r"column 'feedback \[deg\]': is in deg; expected mm"):
        read_moves(
            write(
                tmp_path / "c.csv",
                [{"feedback [deg]": 1.0, **r} for r in rows],
                ("feedback [deg]", *names[:1], *names[2:]),
            )
        )


def test_the_largest_change_may_lie_between_the_samples(tmp_path):
    rest, way = glide(-80.0, seconds=0.5), glide(-80.0)
    late = [{**r, "command": 0.0, "feedback": 0.0, "output": 0.0} for r in rest[:6]]
    moved = [{**r, "time": r["time"] + 0.06} for r in way]
    path = write(tmp_path / "move.csv", [*late, *moved], SIGNALS)
    log = read_moves(path)
    assert [len(m.error) for m in log.moves] == [21]
    assert log.peak_change == pytest.approx(80.0 * (1.0 - math.exp(-0.4)))


def test_a_step_of_the_command_begins_a_new_move_and_is_no_change_of_the_error(tmp_path):
    way = glide(-80.0)
    further = [{**r, "time": r["time"] + 2.01, "command": -160.0, "feedback": -80.0 + r["feedback"]} for r in way]
    log = read_moves(write(tmp_path / "moves.csv", [*way, *further], SIGNALS))
    assert [len(m.error) for m in log.moves] == [21, 21]
    assert log.peak_change == pytest.approx(80.0 * (1.0 - math.exp(-0.4)))
    assert log.moves[1].error == pytest.approx(log.moves[0].error)


def test_parquet_csv_and_the_folder_of_a_run_read_the_same(tmp_path):
    way = glide(-80.0)
    folder = tmp_path / "run"
    folder.mkdir()
    table = pa.table({c: [r[c] for r in way] for c in SIGNALS})
    pq.write_table(table, folder / "signals.parquet")
    logs = [read_moves(p) for p in (folder, folder / "signals.parquet", write(tmp_path / "m.csv", way, SIGNALS))]
    for log in logs[1:]:
        assert np.array_equal(log.samples(), logs[0].samples())


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda r: {**r, "command": r["feedback"], "feedback": r["command"]}, "are the two swapped"),
        (lambda r: {**r, "output": -r["output"]}, "command and feedback are swapped, or the duty's sense"),
        (lambda r: {**r, "output": r["command"], "command": r["output"]}, r"column 'output': -80 is outside \[-1, 1\]"),
        (lambda r: {**r, "output": 0.5}, "output is always 0.5"),
        (lambda r: {**r, "command": 5.0, "feedback": 5.0}, "nothing moved"),
        (lambda r: {**r, "time": -r["time"]}, "time does not rise"),
        (lambda r: {**r, "time": 20.0 * r["time"]}, "more than the interval of 0.1 s"),
    ],
)
def test_signals_that_cannot_be_are_refused(tmp_path, change, said):
    path = write(tmp_path / "move.csv", [change(r) for r in glide(-80.0)], SIGNALS)
    with pytest.raises(DataError, match=said):
        read_moves(path)


def test_a_duty_a_little_beyond_one_counts_as_one_and_more_is_refused(tmp_path):
    way = glide(-80.0)
    way[0]["output"] = 1.0001
    path = write(tmp_path / "move.csv", way, SIGNALS)
    assert read_moves(path).moves[0].duty[0] == 1.0
    way[0]["output"] = 1.01
    with pytest.raises(DataError, match=r"row 1, column 'output': 1\.01 is outside"):
        read_moves(write(path, way, SIGNALS))


def test_broken_parquet_is_refused(tmp_path):
    path = tmp_path / "move.parquet"
    path.write_text("nothing")
    with pytest.raises(DataError, match="cannot be read"):
        read_moves(path)
    columns = {c: [r[c] for r in glide(-80.0)] for c in SIGNALS}
    pq.write_table(pa.table({k: v for k, v in columns.items() if k != "output"}), path)
    with pytest.raises(NameUnknown, match="has no column 'output'"):
        read_moves(path)
    pq.write_table(pa.table({**columns, "output": ["a"] * len(columns["time"])}), path)
    with pytest.raises(DataError, match="column 'output': holds words"):
        read_moves(path)
    pq.write_table(pa.table({**columns, "output": [math.nan, *columns["output"][1:]]}), path)
    with pytest.raises(DataError, match="sample 1, column 'output': holds no finite number"):
        read_moves(path)


def test_tables_and_signals_are_not_mixed(tmp_path):
    with pytest.raises(DataError, match="cannot be mixed"):
        read_moves([TABLE_1, write(tmp_path / "move.csv", glide(-80.0), SIGNALS)])


def moved(opposed=0.9, misfit=0.0):
    """One move of 60 samples: -e and the duty of a given correlation, ec off the change of e by a given share."""
    rng = np.random.default_rng(7)
    e = np.convolve(rng.standard_normal(61), np.ones(3) / 3.0, "same")
    later, change = e[1:], np.diff(e)

    def beside(x, *away):
        basis = np.linalg.qr(np.column_stack([x, *away]))[0]
        other = rng.standard_normal(len(x))
        other -= basis @ (basis.T @ other)
        return other * np.linalg.norm(x) / np.linalg.norm(other)

    ec = math.sqrt(1.0 - misfit**2) * change + misfit * beside(change, later)
    duty = -opposed * later + math.sqrt(1.0 - opposed**2) * beside(later, change)
    move = Move("m", None, np.arange(61.0), e, np.concatenate([[0.0], ec]), np.concatenate([[0.0], duty]))
    return MoveLog(("x.csv",), "normalised", (move,), 0.1, 1.0)


@pytest.mark.parametrize(
    ("opposed", "said"),
    [(0.51, ""), (0.49, "does not drive e to zero"), (-0.49, "does not drive e to zero"), (-0.51, "has the sign of e")],
)
def test_a_duty_must_oppose_the_error_with_half_of_its_size(opposed, said):
    if said:
        with pytest.raises(DataError, match=said):
            checked(moved(opposed=opposed))
    else:
        assert checked(moved(opposed=opposed)).turned == ()


def test_a_third_of_the_change_of_the_error_may_be_missing_from_its_column():
    assert checked(moved(misfit=0.34)).turned == ()
    with pytest.raises(DataError, match=r"ec is not the change of e per row \(misfit 36 %, allowed are 35 %\)"):
        checked(moved(misfit=0.36))
