"""The list of known faults, and ``make faults`` on a small repository whose tests are played."""

import subprocess
from pathlib import Path

import pytest

from tests.closure import ROOT
from tests.faults import LIST, faults, main
from tests.mutants import Copy

ROW = """
[[fault]]
file = "src/leadscrew/sums.py"
line = "{}"
fault = "{}"
what = "{}"
caught_by = "tests/test_sums.py::{}"
"""
ROWS = [
    ("return a + b", "return a - b", "a wrong sum", "test_add"),
    ("return a > 0", "return a >= 0", "0 is positive", "test_add"),
    ("return a < 0", "return a <= 0", "0 is negative", "test_add"),
    ("return b", "return a", "the other one", "test_gone"),
    ("return b", "return a", "the other one", "test_broken"),
]
CODE = "def add(a, b):\n    return a + b\ndef up(a):\n    return a > 0\ndef same(b):\n    return b\n"
FILES = {
    "src/leadscrew/sums.py": CODE,
    "tests/test_sums.py": "def test_add(): pass\ndef test_broken(): pass\n",
}


@pytest.fixture
def root(tmp_path, monkeypatch):
    def write(rows):
        for name, text in {**FILES, LIST: "".join(ROW.format(*row) for row in rows)}.items():
            (tmp_path / "r" / name).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / "r" / name).write_text(text, encoding="utf-8")
        subprocess.run(["git", "init", "-q"], cwd=tmp_path / "r", check=True)
        return tmp_path / "r"

    def run(copy, tests, limit_s):
        broken = any(test.endswith("test_broken") for test in tests)
        return int(broken or "    return a + b\n" not in (copy.tree / "src/leadscrew/sums.py").read_text())

    monkeypatch.setattr(Copy, "run", run)
    return write


def test_the_forty_faults_can_all_be_made_and_their_tests_are_there():
    rows = faults(ROOT)
    assert {row: row.error(ROOT) for row in rows if row.error(ROOT)} == {}
    assert len({row.line for row in rows}) == len(rows) >= 40
    for row in rows:
        code = (ROOT / row.file).read_text(encoding="utf-8")
        compile(row.made(code), row.file, "exec")
        assert row.what and row.made(code) != code, row


def test_every_folder_of_the_library_has_a_fault():
    files = {Path(row.file) for row in faults(ROOT)}
    library = ROOT / "src" / "leadscrew"
    for folder in (*library.glob("*/__init__.py"), *library.glob("studies/*/__init__.py")):
        assert any(folder.parent.relative_to(ROOT) in file.parents for file in files), folder


def test_each_fault_is_caught_or_survives_or_says_why_it_cannot_be_tried(root, capsys):
    folder = root(ROWS)
    assert main([], folder) == 1
    results = [line for line in capsys.readouterr().out.splitlines() if line[0] != " "]
    assert [line.partition(" src/")[0].strip() for line in results] == [
        "caught", "survived", "line not found", "test not found", "test fails without it", "1 of 5 caught",
    ]  # fmt: skip
    assert {name: (folder / name).read_text(encoding="utf-8") for name in FILES} == FILES


def test_all_caught_is_well_and_rows_can_be_chosen(root, capsys):
    folder = root(ROWS)
    assert main(["--only", "wrong s.m"], folder) == 0
    assert capsys.readouterr().out.endswith("1 of 1 caught\n")


@pytest.mark.parametrize(
    ("rows", "words", "said"),
    [(ROWS, ["--only", "nothing"], "no row"), (ROWS, ["--only", "("], "--only ("), ([], [], "no row"),
     ([(*ROWS[0][:3], 'x"\nmore = "1')], [], "more")],
)  # fmt: skip
def test_bad_input_ends_with_2(root, capsys, rows, words, said):
    with pytest.raises(SystemExit) as stop:
        main(words, root(rows))
    assert stop.value.code == 2 and said in capsys.readouterr().err
