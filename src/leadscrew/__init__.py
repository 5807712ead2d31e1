"""Leadscrew: intelligent control of machine-tool axes and cutting processes.

The public names stand in ``__init__.pyi``. Each loads what it needs when it is first used, so that ``import leadscrew``
itself stays light.
"""

from leadscrew._version import __version__ as __version__
from leadscrew.kernel import views
from leadscrew.util.lazy_exports import exports

views.HOMES.update(
    run_figure="leadscrew.figures.runs:run_figure",
    linearize="leadscrew.analysis.linearization:linearize",
    margins="leadscrew.analysis.linearization:margins",
    step_response="leadscrew.analysis.linearization:step_response",
)

__getattr__, __dir__, __all__ = exports(__name__, __file__)
