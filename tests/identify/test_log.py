"""The log door: a malformed file is refused with its name, row and column."""

import pytest

from leadscrew.logs.csv_columns import read_log
from leadscrew.util.errors import DataError

GOOD = "k,r,e\n0,-50,-0.264\n1,-50,-0.208\n0,50,0.264\n1,50,0.211\n"


@pytest.fixture
def write(tmp_path):
    def put(text):
        path = tmp_path / "log.csv"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    return put


def test_a_sound_file_gives_its_columns_as_numbers(write):
    log = read_log(write("\ufeff# from the lathe\n" + GOOD), ("k", "e"), increasing=None)
    assert log["e"].tolist() == [-0.264, -0.208, 0.264, 0.211]
    assert set(log) == {"k", "e"}
    assert read_log(write(GOOD), ("k", "r"), increasing="k", within="r")["k"].tolist() == [0, 1, 0, 1]
    assert len(read_log(write(GOOD.replace("\n", "\r\n")), ("k",))["k"]) == 4


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "log.csv: is empty"),
        ("\n\n", "log.csv: is empty"),
        ("k,r,e\n", "log.csv: has a header but no rows"),
        (GOOD.replace("k,r,e", "k,r,error"), "row 1: the column 'e' is missing"),
        (GOOD.replace("k,r,e", "k,r,e,e"), "row 1: the column 'e' appears 2 times"),
        (GOOD.replace("-0.208", "slow"), "row 3, column 'e': 'slow' is not a number"),
        (GOOD.replace("-0.208", ""), "row 3, column 'e': '' is not a number"),
        (GOOD.replace("-0.208", "nan"), "row 3, column 'e': 'nan' is not a finite number"),
        (GOOD.replace("-0.208", "-20.8"), "row 3, column 'e': -20.8 is outside [-1, 1]"),
        (GOOD.replace("1,-50,-0.208", "1,-50"), "row 3: 2 cells where the header has 3"),
        (GOOD.replace("1,-50,", "0,-50,"), "row 3, column 'k': 0 does not rise above 0"),
        ('k,r,e\n0,-50,"0.1\n', "row 2"),
        (b"k,r,e\n0,\xff,1\n", "not UTF-8"),
    ],
)
def test_a_malformed_file_is_refused_by_file_row_and_column(write, text, says):
    with pytest.raises(DataError) as refused:
        read_log(write(text), ("k", "r", "e"), increasing="k", within="r", limits={"e": (-1.0, 1.0)})
    assert says in str(refused.value) and "log.csv" in str(refused.value)


def test_a_missing_file_is_refused_by_name(tmp_path):
    with pytest.raises(DataError, match=r"nowhere\.csv: cannot be read"):
        read_log(tmp_path / "nowhere.csv", ("k",))
