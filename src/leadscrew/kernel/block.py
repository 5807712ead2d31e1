"""The block contract: a plain function, a NamedTuple of parameters, a NamedTuple of state.

A block's step takes its parameters ``p`` first and, where it has state, its state ``s`` second. Every
further argument is a signal, taken *by name*; a step lists only the ones that it needs:

=============  =========================================================  =====================================
kind           signals that its step may take                             what it returns
=============  =========================================================  =====================================
reference      ``t, dt, noise``                                           command
disturbance    ``t, dt, noise``                                           load
sensor         ``actual, t, dt, noise``                                   feedback
controller     ``command, feedback, t, dt``                               output
actuator       ``output, t, dt``                                          what reaches the plant
plant          ``u, load, t`` (a derivative) or with ``dt`` (a step)      derivative of the state, or next state
metric         ``command, actual, feedback, error, output, t, dt``        next state
=============  =========================================================  =====================================

With state, a step returns ``(next_state, signal)``; without, the signal alone. A plant returns a state only:
one that does not take ``dt`` returns its time derivative and is integrated by the loop; one that takes
``dt`` returns the state after ``dt``. What a plant shows the sensor is its ``output``: the name of a state
field, or a function ``(p, s) -> signal``. A plant that does not take ``load`` gets it added to ``u``.

Signals are floats or NamedTuples of floats.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, ParamSpec, Protocol, overload

from leadscrew.kernel.parameters import checked_replace, entries
from leadscrew.util.errors import BlockError, entry_point
from leadscrew.util.escape import checked_line

if TYPE_CHECKING:
    from typing_extensions import ParamSpec as DefaultParamSpec

    P = DefaultParamSpec("P", default=...)
else:
    P = ParamSpec("P")

Q = ParamSpec("Q")

KINDS: dict[str, tuple[str, ...]] = {
    "reference": ("t", "dt", "noise"),
    "disturbance": ("t", "dt", "noise"),
    "sensor": ("actual", "t", "dt", "noise"),
    "controller": ("command", "feedback", "t", "dt"),
    "actuator": ("output", "t", "dt"),
    "plant": ("u", "load", "t", "dt"),
    "metric": ("command", "actual", "feedback", "error", "output", "t", "dt"),
}
"""The kinds of block and the signals that a step of each may take."""


DRIVES = ("torque", "force", "velocity", "voltage", "duty", "position")
"""What a controller's output may command, and a plant take."""


class InputRange(NamedTuple):
    """A range for which a controller's input is made: the universe of a fuzzy system."""

    name: str
    source: str
    """``error``, ``change``, ``rate``, ``command``, ``feedback`` or ``integral``: the input is this times a scale."""
    scale: str
    """The parameter that holds the scale."""
    low: float
    high: float
    command: str = "command"
    """The number of the command that counts, as it is recorded."""
    feedback: str = "feedback"


@entry_point
@dataclass(frozen=True, repr=False)
class Block(Generic[P]):
    """A block: its step, its parameters and its state at the start.

    Called with positional arguments it is its step, so that blocks compose by plain calls; called with
    keywords only it returns itself with those parameters changed: ``sine(amplitude=2.0)``.
    """

    kind: str
    name: str
    step: Callable[..., Any]
    params: Any = None
    state: Any = None
    signals: tuple[str, ...] = ()
    output: str | Callable[..., Any] | None = None
    """Plant: state field or function ``(p, s)`` that the sensor sees. Metric: function ``(p, s) -> float``."""
    prepare: Callable[..., Any] | None = None
    """``prepare(params, dt) -> NamedTuple``, run once at the door; the step gets what it returns as ``p``. That of a
    metric may take ``duration`` as well: seconds of the run, infinite for a live loop."""
    jacobian: Callable[..., Any] | None = None
    """Plant: ``(p, s, u, load, t)`` -> the rows of the derivative's Jacobian, as a tuple of tuples."""
    initial: Callable[..., Any] | None = None
    """``initial(params) -> state`` where the state at the start depends on the parameters."""
    align: Callable[..., Any] | None = None
    """Controller: ``(params, command, feedback, output) -> state`` for a bumpless start."""
    continuous: bool = False
    """Controller: its step returns the time *derivative* of its state, for loops with ``period=None``."""
    unit: str = ""
    """Unit of the signal that the block gives."""
    stiff: bool = False
    """Plant: its derivative has rates far above 1 / period, so a loop integrates it by ``rodas`` unless a method is
    named."""
    no_value: Callable[..., str] | None = None
    """Metric: ``no_value(params, state, end)`` -> why it has no value in a run of ``end`` seconds."""
    drive: str = ""
    """Controller: what its output commands; plant: what its input is; one of :data:`DRIVES`."""
    full_scale: float = 0.0
    """Controller: size of the output at full drive; 0 where it has none of its own."""
    sense: int = 1
    """Controller: -1 where a positive output moves the axis towards negative feedback, as some papers have it.

    Plant: -1 where a positive input moves its output towards negative values."""
    input_ranges: tuple[InputRange, ...] = ()
    """Controller: the ranges for which its inputs are made."""
    doc: str = field(default="", repr=False)

    def __repr__(self) -> str:
        values = [f"{e.key}={_short(e.default)}" for e in entries(self.params)] if self.params is not None else []
        more = f", and {len(values) - SHOWN} more" if len(values) > SHOWN else ""
        return f"<{self.kind} {self.name}{': ' if values else ''}{', '.join(values[:SHOWN])}{more}>"

    @overload
    def __call__(self, *args: P.args, **changes: P.kwargs) -> Block[P]: ...
    @overload
    def __call__(self, first: Any, /, *more: Any) -> Any: ...
    def __call__(self, *args: Any, **changes: Any) -> Any:
        if args:
            if self.params is not None and not isinstance(args[0], tuple):
                first = f"{self.params._fields[0]}={args[0]!r}"
                raise BlockError(f"{self.name}({args[0]!r}): parameters have names: {self.name}({first})")
            return self.step(*args, **changes)
        return self.using(**changes)

    def using(self, **changes: Any) -> Block[P]:
        """The block with some parameters changed; each is checked against its data sheet."""
        if not changes:
            return self
        return replace(self, params=checked_replace(self.params, changes, where=self.name))

    def starting(self, **changes: Any) -> Block[P]:
        """The block with some fields of its state at the start changed."""
        return replace(self, state=checked_replace(self.state, changes, where=f"{self.name} state"), initial=None)


SHOWN = 6
"""Parameters that the short form of a block shows."""


def _short(value: Any) -> str:
    shape = getattr(value, "shape", ())
    return f"array {' x '.join(map(str, shape))}" if shape else f"{value:g}" if isinstance(value, float) else str(value)


def takes(function: Callable[..., Any], argument: str) -> bool:
    """Whether a function has an argument of this name."""
    return argument in inspect.signature(function).parameters


def _signals(kind: str, step: Callable[..., Any], params: Any, state: Any) -> tuple[str, ...]:
    names = list(inspect.signature(step).parameters)
    leading = [n for n, have in (("p", params), ("s", state)) if have is not None]
    if names[: len(leading)] != leading:
        raise BlockError(
            f"{step.__name__}: a step with {' and '.join(leading)} starts with ({', '.join(leading)}, ...), "
            f"not ({', '.join(names)})"
        )
    rest = tuple(names[len(leading) :])
    for name in rest:
        if name not in KINDS[kind]:
            raise BlockError(
                f"{step.__name__}: a {kind} cannot take {name!r}; it may take {', '.join(KINDS[kind])}"
                + ("" if params is not None or name != "p" else ", and p when it declares parameters")
            )
    return rest


def make(kind: str, step: Callable[..., Any], params: Any = None, state: Any = None, **more: Any) -> Block:
    """A block of ``kind`` from a step function, checked against the contract.

    Raises:
        BlockError: the step does not start with ``p`` (and ``s``), takes a signal that the kind does not have,
            or parameters or state are not NamedTuples.
    """
    for what, value in (("parameters", params), ("state", state)):
        if value is not None and not (isinstance(value, tuple) and hasattr(value, "_fields")):
            if isinstance(value, type):
                raise BlockError(f"{step.__name__}: {what} are a class; write an instance: {value.__name__}()")
            raise BlockError(
                f"{step.__name__}: {what} must be an instance of a NamedTuple, for example Params(), not {value!r}"
            )
    if more.get("drive", "") not in ("", *DRIVES):
        raise BlockError(f"{step.__name__}: drive={more['drive']!r}; there are {', '.join(DRIVES)}")
    if more.get("sense", 1) not in (1, -1):
        raise BlockError(f"{step.__name__}: sense={more['sense']!r}; allowed are 1 and -1")
    if more.get("stiff") and (kind != "plant" or takes(step, "dt")):
        raise BlockError(
            f"{step.__name__}: stiff=True is for a plant that returns its derivative; "
            f"{'a plant that takes dt brings its own step' if kind == 'plant' else f'this is a {kind}'}"
        )
    if kind == "plant" and state is None:
        raise BlockError(f"{step.__name__}: a plant needs a state: @plant(Params(), State())")
    name = checked_line("name", more.pop("name", None) or step.__name__)
    doc = more.pop("doc", None) or inspect.getdoc(step) or ""
    return Block(kind, name, step, params, state, _signals(kind, step, params, state), doc=doc, **more)


def _instance(step: Callable[..., Any], part: Any) -> Any:
    """A NamedTuple from its class, with its defaults."""
    fields = getattr(part, "_fields", None) if isinstance(part, type) else None
    if fields is None:
        return part
    bare = [name for name in fields if name not in part._field_defaults]
    if bare:
        raise BlockError(
            f"{step.__name__}: {part.__name__}.{bare[0]} has no default: give it one, or write an instance"
        )
    return part()


class Decorator(Protocol):
    """Makes a block of a step function; takes parameters and state as classes of NamedTuples, or as instances."""

    @overload
    def __call__(
        self, params: Callable[Q, tuple[Any, ...]], state: Any = None, **more: Any
    ) -> Callable[[Callable[..., Any]], Block[Q]]: ...
    @overload
    def __call__(
        self, params: Any = None, state: Any = None, **more: Any
    ) -> Callable[[Callable[..., Any]], Block[...]]: ...


def _decorator(kind: str) -> Decorator:
    @entry_point
    def with_parts(params: Any = None, state: Any = None, **more: Any) -> Callable[[Callable[..., Any]], Block[...]]:
        if inspect.isfunction(params):
            raise BlockError(f"{params.__name__}: write @{kind}() or @{kind}(Params(), State()), with parentheses")

        @entry_point
        def decorate(step: Callable[..., Any]) -> Block[...]:
            return make(kind, step, _instance(step, params), _instance(step, state), **more)

        return decorate

    with_parts.__name__ = kind
    with_parts.__doc__ = f"Decorator: makes a {kind} block of a step function. See the module's table."
    return with_parts  # type: ignore[return-value]


reference = _decorator("reference")
disturbance = _decorator("disturbance")
sensor = _decorator("sensor")
controller = _decorator("controller")
actuator = _decorator("actuator")
plant = _decorator("plant")
metric = _decorator("metric")
