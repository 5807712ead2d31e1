"""Long expressions: a step that a generator wrote, or a polynomial of many terms, compiles on every engine."""

import math

import pytest

from leadscrew.experiment import Experiment
from leadscrew.kernel.trees import treework
from leadscrew.util.errors import SubsetError

STEP = '''"""A step of one long expression."""

from typing import Annotated, NamedTuple

from leadscrew import Gt, Unit, controller


class P(NamedTuple):
    """One gain."""

    k: Annotated[float, Unit("1"), Gt(0)] = 0.001


@controller(P(), unit="1")
def long(p, command, feedback):
    """A function of the error."""
    error = command - feedback
    return {expression}
'''
EXPRESSIONS = {
    "sum": " + ".join(f"{k + 1}.0 * p.k * error / 31375.0" for k in range(250)),
    "choice": " else ".join(f"p.k * {k}.0 if error < {k}.5" for k in range(250)) + " else 0.25",
}
VALUES = {
    "sum": lambda e: sum((k + 1.0) * 0.001 * e / 31375.0 for k in range(250)),
    "choice": lambda e: 0.001 * round(e),
}


@pytest.mark.parametrize("engine", ["python", "llvm"])
@pytest.mark.parametrize("what", EXPRESSIONS)
def test_an_expression_of_250_terms_is_what_it_says(tmp_path, what, engine):
    (tmp_path / "long.py").write_text(STEP.replace("{expression}", EXPRESSIONS[what]))
    loop = Experiment("vud_lathe", f"{tmp_path}/long.py:long", "step_p50").loop()
    run = loop.run(0.01, engine=engine)
    for error, output in zip(run.signals["error"], run.signals["output"], strict=True):
        assert math.isclose(output, VALUES[what](error), rel_tol=1e-12)


def test_recursion_without_end_is_refused_and_the_limit_is_as_it_was():
    import sys

    def down(n):
        return down(n + 1)

    before = sys.getrecursionlimit()
    with pytest.raises(SubsetError, match="nested too deep"), treework():
        down(0)
    assert sys.getrecursionlimit() == before
