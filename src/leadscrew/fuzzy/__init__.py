"""Fuzzy systems: built or read from files, compiled to machine code, explained, used in loops.

    from leadscrew import fuzzy

    system = fuzzy.read("tipper.fis")
    system(service=3.0, food=8.0)               # {"tip": 15.3...}
    print(system.explain(service=3.0, food=8.0))
    block = fuzzy.controller(system, {"service": "error", "food": ("change", 20.0)})

Names load what they need when they are first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from leadscrew.lazy import doors

if TYPE_CHECKING:
    from leadscrew.fuzzy.block import controller, from_file, function
    from leadscrew.fuzzy.build import constants, larsen, linear, mamdani, takagi_sugeno, triangles, tsukamoto
    from leadscrew.fuzzy.evaluate import Compiled, compiled
    from leadscrew.fuzzy.explanation import explain
    from leadscrew.fuzzy.formats import read, write
    from leadscrew.fuzzy.rules_text import parse
    from leadscrew.fuzzy.system import And, Input, Is, Or, Output, Rule, RuleBlock, System, Term

__all__ = [
    "And",
    "Compiled",
    "Input",
    "Is",
    "Or",
    "Output",
    "Rule",
    "RuleBlock",
    "System",
    "Term",
    "compiled",
    "constants",
    "controller",
    "explain",
    "from_file",
    "function",
    "larsen",
    "linear",
    "mamdani",
    "parse",
    "read",
    "takagi_sugeno",
    "triangles",
    "tsukamoto",
    "write",
]

_HOMES = {
    "block": "controller from_file function",
    "build": "constants larsen linear mamdani takagi_sugeno triangles tsukamoto",
    "evaluate": "Compiled compiled",
    "explanation": "explain",
    "formats": "read write",
    "rules_text": "parse",
    "system": "And Input Is Or Output Rule RuleBlock System Term",
}
"""The module of each public name."""


__getattr__, __dir__ = doors(globals(), _HOMES)
