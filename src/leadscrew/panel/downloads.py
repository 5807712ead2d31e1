"""Files over HTTP: the session as a script, a session file or a report, and captures both ways."""

from __future__ import annotations

import asyncio
import contextlib
import os
import re
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from starlette.requests import ClientDisconnect, Request
from starlette.responses import FileResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import Route

from leadscrew.panel.link import NoAnswer
from leadscrew.panel.strict_json import plain
from leadscrew.util.system import safe_path

if TYPE_CHECKING:
    from leadscrew.panel.hub import Hub

SUFFIXES = ("parquet", "csv", "mat", "pq", "txt", "tsv", "log", "dat")
"""As :data:`leadscrew.operate.captures.READ`."""
_CAPTURE = re.compile(r"[A-Za-z0-9][A-Za-z0-9 _.-]{0,63}\.(?:" + "|".join(SUFFIXES) + r")\Z")


def is_capture_name(name: str) -> bool:
    """Whether a file of captures may be called so."""
    return _CAPTURE.match(name) is not None and ".." not in name


def capture_file(folder: Path, name: str) -> Path | None:
    """The file of that name, no link and nothing outside of the folder; None where there is none."""
    path = folder / name
    return path if is_capture_name(name) and path.is_file() and not path.is_symlink() else None


MOST_BYTES = 50_000_000
REPORT_S = 300.0
RECEIVE_S = 60.0
"""How long a capture may be on its way; others wait for it."""
SECRET = "leadscrew-secret"
"""Header of an upload: the secret of the page that sends it, which has to have control."""


class Downloads:
    """The routes below ``/api``; the guard has seen to who asks."""

    def __init__(self, hub: Hub, folder: Path) -> None:
        self.hub, self.folder = hub, folder
        self._reporting = asyncio.Lock()
        self._uploading = asyncio.Lock()

    def routes(self) -> list[Route]:
        """For the application."""
        return [
            Route("/api/session.py", self.session),
            Route("/api/session.toml", self.session),
            Route("/api/report.html", self.report),
            Route("/api/captures/{name}", self.capture, methods=["GET"]),
            Route("/api/captures/{name}", self.upload, methods=["POST"]),
        ]

    async def session(self, request: Request) -> Response:
        """The session as a script or a file."""
        suffix = request.url.path.rsplit(".", 1)[-1]
        try:
            found = await self.hub.link.ask("session", {"format": suffix})
        except NoAnswer as error:
            return _refused(409, str(error))
        self.hub.note_http(request, "download", key=f"session.{suffix}")
        return _file(found["text"], f"session.{suffix}", "text/plain; charset=utf-8")

    async def report(self, request: Request) -> Response:
        """The report, made by a process of its own so that nothing here waits."""
        if self._reporting.locked():
            return _refused(409, "a report is being made already; a moment")
        async with self._reporting:
            try:
                found = await self.hub.link.ask("session", {"format": "toml"})
                html = await _reported(found["text"])
            except NoAnswer as error:
                return _refused(409, str(error))
        self.hub.note_http(request, "download", key="report.html")
        return _file(html, "report.html", "text/html; charset=utf-8")

    async def capture(self, request: Request) -> Response:
        """A capture's file."""
        from leadscrew.panel.downloads import capture_file

        path = capture_file(self.folder / "captures", request.path_params["name"])
        if path is None:
            return _refused(404, "there is no capture of that name")
        return FileResponse(path, filename=path.name, media_type="application/octet-stream")

    async def upload(self, request: Request) -> Response:
        """A capture that a page sends, to be loaded: kept where it can be read, and said no to where not."""
        from leadscrew.panel.downloads import is_capture_name

        name = request.path_params["name"]
        if not is_capture_name(name):
            return self._no(
                request,
                400,
                f"{name[:80]!r} is no name of a capture: letters, digits, blanks and _ . -, with its suffix",
            )
        if why := self.hub.no_control(self.hub.control.is_of(request.headers.get(SECRET, ""))):
            return self._no(request, 403, f"capture_receive: {why}")
        if self._uploading.locked():
            return self._no(request, 409, "another capture is on its way already; a moment")
        async with self._uploading:
            try:
                async with asyncio.timeout(RECEIVE_S):
                    path = await self._received(request)
            except TimeoutError:
                return self._no(request, 408, f"the capture was not here after {RECEIVE_S:g} s")
            if path is None:
                return self._no(request, 413, f"captures up to {MOST_BYTES / 1e6:.0f} MB are taken")
            try:
                found = await self.hub.link.ask("capture_receive", {"name": name, "path": str(path)})
            except NoAnswer as error:
                return self._no(request, 400, str(error))
            finally:
                path.unlink(missing_ok=True)
        self.hub.note_http(request, "capture_receive", key=name)
        return JSONResponse(plain(found))

    async def _received(self, request: Request) -> Path | None:
        """The body in a file of its own; None where it is too large or breaks off."""
        length = request.headers.get("content-length", "0")
        if not length.isdecimal() or int(length) > MOST_BYTES:
            return None
        self.folder.mkdir(parents=True, exist_ok=True)
        handle, place = tempfile.mkstemp(prefix=".upload-", dir=self.folder)
        size = 0
        try:
            with os.fdopen(handle, "wb") as out:
                async for piece in request.stream():
                    size += len(piece)
                    if size > MOST_BYTES:
                        raise ValueError
                    out.write(piece)
        except (ValueError, ClientDisconnect, OSError):
            Path(place).unlink(missing_ok=True)
            return None
        except asyncio.CancelledError:
            Path(place).unlink(missing_ok=True)
            raise
        return Path(place)

    def _no(self, request: Request, status: int, text: str) -> Response:
        self.hub.note_http(request, "capture_receive", error=text)
        return _refused(status, text)


async def _reported(session: str) -> str:
    """The report of a session, by ``leadscrew.panel.reporting`` in another process."""
    process = await asyncio.create_subprocess_exec(
        sys.executable, *safe_path(), "-m", "leadscrew.panel.reporting",
        stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.PIPE,
    )  # fmt: skip
    try:
        out, problem = await asyncio.wait_for(process.communicate(session.encode()), REPORT_S)
    except TimeoutError:
        raise NoAnswer(f"the report was not ready within {REPORT_S:g} s; export the script and run it") from None
    finally:
        if process.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                process.kill()
    if process.returncode:
        last = problem.decode("utf-8", "replace").strip().splitlines()[-1:]
        raise NoAnswer(f"the report could not be made: {' '.join(last)}")
    return out.decode()


def _file(text: str, name: str, kind: str) -> Response:
    return Response(text, media_type=kind, headers={"content-disposition": f'attachment; filename="{name}"'})


def _refused(status: int, text: str) -> Response:
    return PlainTextResponse(text, status_code=status)
