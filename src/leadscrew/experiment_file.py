"""The schema of an experiment file; imported only when one is read, because pydantic is heavy."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from leadscrew import legacy, toml_file
from leadscrew.kernel.engines import without_numba
from leadscrew.kernel.parameters import nearest
from leadscrew.util.errors import DataError

Engine = Annotated[Literal["llvm", "c", "python"], BeforeValidator(without_numba)]


class ExperimentFile(BaseModel):
    """The keys of the file."""

    model_config = ConfigDict(extra="forbid", strict=True)

    schema_version: Literal[1, 2]
    study: Annotated[str, Field(min_length=1)]
    controller: str | None = None
    scenario: str | None = None
    duration: Annotated[float, Field(gt=0, allow_inf_nan=False)] | None = None
    engine: Engine | None = None
    every: Annotated[int, Field(ge=1)] = 1
    substeps: Annotated[int, Field(ge=1)] | None = None
    record: list[str] | None = None
    seed: Annotated[int, Field(ge=0)] | None = None
    replicate: Annotated[int, Field(ge=0, lt=2**31)] = 0
    files: dict[str, str] = {}
    changes: Annotated[dict[str, Any], Field(alias="set")] = {}


def validated(table: Mapping[str, Any], where: str) -> dict[str, Any]:
    """The fields of the experiment that a TOML table describes.

    Raises:
        DataError: names file and key of what is wrong.
    """
    table = dict(table)
    if "replicate" not in table and "run" in table:  # its name in 0.1.0
        table["replicate"] = table.pop("run")
    try:
        file = ExperimentFile.model_validate(table)
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(map(str, first["loc"]))
        if first["type"] == "extra_forbidden":
            known = [f.alias or n for n, f in ExperimentFile.model_fields.items()]
            raise DataError(f"{where}: there is no key {key!r}{nearest(key, known)}") from None
        if first["type"] == "missing":
            raise DataError(f"{where}: the key {key!r} is missing") from None
        raise DataError(f"{where}: {key} = {first['input']!r}: {first['msg']}") from None
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
