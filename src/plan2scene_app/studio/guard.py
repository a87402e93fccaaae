"""Who may ask: this machine, with the token of the address, from the studio's own pages."""

from __future__ import annotations

import secrets
from urllib.parse import urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import Request
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

#: Names by which a browser on this machine may call the server.
HOSTS = ("127.0.0.1", "localhost")


class Guard:
    """Refuses what has another host, origin or token, and adds headers to what goes out.

    A page of another site can neither guess the token nor be let in by its name resolving to this
    machine (the host is checked), and what it sends has its own origin.
    """

    def __init__(self, app: ASGIApp, token: str, port: int) -> None:
        self.app = app
        self.token = token
        self.hosts = {f"{host}:{port}" for host in HOSTS}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass an HTTP request on, or answer it with 403."""
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
            return
        if scope["type"] != "http":
            return
        if not self._may(scope):
            refused = PlainTextResponse("Open the address that plan2scene studio printed.\n", 403)
            await refused(scope, receive, send)
            return

        async def with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                headers.setdefault("Cache-Control", "no-store")
                headers["Referrer-Policy"] = "no-referrer"
                headers["X-Content-Type-Options"] = "nosniff"
                headers["Cross-Origin-Resource-Policy"] = "same-origin"
                headers.setdefault(
                    "Content-Security-Policy", "default-src 'none'; frame-ancestors 'self'"
                )
            await send(message)

        await self.app(scope, receive, with_headers)

    def _may(self, scope: Scope) -> bool:
        headers = Headers(scope=scope)
        if headers.get("host", "") not in self.hosts:
            return False
        origin = headers.get("origin")
        if origin is not None and urlsplit(origin).netloc not in self.hosts:
            return False
        first = scope["path"].split("/")[1] if scope["path"].startswith("/") else ""
        return secrets.compare_digest(first.encode(), self.token.encode())


class TooLarge(Exception):  # noqa: N818 - an answer
    """A request has more bytes than it may."""


async def body(request: Request, most: int) -> bytes:
    """Return a request's body; TooLarge as soon as it has more than `most` bytes."""
    if int(request.headers.get("content-length") or 0) > most:
        raise TooLarge
    parts, size = [], 0
    async for part in request.stream():
        size += len(part)
        if size > most:
            raise TooLarge
        parts.append(part)
    return b"".join(parts)
