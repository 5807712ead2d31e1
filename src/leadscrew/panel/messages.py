"""What a page may ask: one model a command; a message that fits none is refused before anything sees it."""

from __future__ import annotations

import difflib
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, StringConstraints, ValidationError
from pydantic_core import PydanticCustomError

from leadscrew.panel import strict_json

MOST_BYTES = 65_536
"""Size of a message."""

Name = Annotated[str, StringConstraints(pattern=r"^[A-Za-z0-9][A-Za-z0-9 _.-]{0,63}$")]
File = Annotated[str, StringConstraints(pattern=r"^[A-Za-z0-9][A-Za-z0-9 _.-]{0,71}$")]
Key = Annotated[str, StringConstraints(pattern=r"^[A-Za-z0-9_]+(\.[A-Za-z0-9_]+)*$", max_length=200)]
Pin = Annotated[str, StringConstraints(pattern=r"^[A-Za-z0-9_.\-]{1,200}$")]
Option = Annotated[str, StringConstraints(pattern=r"^[A-Za-z][A-Za-z0-9_-]{0,63}$")]
Text = Annotated[str, StringConstraints(max_length=300)]
Number = Annotated[float, Field(allow_inf_nan=False)]
Row = Annotated[list[Number], Field(max_length=512)]
Value = bool | int | Number | Option | Row | Annotated[list[Row], Field(max_length=128)]
Changes = Annotated[dict[Key | Pin, Value], Field(min_length=1, max_length=256)]


class Message(BaseModel):
    """What all have: a number for the answer, and the command."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)
    id: Annotated[int, Field(ge=0, le=2**53)]
    do: str

    def args(self) -> dict[str, Any]:
        """What belongs to the command itself."""
        return self.model_dump(exclude={"id", "do"})


def _shown(name: str) -> str:
    """A name that reads as it is written."""
    if not name.isprintable():
        raise PydanticCustomError("name", "characters that are not printed are not allowed")
    return name


class Hello(Message):
    name: Annotated[str, StringConstraints(min_length=1, max_length=40, strip_whitespace=True), AfterValidator(_shown)]
    secret: Annotated[str, StringConstraints(min_length=16, max_length=200)] | None = None
    since: Number | None = None


class Speed(Message):
    value: Number


class Machine(Message):
    study: Text
    controller: Text | None = None
    scenario: Text | None = None
    seed: Annotated[int, Field(ge=0, le=2**31 - 1)] | None = None
    circle: bool = False
    changes: Annotated[dict[Key, Value], Field(max_length=256)] | None = None


class Switch(Message):
    controller: Text


class Set(Message):
    changes: Changes


class Compare(Message):
    mode: Literal["previous", "pinned", "off"]


class Disturb(Message):
    name: Name
    fields: Annotated[dict[Name, Number], Field(max_length=32)] | None = None


class Arm(Message):
    signal: Text
    level: Number
    slope: Literal["rising", "falling", "either"] = "rising"
    mode: Literal["single", "normal", "auto"] = "single"
    pre: Annotated[float, Field(ge=0, le=1)] = 0.2
    length_s: Annotated[float, Field(gt=0, le=3600)] = 1.0


class CaptureSave(Message):
    name: Name
    format: Literal["parquet", "csv", "mat"] = "parquet"
    which: Annotated[int, Field(ge=0)] | None = None


class CaptureLoad(Message):
    name: File


class Named(Message):
    name: Name


class Audit(Message):
    last: Annotated[int, Field(ge=1, le=1000)] = 200


class Why(Message):
    views: Annotated[list[Literal["rules", "sets", "phase", "circle"]], Field(max_length=4)]


class Ping(Message):
    t: Number


READERS: dict[str, type[Message]] = {
    "hello": Hello, "take": Message, "audit": Audit, "why": Why, "ping": Ping, "captures": Message,
    "presets": Message,
}  # fmt: skip
"""What every page may ask."""
WRITERS: dict[str, type[Message]] = {
    "release": Message, "start": Message, "hold": Message, "stop": Message, "reset": Message, "speed": Speed,
    "machine": Machine, "switch": Switch, "set": Set, "undo": Message, "redo": Message, "compare": Compare,
    "disturb": Disturb, "arm": Arm, "disarm": Message, "force": Message, "capture_save": CaptureSave,
    "capture_load": CaptureLoad,
    "preset_save": Named, "preset_load": Named, "preset_delete": Named, "session_save": Named,
}  # fmt: skip
"""What only the page that has control may ask."""
ALL = {**READERS, **WRITERS}


class Refused(Exception):
    """A message that is not obeyed: its number where it has one, the command, and why in a sentence."""

    def __init__(self, text: str, id: int | None = None, do: str = "", key: str = "") -> None:
        super().__init__(text)
        self.id, self.do, self.key = id, do, key


def parse(text: str) -> Message:
    """The message as its model.

    Raises:
        Refused: no message that is known; the sentence holds no value of a secret.
    """
    try:
        found = strict_json.loads(text)
    except ValueError as error:
        raise Refused(f"the message is {error}" if str(error).startswith("no ") else f"the message: {error}") from None
    number = found.get("id")
    id = number if type(number) is int and 0 <= number <= 2**53 else None
    do = found.get("do")
    if not isinstance(do, str):
        raise Refused("the message has no command: expected a text under 'do'", id)
    if do not in ALL:
        close = difflib.get_close_matches(do[:40], list(ALL), n=1, cutoff=0.4)
        hint = f"; did you mean {close[0]}?" if close else ""
        raise Refused(f"there is no command {do[:40]!r}{hint}", id, do[:40])
    try:
        return ALL[do].model_validate(found)
    except ValidationError as error:
        raise _refused(error, id, do) from None


def _refused(error: ValidationError, id: int | None, do: str) -> Refused:
    """The first fault in a sentence; what was given is not repeated."""
    first = error.errors(include_url=False, include_input=False, include_context=False)[0]
    path = [str(p)[:80] for p in first["loc"] if p != "[key]"]
    key = next((p for p in path[1:] if "." in p), "") if path[:1] in (["changes"], ["fields"]) else ""
    place = key or ".".join(p for p in path[:2]) or do
    text = first["msg"][:1].lower() + first["msg"][1:]
    if path[:1] == ["changes"] and len(path) > 1:
        text = "expected a number, true or false, an option, or a list of numbers, under the dotted key of a parameter"
    elif first["type"] == "string_pattern_mismatch":
        text = "allowed are letters, digits, blanks and _ . -, a letter or digit first, 64 at most"
    return Refused(f"{do}: {place}: {text}", id, do, key)


__all__ = ["ALL", "MOST_BYTES", "READERS", "WRITERS", "Hello", "Message", "Refused", "parse"]
