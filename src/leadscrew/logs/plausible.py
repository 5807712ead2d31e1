"""Whether signals can be what they are called: units wrong by 1000, swapped columns, a command that follows.

The limits are far outside what machine tools do, so that what is refused is a wrong unit and not a fast machine.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from leadscrew.logs.finding import Finding
from leadscrew.logs.measure import Motion, motion

TOP = {"m": (20.0, 1e4, 100.0), "rad": (2e4, 1e8, 1e7)}
"""Speed, acceleration and travel that no axis exceeds, by the unit they are in (20 m/s, 1000 g, 100 m)."""

SLOW_SPEED, SLOW_TRAVEL = 5e-4, 1e-3
"""m/s and m below which a linear axis hardly moves at all."""

MASS = {"m": (0.5, 5e3, "kg"), "rad": (1e-6, 1e2, "kg m^2")}
"""What an axis moves, by the unit of its position: most do, and an axis wrong by 1000 is outside."""

FELT = 0.1
"""Share of the drive's variation that the acceleration must make for its mass to count."""


def check_units(position: np.ndarray, moves: Motion, period: float, unit: str) -> list[Finding]:
    """Speed, acceleration and travel that an axis can have."""
    speed, acceleration, travel = TOP[unit]
    far = float(np.ptp(position))
    for name, value, top, per in (
        ("top speed", moves.top_speed, speed, "/s"),
        ("top acceleration", moves.top_acceleration, acceleration, "/s2"),
        ("travel", far, travel, ""),
    ):
        if value > top:
            other = "mm" if unit == "m" else "deg"
            said = (
                f"the {name} of the position is {value:.3g} {unit}{per}, more than {top:g} {unit}{per}: the unit is "
                f"wrong; if it is in {other}, say --unit position={other}, if the times are in ms, --unit time=ms"
            )
            return [Finding("unit", "refused", said)]
    peak = float(np.abs(moves.speed).max())
    if unit == "m" and peak < SLOW_SPEED and far < SLOW_TRAVEL:
        said = (
            f"the position moves by {far:.3g} m in all, at most at {peak:.3g} m/s: slow for an axis, "
            "unless it is a test of pre-sliding; if the position is in m, say --unit position=m, if the times are in "
            "s, --unit time=s"
        )
        return [Finding("unit", "warning", said)]
    return []


def check_command(position: np.ndarray, command: np.ndarray, period: float) -> list[Finding]:
    """A command that the position follows, in the same unit, and not the other way round."""
    if not np.ptp(command) or not np.ptp(position):
        return []
    ratio = _thousand(float(np.std(command) / np.std(position)))
    likeness = float(np.corrcoef(command, position)[0, 1])
    if ratio and abs(likeness) > 0.9:
        said = (
            f"the command moves {np.std(command) / np.std(position):.4g} times as far as the position: one of the two "
            "is in another unit; say --unit command=UNIT or --unit position=UNIT"
        )
        return [Finding("unit", "refused", said)]
    if likeness < -0.9:
        said = "the position runs against its command: the sign of one of the two is wrong"
        return [Finding("sign", "warning", said)]
    lag = _lag(position, command, period)
    if lag < 0 and likeness > 0.5:
        said = (
            f"the position runs {-lag * period:.3g} s ahead of its command: the two columns look swapped; if so, name "
            "them with --column position=NAME --column command=NAME"
        )
        return [Finding("swapped", "refused", said)]
    return []


def check_velocity(moves: Motion, velocity: np.ndarray) -> list[Finding]:
    """A velocity that is the derivative of the position."""
    inner = slice(moves.margin, len(velocity) - moves.margin or None)
    mine, given = moves.speed[inner], velocity[inner]
    if not np.any(mine) or not np.any(given):
        return []
    likeness = float(mine @ given / np.sqrt((mine @ mine) * (given @ given)))
    slope = float(given @ mine / (mine @ mine))
    if abs(likeness) < 0.5:
        said = (
            f"the velocity is not the derivative of the position (they agree to {100.0 * likeness:.0f} %): is it its "
            "column, and is the record whole?"
        )
        return [Finding("velocity", "warning", said)]
    if not 0.5 < abs(slope) < 2.0:
        said = (
            f"the velocity is {abs(slope):.4g} times the derivative of the position: one of the two, or the time, is "
            "in another unit; say --unit velocity=UNIT, --unit position=UNIT or --unit time=UNIT"
        )
        return [Finding("unit", "refused" if _thousand(abs(slope)) else "warning", said)]
    return [Finding("sign", "warning", "the velocity has the other sign than the position's derivative")] * (
        slope < 0.0
    )


def check_drive(
    arrays: Mapping[str, np.ndarray], moves: Motion, period: float, unit: str, force: float | None
) -> list[Finding]:
    """A drive that moves the position, and is not the position itself.

    ``unit`` is that of the position, ``force`` the N (N m) of one unit of the drive, if known.
    """
    drive, position = arrays["drive"], arrays["position"]
    if not np.ptp(drive) or not np.ptp(position):
        return []
    told, values = _explained(drive, moves)
    other, _ = _explained(position, motion(drive, period))
    if _rough(position) > 3.0 * _rough(drive) and other > 0.8 and told < 0.5:
        said = (
            "the position looks like a drive and the drive like a position: the two columns are swapped; name them "
            "with --column drive=NAME --column position=NAME"
        )
        return [Finding("swapped", "refused", said)]
    if (command := arrays.get("command")) is not None and np.ptp(command):
        follows, led = (float(np.corrcoef(x, position)[0, 1]) for x in (drive, command))
        if follows > 0.999 and abs(led) < 0.95:
            said = (
                f"the position follows the drive (to {100.0 * follows:.2f} %) as it should follow its command: the "
                "columns are swapped; name them with --column drive=NAME --column command=NAME"
            )
            return [Finding("swapped", "refused", said)]
    if force and told > 0.6 and (odd := _odd_mass(values[1], drive, moves, unit, force)):
        return [odd]
    if told > 0.6 and values[1] < 0.0 and values[2] < 0.0:
        return [Finding("sign", "note", "a positive drive moves the axis backwards: its force is negative")]
    return []


def _odd_mass(mass: float, drive: np.ndarray, moves: Motion, unit: str, force: float) -> Finding | None:
    """Warns of a mass that few axes have; ``mass`` is in units of the drive."""
    low, high, name = MASS[unit]
    inner = slice(moves.margin, len(drive) - moves.margin or None)
    felt = abs(mass) * float(np.std(moves.acceleration[inner])) > FELT * float(np.std(drive))
    if not felt or mass * force <= 0.0 or low <= mass * force <= high:
        return None
    other = {"m": ("kN", "mN"), "rad": ("kN m", "N mm")}[unit][int(mass * force > high)]
    said = (
        f"drive and position are those of {'a mass' if unit == 'm' else 'an inertia'} of {mass * force:.3g} {name}, "
        f"outside {low:g} to {high:g} {name} of most axes: if the axis is another one, is the unit of the drive, the "
        f"position or the time wrong by 1000 (for a drive in {other} say --unit drive='{other}'), or the force of one "
        "unit of the drive (--force-per-drive)?"
    )
    return Finding("unit", "warning", said)


def _explained(drive: np.ndarray, moves: Motion) -> tuple[float, np.ndarray]:
    """Share of the drive's variance that offset, mass and friction explain, and their coefficients."""
    kept = slice(moves.margin, len(drive) - moves.margin or None)
    speed = moves.speed[kept]
    terms = np.column_stack([np.ones(len(speed)), moves.acceleration[kept], speed, np.sign(speed)])
    size = np.maximum(np.abs(terms).max(axis=0), 1e-300)
    values, *_ = np.linalg.lstsq(terms / size, drive[kept], rcond=1e-10)
    left = drive[kept] - terms / size @ values
    spread = float(np.var(drive[kept]))
    return (1.0 - float(np.var(left)) / spread if spread else 0.0), values / size


def _rough(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.diff(values) ** 2)) / np.std(values))


def _thousand(ratio: float) -> bool:
    """Whether a ratio is that of two units that are often mistaken for one another."""
    known = (1e3, 1e6, 25.4, 25400.0, 2.0 * np.pi, 360.0, 180.0 / np.pi, 60.0, 6e4, 1e-3 * 60.0)
    return any(abs(ratio / x - 1.0) < 0.2 or abs(ratio * x - 1.0) < 0.2 for x in known)


def _lag(position: np.ndarray, command: np.ndarray, period: float) -> int:
    """Samples by which the position follows its command; 0 unless it runs ahead clearly, by two samples or more."""
    most = int(np.clip(0.2 / period, 2, len(position) // 4))
    at = slice(most, len(position) - most)
    shifts = np.unique(
        np.concatenate([np.arange(-min(most, 20), min(most, 20) + 1), np.linspace(-most, most, 41).astype(int)])
    )
    place = np.arange(len(position))[at]
    apart = {int(k): float(np.std(position[place] - command[place - k])) for k in shifts}
    best = min(apart, key=lambda k: (apart[k], abs(k)))
    return best if best <= -2 and apart[best] < 0.5 * apart[0] else 0
