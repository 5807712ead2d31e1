"""Values as JSON can hold them: what is not finite becomes null, arrays become lists."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any


def plain(value: Any) -> Any:
    """The value in dicts, lists, text, numbers, true, false and None; a number that is not finite becomes None."""
    if value is None or isinstance(value, bool | str):
        return value
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    if isinstance(value, bool | int | str):
        return value
    if isinstance(value, Mapping):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [plain(v) for v in value]
    return str(value)


def text_of(message: Mapping[str, Any]) -> str:
    """The message as JSON that every browser reads."""
    return json.dumps(plain(message), allow_nan=False, separators=(",", ":"))


__all__ = ["plain", "text_of"]
