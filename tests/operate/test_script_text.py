"""A session's script is Python, whatever its names and values hold."""

import ast

from leadscrew.operate import script
from leadscrew.operate.operated import Session, Start


def test_no_name_or_value_breaks_out_of_the_script_of_its_session():
    changes = {'a"""\\': float("inf"), "b'": [1.0, float("-inf")], "c\n": True}
    start = Start('x"""; import os\n\\', "p\u202e", "s", changes, seed=3)
    text = script.text(Session(start, (), 10, "ab" * 32), 1e-3, '"""\\.py')
    module = ast.parse(text)
    assert sum(isinstance(node, ast.Import) for node in module.body) == 1
    (made,) = (n.value for n in module.body if isinstance(n, ast.Assign) and n.targets[0].id == "start")
    assert eval(ast.unparse(made), {"Start": Start}) == start
