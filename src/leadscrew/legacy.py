"""Defaults of version 0.1.0: what a file of ``schema_version = 1`` means where it leaves parameters out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

CURRENT = 2
"""Schema version of controller files, experiment files and sessions; 1 had the defaults below."""

DEFAULTS: Mapping[str, Mapping[str, float]] = {
    "pid": {"kp": 1.32, "ki": 0.000825, "kd": 0.006805},
    "torque_pid": {"kp": 300.0, "ki": 50_000.0, "kd": 0.9, "filter_s": 8e-5},
    "cascade_ppi": {"kpos": 193.97439, "kvp": 0.006805, "kvi": 4.2531388e-6},
    "axis_cascade": {
        "kpos": 160.18, "kvp": 0.24345, "ahead_s": 5e-4, "max_output": 10.0, "model.acceleration": 2.7057e-3,
        "model.viscous": 5.7894e-3, "model.coulomb_forward": 0.58019, "model.coulomb_backward": 0.58019,
        "model.offset": -0.09004,
    },
}  # fmt: skip
"""By block of the catalogue."""


def completed(
    schema_version: int, controller: str | None, parameters: Mapping[str, Any], prefix: str = ""
) -> dict[str, Any]:
    """The parameters of a controller, with the defaults of the version that wrote them; keys begin with ``prefix``."""
    old = DEFAULTS.get(controller or "", {}) if schema_version == 1 else {}
    both = {"max_output": ("lower", "upper")}
    return {
        f"{prefix}{key}": value
        for key, value in old.items()
        if not any(f"{prefix}{name}" in parameters for name in both.get(key, ()))
    } | dict(parameters)
