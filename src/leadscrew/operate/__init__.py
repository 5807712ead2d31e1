"""A machine run by hand, without a panel: a live loop with its events, what is shown of it, its scope, its records.

:class:`Operated` is the machine of a :class:`Start`: advanced, set, disturbed and switched. ``operated.session()`` is
all that was done, and runs again to the same bits; :mod:`leadscrew.operate.session_file` keeps it as TOML,
:mod:`leadscrew.operate.script` as a Python script, :mod:`leadscrew.report.session` as a page.
:mod:`leadscrew.operate.captures` saves what a :class:`Scope` took, and loads it again.
"""

from leadscrew.util.lazy_exports import exports

__getattr__, __dir__, __all__ = exports(__name__, __file__)
