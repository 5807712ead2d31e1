"""What a type checker says of a user's script."""

import subprocess
import sys

import pytest

SCRIPT = """
import leadscrew as ls
from leadscrew.controllers import pid

loop = ls.Loop(
    reference=ls.references.s_curve(distance=50.0),
    controller=pid(kp=40.0, ki=200.0),
    plant=ls.plants.servo_axis(),
    period=1e-3,
)
pid(kp="20")  # wrong type
pid(kpp=2.0)  # wrong name
"""


@pytest.mark.slow
def test_a_wrong_type_and_a_wrong_name_of_a_parameter_are_type_errors(tmp_path):
    file = tmp_path / "script.py"
    file.write_text(SCRIPT)
    words = [sys.executable, "-m", "mypy", "--follow-imports=silent", "--ignore-missing-imports", str(file)]
    done = subprocess.run(words, capture_output=True, text=True, cwd=tmp_path)
    wrong = {n for n, line in enumerate(SCRIPT.splitlines(), 1) if "# wrong" in line}
    errors = [line for line in done.stdout.splitlines() if ": error: " in line]
    assert {int(line.split(":")[1]) for line in errors} == wrong and len(errors) == 2, done.stdout + done.stderr
    assert 'did you mean "kp"?' in done.stdout
