"""Loops that are built after an error in a notebook: printing a traceback leaves marks on syntax trees."""

import ast

import pytest

from leadscrew.kernel.block import make
from leadscrew.kernel.loop import Loop
from tests.kernel import zoo
from tests.notebook import executed

ERRORS = """\
import json; json.loads("x")
1 / 0
undefined_name
[][1]
{}["key"]
int("x")
"a" + 1
None.attribute
import no_such_module
open("no_such_file")
assert False, "no"
raise RuntimeError("made")
next(iter(()))
(lambda: (lambda: 1 / 0)())()
[x for x in range(3) if x / 0]
(f := lambda n: f(n + 1))(0)
x = = 1
import math; math.sqrt(-1.0)
import numpy as np; np.zeros(2) @ np.zeros(3)
import leadscrew as ls; ls.Loop(reference=1)""".splitlines()
LOOP = """\
from typing import NamedTuple
from leadscrew import Loop, controller, plant
from leadscrew.references._step import step
class P(NamedTuple):
    kp: float = 2.0
class S(NamedTuple):
    x: float = 0.0
@controller(P())
def proportional(p, command, feedback):
    return p.kp * (command - feedback)
@plant(P(), S())
def integrator(p, s, u):
    return S(u)
run = Loop(reference=step(target=1.0), controller=proportional, plant=integrator, period=1e-3, metrics={}).run(0.01)
print("periods", len(run["output"]))
"""


@pytest.mark.slow
def test_twenty_kinds_of_error_in_a_notebook_leave_loops_as_they_were(tmp_path):
    nbformat = pytest.importorskip("nbformat", reason="nbformat is missing: pip install leadscrew[dev]")
    cells = [nbformat.v4.new_code_cell(text) for text in (*ERRORS, LOOP)]
    notebook = nbformat.v4.new_notebook(cells=cells)
    executed(notebook, tmp_path, allow_errors=True)
    *failed, last = (list(cell.outputs) for cell in notebook.cells)
    assert len(failed) == 20 and all(out[-1].output_type == "error" for out in failed)
    assert [out.get("text") for out in last] == ["periods 10\n"], last


def test_what_a_debugger_notes_on_the_nodes_that_all_syntax_trees_share_is_not_followed():
    """``executing``, with which IPython prints tracebacks, gives every node its parent; ``Load()`` is one for all."""
    foreign = ast.parse("-x + x * x / x < x and not x")
    shared = {child for node in ast.walk(foreign) for child in ast.iter_child_nodes(node) if not child._fields}
    for node in ast.walk(foreign):
        for child in ast.iter_child_nodes(node):
            child.parent = node

    def early(p, s, command):
        if command > 0.5:
            return s, -command * p.kp
        return s, command + p.kp

    try:
        run = Loop(
            reference=zoo.sine(frequency=20.0), controller=make("controller", early, zoo.pid.params, zoo.pid.state),
            plant=zoo.mass(gain=0.0), metrics={},
        ).run(0.01)  # fmt: skip
    finally:
        for node in shared:
            del node.parent
    assert len(run["output"]) == 10
