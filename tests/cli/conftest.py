"""What the tests of the command line share."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner, Result

from leadscrew.cli import app
from leadscrew.fuzzy import formats
from tests.fuzzy.systems import sugeno

FILE = Path(__file__).parent / "plain_study.py"


@pytest.fixture(autouse=True)
def wide(monkeypatch: pytest.MonkeyPatch) -> None:
    """No sentence is wrapped: tests look for whole ones. What is wrapped at 100 columns is tested in tests/report."""
    monkeypatch.setenv("COLUMNS", "1000")


@pytest.fixture
def study() -> str:
    """The name of the tiny study."""
    return f"{FILE}:STUDY"


@pytest.fixture
def call() -> Callable[..., Result]:
    """Calls the command line in this process."""
    runner = CliRunner()

    def run(*args: object, code: int | None = 0) -> Result:
        result = runner.invoke(app, [str(a) for a in args])
        if code is not None:
            assert result.exit_code == code, result.output
        return result

    return run


@pytest.fixture
def refused(call: Callable[..., Result]) -> Callable[..., str]:
    """Calls the command line with something that it refuses; gives the one line on stderr."""

    def run(*args: object) -> str:
        result = call(*args, code=2)
        if "--json" in args:
            found = strict_json(result.stdout)
            assert found["exit_code"] == 2 and found["error"] in result.stderr
        else:
            assert result.stdout == ""
        assert result.stderr.count("\n") == 1, result.stderr
        return result.stderr

    return run


def strict_json(text: str) -> Any:
    """The one JSON object on stdout; NaN and Infinity are errors."""

    def no(name: str) -> None:
        raise AssertionError(f"{name} in JSON")

    assert text.count("\n") == 1
    return json.loads(text, parse_constant=no)


FLL = """Engine: feeder
InputVariable: gap
  enabled: true
  range: 0.000 10.000
  lock-range: false
  term: near Ramp 4.000 0.000
  term: far Ramp 6.000 10.000
OutputVariable: feed
  enabled: true
  range: 0.000 1.000
  lock-range: false
  aggregation: none
  defuzzifier: WeightedAverage TakagiSugeno
  default: nan
  lock-previous: false
  term: slow Constant 0.100
  term: fast Constant 1.000
RuleBlock: only
  enabled: true
  conjunction: none
  disjunction: none
  implication: none
  activation: General
  rule: if gap is near then feed is slow
  rule: if gap is far then feed is {fast}
"""


@pytest.fixture
def feeder(tmp_path: Path) -> Path:
    path = tmp_path / "feeder.fll"
    path.write_text(FLL.format(fast="fast"))
    return path


@pytest.fixture
def broken(tmp_path: Path) -> Path:
    path = tmp_path / "broken.fll"
    path.write_text(FLL.format(fast="quick"))
    return path


@pytest.fixture
def servo(tmp_path: Path) -> Path:
    path = tmp_path / "servo.fll"
    formats.write(sugeno(), path)
    return path


def left(folder: Path) -> list[str]:
    return sorted(p.name for p in folder.iterdir() if p.name != "__pycache__")  # Python's own, beside a user's file
