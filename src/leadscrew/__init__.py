"""Leadscrew: intelligent control of machine-tool axes and cutting processes.

The public names stand in ``__init__.pyi``. Each loads what it needs when it is first used, so that ``import leadscrew``
itself stays light.
"""

import lazy_loader

from leadscrew._version import __version__ as __version__

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
