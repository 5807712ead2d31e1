"""The keys of a machine file with their ranges; imported only when one is read, because pydantic is heavy."""

from __future__ import annotations

from contextlib import suppress
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator

from leadscrew import toml_file
from leadscrew.file_schema import Finite, Name, Pair, Table, one_line
from leadscrew.util.errors import ValueRefused

Line = Annotated[Name, one_line(100)]
Bound = Annotated[float, Field(ge=1e-12, le=1e12)]
Number = Annotated[float, Field(ge=0, le=1e12)]


def _flat(table: Any) -> Any:
    """With dotted keys in the place of tables."""
    return dict(toml_file.flat(table)) if isinstance(table, dict) else table


Model = Literal["servo_axis", "servo_axis_lugre", "linear"]


class LimitsTable(Table):
    """What the axis bears."""

    drive: Bound
    speed: Bound
    acceleration: Bound
    travel: Pair


class CascadeTable(Table):
    """The controller that made the log."""

    kp: Number | None = None
    kv: Number | None = None
    ki: Number | None = None


class LogTable(Table):
    """The log, and how it is read."""

    file: Name
    sha256: Name
    columns: dict[str, Any] | None = None
    units: dict[str, Any] | None = None
    start: Finite | None = None
    end: Finite | None = None
    period: Finite | None = None


class MachineTable(Table):
    """The whole file."""

    schema_version: Literal[1]
    kind: Literal["machine"]
    name: Line
    model: Model
    position_unit: Line
    drive_unit: Line
    period: Annotated[float, Field(ge=1e-6, le=1)]
    delay_s: Annotated[float, Field(ge=0, le=1)] = 0.0
    resolution: Annotated[float, Field(ge=0, le=1e3)] = 0.0
    noise: Annotated[float, Field(ge=0, le=1e3)] = 0.0
    limits: LimitsTable
    parameters: Annotated[dict[str, Any], BeforeValidator(_flat)] = Field(default_factory=dict, alias="set")
    interval: Annotated[dict[str, Pair], BeforeValidator(lambda table: dict(toml_file.flat(table)))] = Field(
        default_factory=dict
    )
    cascade: CascadeTable = CascadeTable()
    log: LogTable | None = None
    identified: dict[str, Any] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _force(self) -> MachineTable:
        """A torque that moves a length needs its force: 1 N for 1 N m would be a lead of 6.28 m."""
        from leadscrew.logs.units import drive_in, length_in

        with suppress(ValueRefused):
            pair = length_in(self.position_unit)[0], drive_in(self.drive_unit)[0]
            if self.model != "linear" and pair == ("m", "N m") and self.parameters.get("force_per_drive", 1.0) == 1.0:
                raise ValueError(
                    f"drive_unit = {self.drive_unit!r} with position_unit = {self.position_unit!r}: "
                    "set.force_per_drive must be the N of 1 N m, 2 pi times the gear over the lead in m"
                )
        return self
