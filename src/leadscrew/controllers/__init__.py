"""Controllers: blocks that compute the drive command, and functions that make one.

The public names stand in ``__init__.pyi``; each loads its own module when it is first used.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
