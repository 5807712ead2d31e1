"""Fuzzy systems: built or read from files, compiled to machine code, explained, used in loops.

    from leadscrew import fuzzy

    system = fuzzy.read("tipper.fis")
    system(service=3.0, food=8.0)               # {"tip": 15.3...}
    print(system.explain(service=3.0, food=8.0))
    block = fuzzy.controller(system, {"service": "error", "food": ("change", 20.0)})

Names load what they need when they are first used.
"""

from leadscrew.util.lazy_exports import exports

__getattr__, __dir__, __all__ = exports(__name__, __file__)
