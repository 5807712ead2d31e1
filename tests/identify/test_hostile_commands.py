"""What a user sees who gives a command a log that is wrong: one sentence, exit code 2, and nothing written.

Where a command may go on with an odd log it says what is odd; a fault of ours (a traceback, exit code 70) never.
"""

import re

import pytest
from typer.testing import CliRunner

from leadscrew.cli import app
from leadscrew.util.errors import LeadscrewError
from tests.identify.hostile import LOGS, digest, listing, right, text, write

ODD_FOR_ALL = {
    "position in km under a header in m", "a clipped drive", "force in kN under a header in N",
    "force with the other sign", "two columns of one name",
}  # fmt: skip
"""A command may go on with these."""
COMMANDS = {
    "axis": "identify axis LOG --model coulomb --refine none --out DIR/m.toml",
    "linear": "identify linear LOG --time time_s --input force_N --output position_m --order 2,0,1 --out DIR/m.toml",
    "servo-gain": "identify servo-gain LOG --time time_s --input force_N --position position_m",
    "friction": "identify friction LOG --time time_s --torque force_N --position position_m --out DIR/f.toml",
    "friction-force": "identify friction-force LOG --out DIR/report",
    "following-error": "following-error LOG --pair X=command_m,position_m --out DIR/report",
    "log": "log LOG",
}
GOES_ON = {
    "linear": {
        "a jump of the encoder", "a spike of the encoder", "position in mm under a header in m",
        "time in ms under a header in s", "force and position swapped",
    },
    "servo-gain": {
        "a jump of the encoder", "a spike of the encoder", "time in ms under a header in s", "a constant drive",
    },
    "friction-force": {
        "a jump of the encoder", "a spike of the encoder", "a gap of two seconds", "position in mm under a header in m",
        "time in ms under a header in s",
    },
    "following-error": {
        "a jump of the encoder", "a spike of the encoder", "standstill", "zeros but for the time", "a constant drive",
        "an empty cell", "1e400 in a cell", "inf in a cell", "position in mm under a header in m",
        "force and position swapped",
    },
}  # fmt: skip
"""What a command may go on with besides: a measured force may have gaps; a following error asks of no drive."""
SILENT = {
    "linear": {
        "position in km under a header in m", "force in kN under a header in N", "force with the other sign",
    },
    "friction-force": {"position in km under a header in m", "force in kN under a header in N", "a clipped drive"},
    "following-error": {
        "position in km under a header in m", "force in kN under a header in N", "a clipped drive",
        "force with the other sign", "a constant drive", "an empty cell", "1e400 in a cell", "inf in a cell",
    },
    "servo-gain": {"a constant drive"},
}  # fmt: skip
"""What it cannot see, or need not: a made-up unit fits a friction, a column that is not asked for may hold anything."""
WORDS = {
    "position in mm under a header in m": r"position=mm|m/s, more than",
    "position in km under a header in m": r"1,?000|slow for an axis",
    "time in ms under a header in s": r"time=ms|period of 1 s",
    "force in kN under a header in N": r"1,?000",
    "force and position swapped": r"swapped|exchanged|jumps|one signal|right columns?|far from",
    "force with the other sign": r"sign|backwards|negative",
    "standstill": r"stand|never moves",
    "zeros but for the time": r"never moves|stood still",
    "a jump of the encoder": r"jump",
    "a spike of the encoder": r"jump|spike",
    "a clipped drive": r"clipped",
    "a gap of two seconds": r"gap|longer than",
    "two columns of one name": r"second 'position_m'|position_m \(2\)|twice",
}
"""Of what is odd, where a command goes on."""


NOT_YET: dict[str, set[str]] = {}
"""What a command does not say or refuse yet; whoever mends one takes it out here, and the test asks for it."""
NO_WORD = pytest.mark.xfail(strict=True, reason="the command says nothing of this fault yet")
CASES = [
    pytest.param(command, name, marks=[NO_WORD] if name in NOT_YET.get(command, set()) else [])
    for command in COMMANDS
    for name in LOGS
]


def call(command, path, folder):
    words = [str(path) if w == "LOG" else w.replace("DIR", str(folder)) for w in command.split()]
    return CliRunner().invoke(app, words)


def one_sentence(result, path):
    """Exit code 2 with one line on stderr, or, of `log`, lines that begin with `refused:`."""
    assert result.exit_code == 2, (result.exit_code, result.output, result.exception)
    refused = [line for line in result.output.splitlines() if line.startswith(("leadscrew: ", "refused: "))]
    assert refused and len(result.stderr.splitlines()) <= 1, result.output
    assert "Traceback" not in result.output and "Error:" not in result.output
    assert len(refused[0]) < 500
    return refused[0]


@pytest.mark.slow
@pytest.mark.parametrize(("command", "name"), CASES)
def test_a_wrong_log_gets_one_sentence_and_leaves_nothing_behind(tmp_path, command, name):
    source, out = tmp_path / "in", tmp_path / "out"
    source.mkdir()
    out.mkdir()
    path = write(source, name)
    before = digest(path)
    result = call(COMMANDS[command], path, out)
    assert digest(path) == before and len(listing(source)) == 1
    assert result.exit_code in (0, 2), (result.output, result.exception)
    may_go_on = name in ODD_FOR_ALL | GOES_ON.get(command, set())
    if result.exit_code == 2 or not may_go_on:
        said = one_sentence(result, path)
        assert listing(out) == {}
        assert "log.csv" in said or command in ("log", "axis", "linear")
    elif name not in SILENT.get(command, set()):
        assert re.search(WORDS[name], result.stderr + result.stdout), result.output


@pytest.mark.parametrize("command", ["axis", "log", "following-error", "friction-force"])
def test_a_folder_a_missing_file_and_an_unknown_option_are_refused(tmp_path, command):
    missing = tmp_path / "gone.csv"
    for path in (tmp_path / "empty", missing):
        if path != missing:
            path.mkdir()
        assert "Traceback" not in (said := one_sentence(call(COMMANDS[command], path, tmp_path), path))
        assert path.name in said
    result = call(COMMANDS[command] + " --surely-not", missing, tmp_path)
    assert result.exit_code == 2 and "--surely-not" in result.stderr
    assert list(tmp_path.iterdir()) == [tmp_path / "empty"]


@pytest.mark.parametrize(
    ("command", "taken"), [("axis", "m.toml"), ("friction-force", "report"), ("following-error", "report")]
)
def test_an_output_that_is_there_is_refused_before_the_log_is_read(tmp_path, command, taken):
    (tmp_path / taken).mkdir() if taken == "report" else (tmp_path / taken).write_text("mine")
    (tmp_path / "mine.txt").write_text("mine")
    if taken == "report":
        (tmp_path / taken / "mine.txt").write_text("mine")
    before = listing(tmp_path)
    said = one_sentence(call(COMMANDS[command], tmp_path / "gone.csv", tmp_path), tmp_path)
    assert taken in said and "gone.csv" not in said
    assert listing(tmp_path) == before


BAD_OPTIONS = {
    "--holdout 0.9": "holdout", "--holdout nan": "holdout", "--model perfect": "model", "--refine hard": "refine",
    "--delay -1": "delay", "--given mass=-3": "mass", "--given weight=3": "weight", "--given mass=heavy": "mass",
    "--given mass": "mass", "--unit position=furlong": "furlong", "--unit colour=mm": "colour",
    "--column position=nowhere": "nowhere", "--column colour=force_N": "colour", "--force-per-drive 0": "force",
    "--start 5 --end 4": "4", "--start 100": "100", "--period -1": "period", "--cascade kp=1": "kp",
    "--cascade kp=1,kv=-2": "kv", "--refine closed": "cascade",
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("options", BAD_OPTIONS)
def test_a_wrong_option_of_identify_axis_is_named(tmp_path, options):
    path = tmp_path / "log.csv"
    path.write_text(text(right()))
    before = listing(tmp_path)
    result = call(f"identify axis LOG {options}", path, tmp_path)
    assert result.exit_code == 2, (result.output, result.exception)
    assert BAD_OPTIONS[options] in result.stderr, result.stderr
    assert "Traceback" not in result.stderr
    assert listing(tmp_path) == before


@pytest.mark.slow
@pytest.mark.parametrize("name", ["standstill", "force with the other sign"])
def test_the_library_raises_what_the_command_line_says(tmp_path, name):
    from leadscrew.identify.axis.fit import identify_axis
    from leadscrew.logs import read_axis_log

    path = write(tmp_path, name)
    said = one_sentence(call(COMMANDS["axis"], path, tmp_path), path)
    with pytest.raises(LeadscrewError) as stop:
        identify_axis(read_axis_log(path), model="coulomb", refine="none")
    assert str(stop.value) in said
