"""A load cell that breaks: the reading of :obj:`leadscrew.sensors.load_cell` with a fault ahead of the filter.

From ``from_s`` until ``until_s`` the raw force is, by ``fault``::

    0  none           F + noise, as it was
    1  constant       the last raw force before the fault: a frozen amplifier or bus
    2  dead           noise alone: a bridge without supply
    3  saturated      size_n: the end of the range, of either sign
    4  error_code     size_n, an amplifier's number for "no reading"
    5  jump           F + noise + size_n: a slipped mount, a wrong tare
    6  drift          F + noise + size_n (t - from_s): warming up
    7  wrong_scale    size_n (F + noise), size_n without unit here: a wrong amplification
    8  frozen         size_n + noise: a strain gauge that has come off, its amplifier sound

3 and 4 differ in the number alone. NaN is not among them: a loop stops where a signal is not finite. The filter goes on
from the wrong number, ``y = keep y + (1 - keep) raw``. Encoders are not touched. Source: ours.
"""

from __future__ import annotations

from typing import Annotated, Literal, NamedTuple

from leadscrew.kernel.block import sensor
from leadscrew.kernel.parameters import Doc, Ge, Unit
from leadscrew.references._cutting_program import NEVER_S
from leadscrew.sensors._load_cell import TINY, CutReading, LatheReadingParams, LoadCellState, lathe_reading

TRUE, CONSTANT, DEAD, SATURATED, CODE, SHIFTED, DRIFT, SCALE, FROZEN = range(9)
"""Faults."""

Fault = Annotated[
    Literal["none", "constant", "dead", "saturated", "error_code", "jump", "drift", "wrong_scale", "frozen"] | int,
    Doc("what breaks, see the table"),
]


class FaultyLoadCellParams(NamedTuple):
    """The sound cell, and its fault."""

    lathe: LatheReadingParams = LatheReadingParams()
    fault: Fault = TRUE
    from_s: Annotated[float, Unit("s"), Ge(0), Doc("when it breaks")] = 1.5
    until_s: Annotated[float, Unit("s"), Ge(0), Doc("when it is sound again")] = NEVER_S
    size_n: Annotated[float, Unit("N"), Doc("what the table says")] = 1000.0


class FaultyLoadCellState(NamedTuple):
    """The sound reading, and the one that is shown."""

    lathe: LoadCellState = LoadCellState()
    force: Annotated[float, Unit("N"), Doc("filtered, as shown")] = 0.0
    raw: Annotated[float, Unit("N"), Doc("raw, as shown")] = 0.0


@sensor(FaultyLoadCellParams, FaultyLoadCellState)
def faulty_load_cell(p, s, actual, t, dt, noise):
    """Filtered and raw force of a load cell that breaks, carriage and spindle."""
    sound, reading = lathe_reading(p.lathe, s.lathe, actual, noise)
    true = reading.raw
    since = max(t - p.from_s, 0.0)
    kind = p.fault
    wrong = (
        s.raw
        if kind == CONSTANT
        else true - actual.force
        if kind == DEAD
        else p.size_n
        if abs(2 * kind - SATURATED - CODE) == 1
        else true + p.size_n
        if kind == SHIFTED
        else true + p.size_n * since
        if kind == DRIFT
        else true * p.size_n
        if kind == SCALE
        else p.size_n + true - actual.force
        if kind == FROZEN
        else true
    )
    broken = t > p.from_s - 0.5 * dt and t <= p.until_s - 0.5 * dt
    raw = wrong if broken else true
    kept = p.lathe.keep * s.force + (1.0 - p.lathe.keep) * raw
    force = kept if abs(kept) > TINY else 0.0
    return FaultyLoadCellState(sound, force, raw), CutReading(force, raw, reading.travel, reading.turns)
