"""Attaching to a HAL and leaving it: from the file to the process that does it."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from typing import Any

from leadscrew.panel.hal import plan
from leadscrew.panel.hal.file import HalFile
from leadscrew.panel.hal.pipe import Pipe
from leadscrew.panel.hal.show import HalRefused, running

LEFT = (
    "what a panel that was killed had left in HAL was taken away; parameters that it wrote stand as they were, and "
    "count as safe unless the file says otherwise"
)


class Attachment:
    """The values of the parameters, and the pipe that samples come from."""

    def __init__(self, file: HalFile) -> None:
        self.file = file
        self.pipe: Pipe | None = None
        self.values: dict[str, Any] = {}
        self.safe: dict[str, Any] = {}
        self.written: set[str] = set()
        """Keys that this panel has written: only these return to their safe values."""
        self._ramping: set[str] = set()

    def attach(self) -> list[str]:
        """Attaches to the HAL that runs here; gives what has to be said.

        Raises:
            HalRefused: no HAL runs, a fault in the file, or a parameter out of its bounds now; HAL is as before.
        """
        said: list[str] = []
        hal = running()
        other = hal.helpers()
        if other:
            raise HalRefused(f"another panel is attached to this HAL (process {other[0].pid}): end it first")
        left = plan.left_over(hal)
        wanted = plan.plan(self.file, hal) if left is None else None
        pipe = Pipe()
        try:
            if left is not None:
                pipe.ask("clean", plan=left)
                said.append(LEFT)
                wanted = plan.plan(self.file, running())
            parameters = {
                p.key: {"hal": p.hal, "type": p.type, "low": p.low, "high": p.high, "rate": p.rate,
                        "safe": int(p.safe) if p.type == "int" and p.safe is not None else p.safe}
                for p in self.file.parameters
            }  # fmt: skip
            try:
                found = pipe.ask("attach", plan=wanted, parameters=parameters)
            except HalRefused as error:
                raise HalRefused(f"{self.file.where}: {error}") from None
            self.values, self.safe = found["values"], found["safe"]
        except BaseException:
            pipe.close()
            raise
        self.pipe = pipe
        return said

    def write(self, new: Mapping[str, Any]) -> dict[str, Any]:
        """Writes checked values and gives the old ones.

        Raises:
            HalRefused: HAL did not take one of them, or the process has ended.
        """
        if self.pipe is None:
            raise HalRefused("the panel is not attached to HAL yet")
        found = self.pipe.ask("set", values=dict(new))
        self.pipe.events = [e for e in self.pipe.events if e["event"] != "values"]
        self.values.update(new)
        self.written |= set(new)
        self._ramping = (self._ramping - set(new)) | set(found["ramps"])
        return dict(found["old"])

    def heard(self) -> list[str]:
        """What the process has told, as sentences; values that somebody else has changed are taken over."""
        if self.pipe is None:
            return []
        events, self.pipe.events = self.pipe.events, []
        said = []
        for event in events:
            if event["event"] == "reached":
                self._ramping.discard(event["key"])
            elif event["event"] == "warning":
                said.append(event["text"])
            elif event["event"] == "values" and "values" in event:
                said += self._read_back(event["values"])
        return said

    def _read_back(self, values: Mapping[str, Any]) -> list[str]:
        said = []
        for key, value in values.items():
            if key not in self._ramping and value != self.values[key]:
                said.append(f"{key} was changed from {self.values[key]:g} to {value:g}, and not by this panel")
                self.values[key] = value
        return said

    def leave(self) -> dict[str, Any]:
        """The safe values, and HAL as it was; gives the parameters that returned. A second call does nothing."""
        pipe, self.pipe = self.pipe, None
        if pipe is None:
            return {}
        found: dict[str, Any] = {}
        with contextlib.suppress(HalRefused):
            found = pipe.ask("leave", wait_s=20.0).get("back", {})
        pipe.close()
        return found
