"""Plants: blocks that move or cut, and functions that make one.

The public names stand in ``__init__.pyi``; each loads its own module when it is first used.
"""

from leadscrew.util.lazy_exports import exports

__getattr__, __dir__, __all__ = exports(__name__, __file__)
