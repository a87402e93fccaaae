"""Start the studio's server on this machine."""

from __future__ import annotations

import asyncio
import os
import secrets
import socket
import tempfile
import webbrowser
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plan2scene.errors import InputError
from plan2scene.plugins import installed

if TYPE_CHECKING:
    import uvicorn
    from starlette.types import ASGIApp


#: Longest time in seconds without new data in the middle of a request.
PATIENCE = 20.0


def serve(folder: Path, *, port: int, cores: int, browser: bool) -> None:
    """Serve the projects of a folder at 127.0.0.1 until Ctrl+C; print the address.

    InputError if the extra ``studio`` is not installed or the port is taken.
    """
    with installed("plan2scene[studio]"):
        from plan2scene_app.studio.app import studio_app
    if folder.exists() and not folder.is_dir():
        raise InputError("a folder for the projects", "a file", file=folder)
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind(("127.0.0.1", port))
    except OSError as error:
        raise InputError(f"a free port, not {port}", error.strerror or "an error") from None
    port = listener.getsockname()[1]
    token = secrets.token_urlsafe(24)
    address = f"http://127.0.0.1:{port}/{token}/"
    print(f"The studio is at {address} (Ctrl+C ends it; runs go on)", flush=True)  # noqa: T201
    with redirect_file(folder, address) as file:
        if browser:
            webbrowser.open(file.as_uri())
        http_server(studio_app(folder, token, port, cores)).run(sockets=[listener])


@contextmanager
def redirect_file(folder: Path, address: str) -> Iterator[Path]:
    """Yield an HTML file, readable by this user only, that redirects a browser to the address.

    The address contains the token, and every user of the machine can see a browser's command line:
    so only this file's name is passed to the browser. The file lies in the projects' folder because
    a browser in a sandbox cannot read the temporary folder.
    """
    folder.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(".html", "studio_", folder.resolve())
    with os.fdopen(handle, "w", encoding="utf-8") as file:
        file.write(f'<meta http-equiv="refresh" content="0; url={address}">\n')
    try:
        yield Path(name)
    finally:
        Path(name).unlink(missing_ok=True)


def http_server(app: ASGIApp) -> uvicorn.Server:
    """Return a uvicorn server that closes connections with half-sent requests after `PATIENCE`."""
    import uvicorn

    config = uvicorn.Config(
        app,
        log_level="warning",
        access_log=False,
        server_header=False,
        h11_max_incomplete_event_size=64_000,
        http=_patient_protocol(),
        ws="none",
    )
    return uvicorn.Server(config)


def _patient_protocol() -> type[asyncio.Protocol]:
    """Return uvicorn's HTTP protocol, changed to close connections with half-sent requests."""
    import h11
    from uvicorn.protocols.http.h11_impl import H11Protocol

    class Patient(H11Protocol):
        waiting: asyncio.TimerHandle | None = None

        def connection_made(self, transport: Any) -> None:
            super().connection_made(transport)
            self._wait()

        def data_received(self, data: bytes) -> None:
            super().data_received(data)
            if self.conn.their_state in (h11.DONE, h11.MUST_CLOSE, h11.CLOSED):
                self._stop()
            elif self.waiting is None or self.conn.their_state is h11.SEND_BODY:
                self._wait()  # a long body is fine as long as data keeps arriving

        def connection_lost(self, exc: Exception | None) -> None:
            self._stop()
            super().connection_lost(exc)

        def _stop(self) -> None:
            if self.waiting is not None:
                self.waiting.cancel()
            self.waiting = None

        def _wait(self) -> None:
            self._stop()
            self.waiting = self.loop.call_later(PATIENCE, self.transport.close)

    return Patient
