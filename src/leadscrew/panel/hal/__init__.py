"""The panel at a running LinuxCNC: what it shows comes through HAL's sampler, what it writes is listed in a file.

LinuxCNC's ``hal`` module is GPL and is never imported here. One helper process (``attached.py``, run by the Python that
LinuxCNC is installed for) reads the samples and writes the parameters; it is spoken to by pipes. It also takes
everything away again when this process ends, in whatever way.
"""

from leadscrew.util.lazy_exports import exports

__getattr__, __dir__, __all__ = exports(__name__, __file__)
