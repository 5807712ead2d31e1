"""Studies of published systems: ``from leadscrew.studies import Study, claim, measure`` and what else a study takes."""

from leadscrew.util.lazy_exports import exports

__getattr__, __dir__, __all__ = exports(__name__, __file__)
