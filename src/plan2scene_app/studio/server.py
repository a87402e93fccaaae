"""Starts the studio on this machine."""

from __future__ import annotations

import secrets
import socket
import webbrowser
from pathlib import Path

from plan2scene.errors import InputError
from plan2scene.plugins import installed


def serve(folder: Path, *, port: int, cores: int, browser: bool) -> None:
    """Serve the projects of a folder at 127.0.0.1 until Ctrl+C; the address is printed.

    InputError where the extra ``studio`` is not installed, or the port is taken.
    """
    with installed("plan2scene[studio]"):
        import uvicorn

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
    if browser:
        webbrowser.open(address)
    config = uvicorn.Config(
        studio_app(folder, token, port, cores),
        log_level="warning",
        access_log=False,
        server_header=False,
        h11_max_incomplete_event_size=64_000,
        ws="none",
    )
    uvicorn.Server(config).run(sockets=[listener])
