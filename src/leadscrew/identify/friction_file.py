"""From a logged file to friction, and from friction to a controller file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from leadscrew.identify.friction import FrictionFit, fit_friction
from leadscrew.kernel import validate
from leadscrew.logs import read_table
from leadscrew.logs.units import drive_in, length_in, plain
from leadscrew.util.errors import DataError, ValueRefused

if TYPE_CHECKING:
    import numpy as np

    from leadscrew.controller_file import ControllerFile
    from leadscrew.logs.table import Table

MADE_BY = "leadscrew identify friction"
SYMBOLS = {
    "stiffness": "sigma_0", "damping": "sigma_1", "viscous": "sigma_2", "coulomb": "F_C", "static": "F_S",
    "stribeck_speed": "v_s",
}  # fmt: skip
"""Of each parameter, in the order in which they are shown."""


def identify_file(
    path: str | Path,
    *,
    time: str = "time",
    torque: str = "output",
    position: str = "feedback",
    travel_per_rad: float | None = None,
    inertia: float | None = None,
    delay: int = 0,
    progress: Callable[[str, float], None] | None = None,
) -> FrictionFit:
    """Friction from a CSV or Parquet file, or the folder of ``leadscrew simulate --out``.

    ``time``, ``torque`` and ``position`` name columns; their headers' units count (without one: s, N m, rad). The
    position is divided by ``travel_per_rad`` to be an angle: that of the controller of a folder's run, 1 for a file,
    unless given.

    Raises:
        DataError: the file cannot be read, or the log does not determine friction; names the file.
        ValueRefused: a travel or an inertia that is not positive, a column that is no torque, or a length without a
            travel.
    """
    where = Path(path)
    travel = validate.positive(
        "travel_per_rad", travel_of(where) if travel_per_rad is None else travel_per_rad, "per rad"
    )
    if len({time, torque, position}) < 3:
        raise ValueRefused(f"time = {time!r}, torque = {torque!r}, position = {position!r}: expected three columns")
    table = read_table(where)
    seconds, drive = table.seconds(time), _torque(table, torque)
    angle = _angle(table, position, known=travel_per_rad is not None or where.is_dir()) / travel
    try:
        return fit_friction(seconds, drive, angle, inertia=inertia, delay=delay, progress=progress)
    except DataError as error:
        raise DataError(f"{path}: {error}") from None


def _torque(table: Table, column: str) -> np.ndarray:
    """N m."""
    name = table.name(column)
    unit = table.unit_of(name, "drive")
    kept, size = drive_in(unit or "N m")
    if kept == "N m" or plain(unit) == "1":
        return size * table.numbers(name)
    other = "; for a force use leadscrew identify axis" if kept == "N" else ""
    raise ValueRefused(f"{table.source}, column {name!r}: is in {unit}; expected a torque in N m{other}")


def _angle(table: Table, column: str, known: bool) -> np.ndarray:
    """rad, or the column's own unit of length where its travel per radian is ``known``."""
    name = table.name(column)
    unit = table.unit_of(name, "position")
    kind, size = length_in(unit or "rad")
    if kind == "m" and not known:
        raise ValueRefused(
            f"{table.source}, column {name!r}: is in {unit}; expected an angle, or --travel-per-rad, "
            f"{unit} for each radian"
        )
    return table.numbers(name) * (size if kind == "rad" else 1.0)


def travel_of(folder: Path) -> float:
    """Travel per radian in the run of a folder of ``simulate --out``; 1 where nothing says it."""
    from leadscrew.util import reading

    try:
        said = reading.json_object(folder / "run.json")["parameters"]["controller.travel_per_rad"]
    except (DataError, KeyError, TypeError):
        return 1.0
    return float(said) if isinstance(said, int | float) else 1.0


def controller_with(fit: FrictionFit, study: str, controller: str, source: str) -> ControllerFile:
    """The controller file with the identifiable friction as what the controller believes; the rest stays its own.

    Raises:
        NameUnknown: no such study or controller.
        ValueRefused: a controller that believes no LuGre friction, or whose own static friction lies below the
            Coulomb friction of the log.
    """
    from leadscrew import resolve
    from leadscrew._version import __version__
    from leadscrew.controller_file import ControllerFile
    from leadscrew.friction.lugre import LuGre

    params = resolve.controller(resolve.study(study), controller).params
    own = getattr(params, "hat", None)
    if not isinstance(own, LuGre):
        raise ValueRefused(
            f"--controller {controller}: believes no LuGre friction (it has no parameters 'hat'); ours.pd_dob does"
        )
    known = fit.known()
    if "static" not in known and own.static < fit.friction.coulomb:
        raise ValueRefused(
            f"{source}: static friction is not identifiable, and hat.static = {own.static:g} N m of {controller} lies "
            f"below the Coulomb friction of the log, {fit.friction.coulomb:.4g} N m: log the move friction_test, or "
            "set hat.static in a controller file and name that with -c"
        )
    values: dict[str, Any] = {f"hat.{name}": value for name, value in known.items()}
    if hasattr(params, "inertia"):
        values["inertia"] = fit.inertia
    return ControllerFile(study, controller, values, origin(fit, source, __version__))


def origin(fit: FrictionFit, source: str, version: str) -> dict[str, Any]:
    """The table ``[tuning]`` of the file: where the parameters come from, and their standard errors."""
    notes = [f"made by {MADE_BY} from {source}"]
    unknown = [name for name, known in fit.identifiable.items() if not known]
    if unknown:
        notes.append(f"not identifiable from the log, so the controller's own: {', '.join(unknown)}")
    if not fit.consistent:
        notes.append(f"not quite LuGre: {fit.residuals.why_not}")
    percent = {n: round(100.0 * fit.standard_error[n] / v, 3) for n, v in fit.known().items() if v > 0.0}
    return {"made_by": MADE_BY, "leadscrew": version, "notes": notes, "standard_error_percent": percent}


def table_rows(fit: FrictionFit) -> list[tuple[str, str, str, str, str]]:
    """Name, value, standard error, the same in percent, and whether the log determines it."""
    rows = []
    for name, symbol in SYMBOLS.items():
        p, error = fit.parameters[name], fit.standard_error[name]
        share = f"{100.0 * error / p.value:.2g} %" if p.value > 0.0 and error < float("inf") else ""
        rows.append((f"{name} ({symbol})", f"{p.value:.6g} {p.unit}", f"{error:.2g}", share,
                     "" if p.identifiable else "not identifiable: a usual value"))  # fmt: skip
    share = "given" if fit.inertia_given else f"{100.0 * fit.standard_error['inertia'] / fit.inertia:.2g} %"
    error_text = "" if fit.inertia_given else f"{fit.standard_error['inertia']:.2g}"
    rows.append(("inertia (J)", f"{fit.inertia:.6g} kg m^2", error_text, share, ""))
    rows.append(("offset", f"{fit.offset:.3g} N m", f"{fit.standard_error['offset']:.2g}", "", ""))
    return rows
