"""The keys of experiment and controller files; imported only when one is read, because pydantic is heavy."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from leadscrew import file_schema, legacy, toml_file
from leadscrew.file_schema import Finite, Name, Table
from leadscrew.kernel.engines import without_numba

Engine = Annotated[Literal["llvm", "c", "python"], BeforeValidator(without_numba)]


class ExperimentTable(Table):
    """One loop of a study, with changes."""

    schema_version: Literal[1, 2]
    study: Name
    controller: str | None = None
    scenario: str | None = None
    duration: Annotated[Finite, Field(gt=0)] | None = None
    engine: Engine | None = None
    every: Annotated[int, Field(ge=1)] = 1
    substeps: Annotated[int, Field(ge=1)] | None = None
    record: list[str] | None = None
    seed: Annotated[int, Field(ge=0)] | None = None
    replicate: Annotated[int, Field(ge=0, lt=2**31)] = 0
    files: dict[str, str] = Field(default_factory=dict)
    changes: dict[str, Any] = Field(default_factory=dict, alias="set")


class ControllerTable(Table):
    """A controller of a study with its parameters."""

    schema_version: Literal[1, 2]
    kind: Literal["controller"]
    study: Name
    controller: Name
    changes: dict[str, Any] = Field(default_factory=dict, alias="set")
    tuning: dict[str, Any] = Field(default_factory=dict)


def validated(table: Mapping[str, Any], where: str) -> dict[str, Any]:
    """The fields of the experiment that a TOML table describes.

    Raises:
        DataError: names file and key of what is wrong.
    """
    table = dict(table)
    if "replicate" not in table and "run" in table:  # its name in 0.1.0
        table["replicate"] = table.pop("run")
    file = file_schema.validated(ExperimentTable, table, where)
    return {
        "study": file.study,
        "controller": file.controller,
        "scenario": file.scenario,
        "changes": legacy.completed(
            file.schema_version, file.controller, dict(toml_file.flat(file.changes)), "controller."
        ),
        "duration_s": file.duration,
        "engine": file.engine,
        "every": file.every,
        "substeps": file.substeps,
        "record": None if file.record is None else tuple(file.record),
        "seed": file.seed,
        "replicate": file.replicate,
        "files": file.files,
        "source": where,
    }
