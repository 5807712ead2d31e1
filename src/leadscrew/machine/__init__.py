"""A machine in a file: what was identified of an axis, as a study that every command takes."""

from leadscrew.util.lazy_exports import exports

__getattr__, __dir__, __all__ = exports(__name__, __file__)
