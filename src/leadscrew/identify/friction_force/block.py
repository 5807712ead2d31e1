"""LuGre of a measured force as what plants take: ``plant.friction.*``."""

from __future__ import annotations

from leadscrew.escape import one_line
from leadscrew.friction.asymmetric import TwoSidedLuGre
from leadscrew.friction.static_map import Sliding, TwoSided
from leadscrew.identify.friction_force.result import FrictionForceFit
from leadscrew.kernel.errors import ValueRefused


def lugre_of(fit: FrictionForceFit, normal: float | None = None) -> TwoSidedLuGre:
    """LuGre in N (N m); of a coefficient model at the normal force ``normal``, the mean of the log unless given.

    Raises:
        ValueRefused: a normal force that is not positive, or one for a model that knows none.
    """
    f = fit.chosen.friction
    assert isinstance(f, TwoSidedLuGre)
    if fit.load == "force":
        if normal is not None:
            raise ValueRefused(f"normal = {normal!r}: this fit is of the force, not of a coefficient")
        return f
    scale = fit.normal_mean if normal is None else normal
    if not 0.0 < scale < float("inf"):
        raise ValueRefused(f"normal = {scale!r}: allowed range is (0, inf) N")
    return TwoSidedLuGre(f.stiffness * scale, f.damping * scale, _times(f.forward, scale), _times(f.backward, scale))


def map_of(fit: FrictionForceFit, normal: float | None = None) -> TwoSided:
    """The static map of the same LuGre fit: what is left of it in steady sliding."""
    f = lugre_of(fit, normal)
    return TwoSided(f.forward, f.backward)


def _times(way: Sliding, scale: float) -> Sliding:
    return Sliding(way.coulomb * scale, way.static * scale, way.stribeck_speed, way.viscous * scale)


def settings(fit: FrictionForceFit, *, key: str = "plant.friction", normal: float | None = None) -> dict[str, float]:
    """Values by dotted key, for ``--set`` and machine files: a plant whose friction is a ``TwoSidedLuGre``."""
    f = lugre_of(fit, normal)
    found = {f"{key}.stiffness": f.stiffness, f"{key}.damping": f.damping}
    for side, way in (("forward", f.forward), ("backward", f.backward)):
        found |= {f"{key}.{side}.{name}": value for name, value in way._asdict().items()}
    return found


def set_table(fit: FrictionForceFit, source: str, *, normal: float | None = None) -> str:
    """The same as a ``[set]`` table in TOML."""
    at = "" if fit.load == "force" else f" at a normal force of {fit.normal_mean if normal is None else normal:.6g} N"
    lines = [f"{key} = {value:.8g}" for key, value in settings(fit, normal=normal).items()]
    return (
        f"# LuGre friction of {one_line(source)}{at}, from leadscrew identify friction-force\n"
        "# for a plant whose friction is TwoSidedLuGre; without stiffness and damping for one with TwoSided\n"
        "[set]\n" + "\n".join(lines) + "\n"
    )
