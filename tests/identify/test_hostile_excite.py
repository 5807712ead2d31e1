"""`excite` gives moves to a real machine: what it cannot take is refused in one sentence, and nothing is written."""

import pytest

from tests.identify.hostile import listing
from tests.identify.test_hostile_commands import call, one_sentence

FREE = "--travel 0,100 --top-speed 100 --top-acceleration 1000"
WRONG = {
    "LOG --out DIR/new": "fit.json",
    f"--tell weight {FREE} --out DIR/new": "weight",
    f"--tell mass {FREE} --guess mass=-1 --out DIR/new": "mass",
    f"--tell mass {FREE} --guess mass=heavy --out DIR/new": "heavy",
    f"--tell mass {FREE} --unit furlong --out DIR/new": "furlong",
    f"--tell mass {FREE} --axis Q7 --out DIR/new": "Q7",
    f"--tell mass {FREE} --out DIR/there": "there",
    "--tell mass --travel 100,0 --top-speed 100 --top-acceleration 1000 --out DIR/new": "travel",
    "--tell mass --travel 0,100 --top-speed nan --top-acceleration 1000 --out DIR/new": "speed",
    "--tell mass --travel 0,100 --top-speed -5 --top-acceleration 1000 --out DIR/new": "speed",
    "--tell mass --travel 0,100 --top-speed 5 --out DIR/new": "acceleration",
}
FITS = {
    "empty": b"",
    "no JSON": b"nonsense",
    "bytes": bytes(range(256)),
    "another JSON": b'{"a": 1}',
    "a list": b"[1, 2]",
    "words for numbers": b'{"parameters": {"mass": {"value": "heavy"}}, "travel": [0, 1], "position_unit": "m"}',
}


def folder(tmp_path):
    there = tmp_path / "there"
    there.mkdir()
    (there / "mine.txt").write_text("mine")
    return tmp_path


@pytest.mark.slow
@pytest.mark.parametrize("options", WRONG)
def test_what_excite_cannot_take_is_named_and_nothing_is_written(tmp_path, options):
    path = folder(tmp_path) / "fit.json"
    before = listing(tmp_path)
    said = one_sentence(call(f"excite {options}", path, tmp_path), path)
    assert WRONG[options] in said, said
    assert listing(tmp_path) == before and not (tmp_path / "new").exists()


@pytest.mark.parametrize("name", FITS)
def test_a_file_that_is_no_fit_is_refused_by_name(tmp_path, name):
    path = folder(tmp_path) / "fit.json"
    path.write_bytes(FITS[name])
    before = listing(tmp_path)
    said = one_sentence(call("excite LOG --out DIR/new", path, tmp_path), path)
    assert "fit.json" in said
    assert listing(tmp_path) == before and not (tmp_path / "new").exists()
