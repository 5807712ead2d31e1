"""Files checked by pydantic: the first fault as one sentence with file, key and value.

Imported only when a file is read, because pydantic is heavy.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, TypeVar, get_args

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from leadscrew.kernel.parameters import nearest
from leadscrew.util.errors import DataError, ValueRefused
from leadscrew.util.escape import checked_line


class Table(BaseModel):
    """A table of a file: no key beyond those of its fields, no value of another type."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


Model = TypeVar("Model", bound=BaseModel)
Finite = Annotated[float, Field(allow_inf_nan=False)]
Name = Annotated[str, Field(min_length=1)]


def _ordered(pair: Any) -> tuple[float, float]:
    good = isinstance(pair, list) and len(pair) == 2 and all(type(x) in (int, float) for x in pair)
    if not good or not -math.inf < pair[0] <= pair[1] < math.inf:
        raise ValueError("expected two finite numbers, the lower first")
    return float(pair[0]), float(pair[1])


Pair = Annotated[tuple[float, float], BeforeValidator(_ordered)]
"""Two numbers, the lower first."""


def one_line(longest: int) -> AfterValidator:
    """A text of one line without control characters, of up to ``longest`` characters."""

    def check(value: str) -> str:
        try:
            return checked_line("text", value, longest)
        except ValueRefused as error:
            raise ValueError(str(error).split(": ", 1)[1]) from None

    return AfterValidator(check)


def validated(model: type[Model], table: Mapping[str, Any], where: str | Path) -> Model:
    """The table as an object of the model.

    Raises:
        DataError: the first fault, with file, key and value.
    """
    try:
        return model.model_validate(table)
    except ValidationError as error:
        raise DataError(f"{where}: {_sentence(model, error)}") from None


def _sentence(model: type[BaseModel], error: ValidationError) -> str:
    faults = error.errors()
    first = next((f for f in faults if f["type"] == "extra_forbidden"), faults[0])  # a typo is missing as well
    key = ".".join(str(part + 1) if isinstance(part, int) else part for part in first["loc"])
    if first["type"] == "extra_forbidden":
        *path, last = first["loc"]
        return f"there is no key {key!r}{nearest(str(last), _keys(_at(model, path)))}"
    if first["type"] == "missing":
        return f"the key {key!r} is missing"
    fault = first["msg"].removeprefix("Value error, ")
    if not key:
        return fault
    whole = first["type"] == "value_error" and isinstance(first["input"], dict)
    return f"{key}: {fault}" if whole else f"{key} = {first['input']!r}: {fault}"


def _keys(model: type[BaseModel]) -> list[str]:
    return [field.alias or name for name, field in model.model_fields.items()]


def _at(model: type[BaseModel], path: list[int | str]) -> type[BaseModel]:
    """The model of the table at a path."""
    for part in path:
        if isinstance(part, str):
            inner = next(f.annotation for n, f in model.model_fields.items() if part in (n, f.alias))
            model = next(m for m in (inner, *get_args(inner)) if isinstance(m, type) and issubclass(m, BaseModel))
    return model
