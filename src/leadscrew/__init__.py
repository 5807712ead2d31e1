"""Leadscrew: intelligent control of machine-tool axes and cutting processes.

The public names stand in ``__init__.pyi``. Each loads what it needs when it is first used, so that ``import leadscrew``
itself stays light.
"""

from leadscrew._version import __version__ as __version__
from leadscrew.lazy_exports import exports

__getattr__, __dir__, __all__ = exports(__name__, __file__)
