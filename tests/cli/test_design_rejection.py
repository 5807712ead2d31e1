"""``leadscrew design rejection``: what it prints, what it writes, and what it refuses with nothing written."""

import pytest

from leadscrew import controller_file
from tests.cli.conftest import left, strict_json


@pytest.mark.slow
def test_the_file_is_a_controller_with_the_command_that_finds_it_again(call, tmp_path):
    args = ["design", "rejection", "pid", "--rest", 1.0, "--budget", 100, "--seed", 3]
    one, two = tmp_path / "one.toml", tmp_path / "two.toml"
    said = call(*args, "-o", one).stdout
    assert "mean row of Table II, um" in said and "bounds kept: Ms<=1.6" in said
    file = controller_file.read(one)
    assert (file.study, file.controller) == ("npid_xytable", "pid") and file.tuning["holds"] is True
    found = strict_json(call(*file.tuning["command"].split()[1:], "-o", two, "--json").stdout)
    assert found["parameters"] == dict(controller_file.read(two).parameters) == dict(file.parameters)
    given = [word for name, value in file.parameters.items() for word in ("--set", f"controller.{name}={value!r}")]
    runs = [
        strict_json(call("simulate", "npid_xytable", "-s", "measured_1000", "--json", "-c", *words).stdout)
        for words in ([one], ["pid", *given], ["pid"])
    ]
    by_file, by_hand, untuned = (run["metrics"]["rms_error"] for run in runs)
    assert by_file == by_hand < untuned


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (["pidd", "--rest", "1"], "there is no law 'pidd'"),
        (["pid"], "--rest MV, --work MV, or both"),
        (["pid", "--rest", "-1"], "--rest: must be positive"),
        (["pid", "--rest", "1", "--ms", "0.9"], "--ms: must be above 1"),
        (["pid", "--rest", "1", "--budget", "5"], "at least"),
        (["pid", "--rest", "1", "-o", "x.json"], "ends in .toml"),
    ],
)
def test_options_that_cannot_be_are_refused_and_nothing_is_written(refused, tmp_path, monkeypatch, args, said):
    monkeypatch.chdir(tmp_path)
    assert said in refused("design", "rejection", *args)
    assert left(tmp_path) == []
