"""A nonlinear controller taken apart: the static map of the error, and the linear controller behind it (Lur'e form).

    e = command - feedback,   f = phi(e) = K(e) e,   u = C f        and the loop is   e = -G phi(e),   G = P C

``phi`` lies in the sector ``[k1, k2]`` where ``k1 <= phi(e) / e <= k2``, and in the slope sector ``[s1, s2]`` where
every secant between two of its points has a slope from ``s1`` to ``s2``. The absolute-stability criteria ask for the
first, a proof for a loop under load or on the move for the second (H. K. Khalil, *Nonlinear Systems*, 3rd ed.,
Prentice Hall 2002, section 7.1; C. A. Desoer, M. Vidyasagar, *Feedback Systems*, Academic Press 1975, chapter 6).

:func:`lure` knows the maps of the library's controllers (below), also inside a wrapper that adds a
feed-forward, and takes a controller that answers linearly as one with ``phi(e) = e``. It does not take anybody's word:
the block's own step is run on random errors, and so is the linear part behind the map; both must answer the same. Under
a command that moves, the answer to an error must be the one at rest, beside what the command alone makes
(:func:`moved_by_command`): a controller that schedules on the command, or adapts to it, is
refused. For a controller of your own, declare the map::

    @declare(MyParams)
    def my_map(p):
        return ErrorMap(
            gain=lambda e: ..., slope=lambda e: ..., sector=(1.0, 2.0), slope_sector=(1.0, 2.5), linear={"alpha": 0.0}
        )

where ``linear`` names the parameters, with their values, that make ``phi(e) = e``.

Trials of a controller by its own step: its answer to errors at rest, and whether a command changes it.

A controller is a part of a Lur'e loop where its output is what the command alone makes, plus what the error makes:

    u(r, r - e) - u(r, r) = u(0, -e) - u(0, 0)            for every command r and every row of errors e

A feed-forward, the weights of a 2-DOF controller and a look-ahead add what the command makes and pass. A gain that is
scheduled on the command, and shares that are learned from the error times the command, do not.

The maps of the library's nonlinear controllers:

===========  ================================================  =============================
npid         ``K = cosh(alpha min(|e|, e_max))``, clip or not  slope up to cosh x + x sinh x
npid_slope   ``1 + (k - 1)(1 - es/|e| atan(|e|/es))``          slope up to ``k``
npid_after   ``K`` of npid, behind the PID                     no static map
npid_split   ``large = e - es atan(e / es)``, a path of its    slope in [0, 1]
             own beside the PID of the small errors
===========  ================================================  =============================
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from leadscrew.controllers import _npid as npid
from leadscrew.controllers import _npid_after as npid_after
from leadscrew.controllers import _npid_slope as npid_slope
from leadscrew.controllers import _npid_split as npid_split
from leadscrew.controllers._npid_split import NPIDSplitParams, NPIDSplitState, paths
from leadscrew.kernel.block import Block, make
from leadscrew.util.errors import LeadscrewError, ValueRefused

LENGTH = 60
"""Periods of each trial of a controller's answer."""

LONG = 2000
"""Periods of the one long trial under a command: 1 s at 2 kHz."""

ALIKE = 1e-8
"""Two answers are the same up to this, relative to the largest value: rounding of unlike orders of computation."""

ROUNDING = 1e-13
"""What rounding leaves of a known output, relative to it."""

MOVES = (
    (0.0, 0.008, 5.0),
    (0.0, 1.0, 0.7),
    (-10.0, 3.0, 12.0),
    (2.0, -0.2, 60.0),
    (-200.0, 300.0, 1.0),
    (15.0, 0.0, 0.0),
)
"""Commands: offset in mm, amplitude in mm, frequency in Hz. From 8 um to 0.3 m, up to 1.9 m/s, of both signs."""

LONG_MOVE = (1.0, 1.0, 2.1)
"""The command of the long trial."""


def moved_by_command(block: Block, sizes: tuple[float, ...], rng: np.random.Generator, period: float) -> str | None:
    """The first command under which the block answers an error otherwise than at rest, in words; None where none is.

    ``sizes`` of the errors in mm.
    """
    trials = [(move, LENGTH, sizes) for move in MOVES]
    for move, length, each in (*trials, (LONG_MOVE, LONG, sizes[-1:])):
        r = moving(move, length, period)
        alone = answer(block, np.zeros(length), period, r)
        known = answer(block, np.zeros(length), period)
        for size in each:
            errors = size * rng.normal(size=length)
            at_rest = answer(block, errors, period) - known
            whole = float(np.abs(at_rest).max())
            if not math.isfinite(whole):  # an unstable controller runs away by itself in the long trial
                continue
            under = answer(block, errors, period, r) - alone
            rounding = ROUNDING * float(np.abs(alone).max() + np.abs(known).max())
            if not float(np.abs(under - at_rest).max()) <= ALIKE * whole + rounding:
                return words(move)
    return None


def words(move: tuple[float, float, float]) -> str:
    """A command for a sentence."""
    offset, amplitude, hz = move
    if not hz:
        return f"a command that stands at {offset:g} mm"
    around = f" around {offset:g} mm" if offset else ""
    return f"a command that moves by {abs(amplitude):g} mm at {hz:g} Hz{around}"


def moving(move: tuple[float, float, float], length: int, period: float) -> np.ndarray:
    """Position, velocity and acceleration of a command, a row for each period."""
    offset, amplitude, hz = move
    w = 2.0 * math.pi * hz
    t = period * np.arange(length)
    wave, turned = amplitude * np.sin(w * t), amplitude * np.cos(w * t)
    return np.column_stack([offset + wave, w * turned, -w * w * wave])


def answer(block: Block, errors: np.ndarray, period: float, commands: np.ndarray | None = None) -> np.ndarray:
    """Outputs of a block at rest to a row of errors, by its own step; NaN where the step has no number.

    ``commands``: a row of position, velocity and acceleration for each error; a controller of a number gets the
    position. At rest without.

    Raises:
        ValueRefused: a controller of several axes.
    """
    plan = block.params if block.prepare is None else block.prepare(block.params, period)
    state = block.state if block.initial is None else block.initial(block.params)
    moves = np.zeros((len(errors), 3)) if commands is None else commands
    for given in _as_numbers(moves), _as_motions(moves):
        s, out = copy.deepcopy(state), []
        try:
            for k, (command, error) in enumerate(zip(given, errors, strict=True)):
                now = {
                    "command": command, "feedback": float(moves[k, 0] - error), "t": k * period, "dt": period
                }  # fmt: skip
                done = block.step(*(x for x in (plan, s) if x is not None), *(now[name] for name in block.signals))
                s, u = done if block.state is not None else (None, done)
                out.append(float(u))
        except (AttributeError, TypeError):
            continue
        except (ArithmeticError, ValueError):
            return np.full(len(errors), np.nan)
        return np.array(out)
    raise ValueRefused(
        f"{block.name} takes or gives several numbers where a loop of one axis has one position, one feedback and one "
        "output; take apart one axis of it"
    )


def _as_numbers(moves: np.ndarray) -> Iterator[float]:
    return (float(row[0]) for row in moves)


def _as_motions(moves: np.ndarray) -> Iterator[object]:
    from leadscrew.references._motion import Motion

    return (Motion(*(float(x) for x in row)) for row in moves)


SIZES_MM = (1e-5, 1e-3, 1e-1, 10.0)
"""Errors for which an undeclared controller must answer in proportion to be taken as linear, mm: 10 nm to 10 mm."""


@dataclass(frozen=True)
class ErrorMap:
    """What is declared of a nonlinear controller; errors in mm."""

    gain: Callable[[float], float]
    """``K(e) = phi(e) / e``; at 0 its limit."""
    slope: Callable[[float], float]
    """``dphi/de``."""
    sector: tuple[float, float]
    """``k1 <= K(e) <= k2`` for every error."""
    slope_sector: tuple[float, float] | None
    """``s1 <= dphi/de <= s2`` for every error; None where the gain stands behind the linear part."""
    linear: Mapping[str, Any] = field(default_factory=dict)
    """Parameters that make ``phi(e) = e``."""
    scale_mm: float = math.inf
    """Error at which the map has got to its bound or near it: ``e_max``, ``es``."""
    error_unit_per_mm: float = 1.0
    """Unit in which the map counts the error."""
    dependent: bool = False
    """The gain stands behind the linear part, ``u = K(e) C e``: not a static map of what it multiplies."""
    notes: tuple[str, ...] = ()
    """What a reader of a certificate must know of the map."""
    shared: Callable[[float], Block] | None = None
    """For a map with a linear path beside it, ``u = C0 e + C1 phi(e)``: the linear block with ``phi(e) = s e``, by
    ``s``; all of them with the same states."""


@dataclass(frozen=True)
class Lure:
    """A controller in Lur'e form; errors in mm, all functions take numbers or arrays."""

    block: Block
    linear: Block
    """The controller with ``phi(e) = e`` and without a limit of its output."""
    map: ErrorMap
    nonlinear: bool
    """False where ``phi(e) = e``: the sector is (1, 1)."""
    notes: tuple[str, ...] = ()
    """What the proof leaves out, in sentences."""

    def gain(self, e_mm: Any) -> Any:
        """``K(e) = phi(e) / e``."""
        return _each(self.map.gain, e_mm)

    def curve(self, e_mm: Any) -> Any:
        """``phi(e)``, in mm."""
        return _each(lambda e: self.map.gain(e) * e, e_mm)

    def slope(self, e_mm: Any) -> Any:
        """``dphi/de``: the local loop gain at an error, relative to the linear part."""
        return _each(self.map.slope, e_mm)

    @property
    def sector(self) -> tuple[float, float]:
        """``(k1, k2)``: ``k1 <= K(e) <= k2``."""
        return self.map.sector

    @property
    def slope_sector(self) -> tuple[float, float] | None:
        """``(s1, s2)``: bounds of ``dphi/de``; None where the gain is :attr:`dependent`."""
        return self.map.slope_sector

    @property
    def dependent(self) -> bool:
        """Whether the gain multiplies the output of the linear part: then it is a gain that varies, no static map.

        Criteria for gains that vary in time (the circle) hold for it; Popov, Tsypkin and Jury-Lee do not.
        """
        return self.map.dependent

    @property
    def error_unit_per_mm(self) -> float:
        """Units of the error inside the map to a millimetre: 1000 for um."""
        return self.map.error_unit_per_mm

    @property
    def error_unit(self) -> str:
        """Unit of the error inside the map: ``um``, ``mm``, or how many make a millimetre."""
        units = self.map.error_unit_per_mm
        return {1000.0: "um", 1.0: "mm"}.get(units, f"1/{units:g} mm")

    @property
    def odd(self) -> bool:
        """Whether ``phi(-e) = -phi(e)``, as far as errors around its bend tell."""
        scale = self.map.scale_mm if math.isfinite(self.map.scale_mm) else 1.0
        errors = scale * np.geomspace(1e-3, 1e3, 61)
        return bool(np.allclose(self.gain(errors), self.gain(-errors), rtol=1e-12, atol=0.0))

    @property
    def scale_mm(self) -> float:
        """Error at which the map has got to its bound or near it, mm; infinite where it is a straight line."""
        return self.map.scale_mm


STRAIGHT = ErrorMap(lambda _: 1.0, lambda _: 1.0, (1.0, 1.0), (1.0, 1.0))
"""``phi(e) = e``."""

_declared: dict[type, Callable[[Any], ErrorMap]] = {}


def declare(params: type) -> Callable[[Callable[[Any], ErrorMap]], Callable[[Any], ErrorMap]]:
    """Decorator: the map of all controllers that have parameters of this type, as a function of the parameters."""

    def keep(made: Callable[[Any], ErrorMap]) -> Callable[[Any], ErrorMap]:
        _declared[params] = made
        return made

    return keep


def lure(block: Block, period: float = 5e-4) -> Lure:
    """A controller as a static map of the error in front of a linear controller.

    Args:
        block: the controller.
        period: of the trials, in seconds; a controller whose plan depends on it is tried at its own.

    Raises:
        ValueRefused: no controller of one position error, nonlinear without a declared map, or another law than the
            map says, or one that depends on the command; the sentence tells what to do.
    """
    if block.kind != "controller" or block.continuous:
        raise ValueRefused(f"{block.name}: a loop is taken apart at a sampled controller, and this is none")
    notes: list[str] = []
    limits = dict(_limits(block.params))
    if limits:
        values = ", ".join(f"{key} = {_at(block.params, key):g}" for key in limits)
        unit = f" {block.unit}" if block.unit else ""
        notes.append(
            f"the limit of the output, {values}{unit}, is not in the proof: it holds while the output stays inside"
        )
    free = _with(block, limits)
    found = [(prefix, _maps()[type(p)](p)) for prefix, p in _own(free.params) if type(p) in _maps()]
    bent = [(prefix, m) for prefix, m in found if m.sector != (1.0, 1.0) or m.slope_sector != (1.0, 1.0)]
    if len(bent) > 1:
        raise ValueRefused(f"{block.name} has {len(bent)} nonlinear gains; a Lur'e loop has one")
    rng = np.random.default_rng(8)
    if not bent:
        if not _linear(free, rng, period):
            raise ValueRefused(_undeclared(block))
        _check_commands(block, free, SIZES_MM[1:3], rng, period)
        return Lure(block, free, STRAIGHT, nonlinear=False, notes=tuple(notes))
    prefix, law = bent[0]
    _check_bounds(block, law)
    if law.shared is not None and prefix:
        raise ValueRefused(f"{block.name}: two paths inside another controller are not taken apart; certify them alone")
    straight = {f"{prefix}{k}": v for k, v in law.linear.items()}
    linear = _with(free, straight) if law.shared is None else law.shared(1.0)
    taken = Lure(block, linear, law, nonlinear=True, notes=(*notes, *law.notes))
    if not _linear(linear, rng, period):
        raise ValueRefused(
            f"{block.name}: with its map made a straight line ({', '.join(law.linear)}) it still does not answer in "
            "proportion to the error, so something in it beside the declared map is nonlinear"
        )
    if not _same(taken, free, rng, period):
        where = "behind" if law.dependent else "in front of"
        raise ValueRefused(
            f"{block.name} does not answer as its map {where} its linear part: either the declared map is another one, "
            "or a part of the controller (a resonator, an observer) works beside the nonlinear gain and not behind "
            "it, and then the loop is not one map in front of one linear loop; certify the controller without that part"
        )
    scale = law.scale_mm if math.isfinite(law.scale_mm) else 1e-3
    _check_commands(block, free, (0.3 * scale, 5.0 * scale), rng, period)
    return taken


def _check_commands(
    block: Block, free: Block, sizes: tuple[float, ...], rng: np.random.Generator, period: float
) -> None:
    """Refuses a controller whose answer to an error depends on the command."""
    found = moved_by_command(free, sizes, rng, period)
    if found is not None:
        raise ValueRefused(
            f"{block.name} answers the same error differently under {found} than at rest: it schedules on the command "
            "or adapts to it, so what is proved of its loop at rest does not hold while the axis moves, and it is not "
            "certified; certify it with its gains or shares held (a rate of 0, say)"
        )


def _check_bounds(block: Block, law: ErrorMap) -> None:
    """Looks for an error at which the map leaves the sectors that are declared for it."""
    scale = law.scale_mm if math.isfinite(law.scale_mm) else 1.0
    half = np.sort(np.concatenate([np.geomspace(1e-6, 1e6, 361), np.linspace(0.0, 3.0, 301)[1:]]))
    half = scale * half[np.diff(half, prepend=0.0) > 1e-9 * half]
    errors = np.concatenate([-half[::-1], [0.0], half])
    gains = np.array([law.gain(float(e)) for e in errors])
    secants = np.diff(gains * errors) / np.diff(errors)
    for what, values, bounds in (("gain K(e)", gains, law.sector), ("slope", secants, law.slope_sector)):
        if bounds is None:
            continue
        worst = int(np.argmax(np.maximum(bounds[0] - values, values - bounds[1])))
        if not bounds[0] - 1e-6 <= values[worst] <= bounds[1] + 1e-6:
            raise ValueRefused(
                f"{block.name}: its map is declared with a {what} from {bounds[0]:g} to {bounds[1]:g}, but at an error "
                f"of {1e3 * errors[worst]:.4g} um it is {values[worst]:.6g}"
            )


def _undeclared(block: Block) -> str:
    return (
        f"{block.name} does not answer in proportion to the error, and no map of the error is declared for it: if it "
        "is a static gain K(e) in front of a linear controller, declare it with declare("
        f"{type(block.params).__name__}) of leadscrew.analysis.stability.lure; a controller that schedules, switches "
        "or adapts in another way is not a Lur'e loop, and these criteria do not apply to it"
    )


# ---- the maps of the library
def _maps() -> dict[type, Callable[[Any], ErrorMap]]:
    if not _library:
        _library.update(known())
    return {**_library, **_declared}


_library: dict[type, Callable[[Any], ErrorMap]] = {}


# ---- trials
def _linear(block: Block, rng: np.random.Generator, period: float) -> bool:
    """Whether the answer to a sum is the sum of the answers, at every size of the error."""
    rest = answer(block, np.zeros(LENGTH), period)
    shapes = rng.normal(size=(2, LENGTH))
    unit = [answer(block, x, period) - rest for x in shapes]
    whole = max(float(np.abs(u).max()) for u in unit)
    if not math.isfinite(whole) or whole == 0.0:
        return False
    for size in SIZES_MM:
        parts = [answer(block, size * x, period) - rest for x in shapes]
        both = answer(block, size * (shapes[0] + shapes[1]), period) - rest
        floor = 1e-14 * float(np.abs(rest).max()) / size  # what rounding leaves of a known output
        worst = max(
            float(np.abs(p / size - u).max()) for p, u in zip([*parts, both], [*unit, unit[0] + unit[1]], strict=True)
        )
        if not worst <= ALIKE * whole + 10.0 * floor:
            return False
    return True


def _same(taken: Lure, free: Block, rng: np.random.Generator, period: float) -> bool:
    """Whether the block answers as the linear part does to the mapped error, around the bend of the map."""
    scale = taken.scale_mm if math.isfinite(taken.scale_mm) else 1e-3
    for size in (0.3, 1.0, 5.0):
        errors = size * scale * rng.normal(size=LENGTH)
        if taken.map.shared is not None:
            ends = [answer(taken.map.shared(s), x, period) for s, x in ((0.0, errors), (0.0, taken.curve(errors)))]
            expected = ends[0] - ends[1] + answer(taken.linear, taken.curve(errors), period)
        elif taken.dependent:
            expected = taken.gain(errors) * answer(taken.linear, errors, period)
        else:
            expected = answer(taken.linear, taken.curve(errors), period)
        mine = answer(free, errors, period)
        if not np.allclose(mine, expected, rtol=0.0, atol=ALIKE * float(np.abs(expected).max())):
            return False
    return True


# ---- parameters by place
def _own(params: Any, prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Every NamedTuple among the parameters, with the start of its dotted keys."""
    if isinstance(params, tuple) and hasattr(params, "_fields"):
        yield prefix, params
        for name, value in zip(params._fields, params, strict=True):
            yield from _own(value, f"{prefix}{name}.")


UNLIMITED = {"lower": -math.inf, "upper": math.inf, "max_output": 0.0}
"""Parameters that limit an output, with the value that does not."""


def _limits(params: Any) -> Iterator[tuple[str, float]]:
    """The keys of limits that act, with the value that lifts them."""
    for prefix, p in _own(params):
        for name, unlimited in UNLIMITED.items():
            value = getattr(p, name, unlimited)
            if isinstance(value, float | int) and value != unlimited:
                yield f"{prefix}{name}", unlimited


def _at(params: Any, key: str) -> Any:
    for name in key.split("."):
        params = getattr(params, name)
    return params


def _with(block: Block, changes: Mapping[str, Any]) -> Block:
    """The block with parameters changed by dotted key."""
    from leadscrew.kernel.parameters import checked_replace

    if not changes:
        return block
    try:
        return replace(block, params=checked_replace(block.params, changes, where=block.name))
    except LeadscrewError as error:
        raise ValueRefused(f"{block.name}: its declared map does not fit it: {error}") from error


def _each(function: Callable[[float], float], e_mm: Any) -> Any:
    if np.ndim(e_mm) == 0:
        return float(function(float(e_mm)))
    values = np.asarray(e_mm, dtype=float)
    return np.array([function(float(e)) for e in values.ravel()]).reshape(values.shape)


LARGEST = 100.0
"""Of ``alpha e_max``: the gain is 1e43 there."""


def known() -> dict[type, Callable[[Any], ErrorMap]]:
    """The maps by the type of the controller's parameters."""

    def cosh(p: Any) -> ErrorMap:
        x = p.alpha * p.e_max
        if x > LARGEST:
            raise ValueRefused(
                f"alpha e_max = {x:g} (npid): cosh of it has no number; at most {LARGEST:g}. Is e_max in the unit of "
                "the error inside the gain?"
            )
        top, steepest = math.cosh(x), math.cosh(x) + x * math.sinh(x)
        clipped = bool(p.clip_error)
        note = (
            "the error itself is clipped: phi stays where it is beyond e_max, so the lower bound of the sector is 0, "
            "and a table that falls behind by more than e_max is pulled back with a constant effort only"
        )
        return ErrorMap(
            lambda e: npid.curve(p, e) / e if e else 1.0,
            lambda e: npid.slope(p, e),
            (0.0 if clipped else 1.0, top),
            (0.0 if clipped else 1.0, steepest),
            {"alpha": 0.0, "clip_error": False},
            p.e_max / p.error_unit_per_mm,
            p.error_unit_per_mm,
            notes=(note,) if clipped else (),
        )

    def limited(p: Any) -> ErrorMap:
        return ErrorMap(
            lambda e: npid_slope.curve(p, e) / e if e else 1.0,
            lambda e: npid_slope.slope(p, e),
            (1.0, p.k),
            (1.0, p.k),
            {"k": 1.0},
            p.es_um * npid_slope.MM_PER_UM,
            1.0 / npid_slope.MM_PER_UM,
        )

    def behind(p: Any) -> ErrorMap:
        note = (
            "the gain stands behind the PID: it is taken as a gain that varies in time between its bounds, for which "
            "the circle criterion holds, and Popov, Tsypkin and Jury-Lee do not; under a load or a following error "
            "nothing is proved beyond that the loop stays bounded"
        )
        return ErrorMap(
            lambda e: npid_after.gain(p, e),
            lambda e: npid_after.slope(p, e),
            (1.0, math.cosh(p.alpha * p.e_max)),
            None if p.alpha > 0.0 else (1.0, 1.0),
            {"alpha": 0.0},
            p.e_max / p.error_unit_per_mm,
            p.error_unit_per_mm,
            dependent=True,
            notes=(note,),
        )

    def parted(p: Any) -> ErrorMap:
        knee = p.es_um * npid_split.MM_PER_UM
        return ErrorMap(
            lambda e: 1.0 - npid_split.parted(p, e) / e if e else 0.0,
            lambda e: (e / knee) ** 2 / (1.0 + (e / knee) ** 2),
            (0.0, 1.0),
            (0.0, 1.0),
            scale_mm=knee,
            error_unit_per_mm=1.0 / npid_split.MM_PER_UM,
            notes=("the map is the part of the error that goes to the firm path; the quiet path is closed beside it",),
            shared=lambda share: _shared(p, share),
        )

    return {
        npid.NPIDParams: cosh,
        npid_slope.NPIDSlopeParams: limited,
        npid_after.NPIDAfterParams: behind,
        npid_split.NPIDSplitParams: parted,
    }


class Shared(NamedTuple):
    """Both paths, and which part of the error the firm one gets."""

    law: NPIDSplitParams
    share: float


def _shared(p: Any, share: float) -> Block:
    """The two paths of ``npid_split`` with a fixed share of the error for the firm one."""

    def shared(p, s, command, feedback, dt):
        error = command - feedback
        return paths(p.law, s, (1.0 - p.share) * error, p.share * error, dt)

    return make("controller", shared, Shared(p, share), NPIDSplitState(), name="npid_split with fixed shares")
