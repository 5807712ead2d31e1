"""A machine run by hand, without a panel: a live loop with its events, what is shown of it, its scope, its records.

:class:`Operated` is the machine of a :class:`Start`: advanced, set, disturbed and switched. ``operated.session()`` is
all that was done, and runs again to the same bits; :mod:`leadscrew.operate.session_file` keeps it as TOML,
:mod:`leadscrew.operate.script` as a Python script, :mod:`leadscrew.report.session` as a page.
:mod:`leadscrew.operate.captures` saves what a :class:`Scope` took, and loads it again.
"""

from leadscrew.lazy import doors

__getattr__, __dir__ = doors(
    globals(),
    {
        "capture": "Capture",
        "change": "Change",
        "operated": "Event Operated Rerun Session Start",
        "profile": "Profile fitted",
        "profiles": "profile_of",
        "scope": "Scope Trigger",
        "why": "explainer",
    },
)
