"""The studio's web application: access control, pages and responses below ``/{token}/``."""

from __future__ import annotations

import secrets
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import Request
from starlette.responses import (
    FileResponse,
    HTMLResponse,
    JSONResponse,
    PlainTextResponse,
    Response,
)
from starlette.routing import Mount, Route
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from plan2scene.errors import InputError, system_fault
from plan2scene.plans.parse import parse_json
from plan2scene.textures.methods import texture_methods
from plan2scene_app.editor.editor_page import FOLDER as EDITOR
from plan2scene_app.editor.editor_page import joined_program, page_rules
from plan2scene_app.exports.registry import exports
from plan2scene_app.finishes import LIBRARY
from plan2scene_app.html_page import html_page, inline_json, source_hash
from plan2scene_app.run import HOUSE_COLOURS, HOUSE_WALLS, TEXTURE_SIZES
from plan2scene_app.studio import plan_source, results, runs
from plan2scene_app.studio.plan_source import UnreadPlanError
from plan2scene_app.studio.projects import PICTURE, Conflict, Project, Projects

#: Largest size in bytes of an uploaded photo, an uploaded plan, and the editor's state.
MAX_PHOTO, MAX_PLAN, MAX_STATE = 60_000_000, 200_000_000, 8_000_000
MAX_STOREYS = 6  #: largest number of pictures of one plan

_Answer = Callable[[Request], Awaitable[Response]]
#: Content policy of a viewer's page: it may run its scripts and start downloads, but not connect.
_VIEWER_POLICY = (
    "sandbox allow-scripts allow-downloads; default-src 'none'; "
    "script-src 'unsafe-inline' blob: data:; style-src 'unsafe-inline'; img-src data: blob:; "
    "connect-src data: blob:; worker-src blob:; frame-ancestors 'self'"
)


def studio_app(root: Path, token: str, port: int, cores: int) -> Guard:
    """Return the server's application for the projects of a folder."""
    studio = _Studio(Projects(root), cores)
    project = [
        Route("/", _handled(studio.project), methods=["GET"]),
        Route("/state", _handled(studio.state), methods=["GET"]),
        Route("/state", _handled(studio.save), methods=["PUT"]),
        Route("/plan", _handled(studio.open_plan), methods=["POST"]),
        Route("/plan/reading", _handled(studio.reading), methods=["GET"]),
        Route("/plan/reading", _handled(studio.read_again), methods=["POST"]),
        Route("/picture", _handled(studio.picture), methods=["GET"]),
        Route("/photos/{photo}", _handled(studio.thumb), methods=["GET"]),
        Route("/photos/{photo}", _handled(studio.add_photo), methods=["PUT"]),
        Route("/run", _handled(studio.status), methods=["GET"]),
        Route("/run", _handled(studio.start), methods=["POST"]),
        Route("/run", _handled(studio.cancel), methods=["DELETE"]),
        Route("/results/{file:path}", _handled(studio.result), methods=["GET"]),
        Route("/finishes", _handled(studio.finishes), methods=["GET"]),
        Route("/finishes", _handled(studio.set_finishes), methods=["PUT"]),
        Route("/zip", _handled(studio.zip), methods=["GET"]),
        Route("/export/{form}", _handled(studio.export), methods=["GET"]),
    ]
    routes = [
        Route("/", _handled(studio.home), methods=["GET"]),
        Route("/projects", _handled(studio.make), methods=["POST"]),
        Mount("/p/{project}", routes=project),
    ]
    return Guard(Starlette(routes=[Mount(f"/{token}", routes=routes)]), token, port)


def _handled(answer: _Answer) -> _Answer:
    """Wrap a handler: an error becomes a response with one line of text and a status code."""

    async def handled(request: Request) -> Response:
        try:
            return await answer(request)
        except UnreadPlanError as error:
            return JSONResponse({"error": str(error), "reading": error.reading}, 400)
        except InputError as error:
            return JSONResponse({"error": str(error)}, 400)
        except Conflict:
            return JSONResponse({"error": "changed in another tab or by another program"}, 409)
        except TooLarge as error:
            return JSONResponse({"error": f"expected at most {error}, found more"}, 413)
        except OSError as error:
            fault = system_fault(error)
            if fault is None:
                raise
            return JSONResponse({"error": str(fault)}, 500)

    return handled


class _Studio:
    """The handlers of all requests; long work runs in another thread than the server."""

    def __init__(self, projects: Projects, cores: int) -> None:
        self.projects = projects
        self.cores = cores

    def _of(self, request: Request) -> Project:
        return self.projects.get(request.path_params["project"])

    async def home(self, request: Request) -> Response:
        """Show the list of projects."""
        projects = [
            {
                "name": name,
                "title": self.projects.get(name).title,
                "state": runs.status(self.projects.get(name))["state"],
                "preview": (self.projects.get(name).house / "preview.png").is_file(),
            }
            for name in self.projects.names()
        ]
        return _page(*home_page({"projects": projects, "folder": str(self.projects.root)}))

    async def make(self, request: Request) -> Response:
        """Make a project."""
        name = _object(await body(request, 10_000)).get("name")
        return JSONResponse({"name": self.projects.make(str(name)).name})

    async def project(self, request: Request) -> Response:
        """Show the page of one project: the editor and the house."""
        project = self._of(request)
        start = {"house": project.name, "title": project.title, **project.state()}
        return _page(*project_page(start | {"source": plan_source.is_kept(project)}))

    async def state(self, request: Request) -> Response:
        """Give the editor's state; only the revision if the client already has it (``not=``)."""
        project = self._of(request)
        if request.query_params.get("not") == project.revision():
            return JSONResponse({"revision": project.revision()})
        return JSONResponse(project.state())

    async def save(self, request: Request) -> Response:
        """Store the editor's state."""
        project, state = self._of(request), _object(await body(request, MAX_STATE))
        revision = project.save(state)
        plan_source.keep_two_points(project)
        return JSONResponse({"revision": revision})

    async def open_plan(self, request: Request) -> Response:
        """Read an uploaded plan of any format, a picture of one or of each storey, and store it.

        Of several pictures, the body is one after the other, and the query says their names and
        sizes in bytes: ``parts=[["ground.jpg", 1234], ...]``.
        """
        project, content = self._of(request), await body(request, MAX_PLAN)
        parts = _parts(request.query_params.get("parts") or "[]")
        plan = await run_in_threadpool(plan_source.read_upload, project, content, parts)
        return JSONResponse(plan)

    async def reading(self, request: Request) -> Response:
        """Give the scale and layers with which the uploaded plan is read, and the possible ones."""
        reading = await run_in_threadpool(plan_source.reading_of, self._of(request))
        return JSONResponse(reading)

    async def read_again(self, request: Request) -> Response:
        """Read the uploaded plan again with another scale or other layers."""
        project, values = self._of(request), _object(await body(request, 10_000))
        return JSONResponse(await run_in_threadpool(plan_source.read_again, project, values))

    async def picture(self, request: Request) -> Response:
        """Give the picture that lies under the plan."""
        file = self._of(request).path / PICTURE
        if not file.is_file():
            raise InputError("a picture", "none")
        return FileResponse(file, media_type="image/png")

    async def thumb(self, request: Request) -> Response:
        """Give a photo's thumbnail."""
        path = self._of(request).photo(request.path_params["photo"])
        small = await run_in_threadpool(results.thumbnail, path)
        return Response(small, media_type="image/jpeg")

    async def add_photo(self, request: Request) -> Response:
        """Store an uploaded photo."""
        project, content = self._of(request), await body(request, MAX_PHOTO)
        await run_in_threadpool(project.add_photo, request.path_params["photo"], content)
        return JSONResponse({"name": request.path_params["photo"]})

    async def status(self, request: Request) -> Response:
        """Give the run's progress and the results that exist."""
        project = self._of(request)
        return JSONResponse(
            runs.status(project)
            | {"results": results.results_of(project), "revision": project.revision()}
            | {"finishes": project.finishes_revision()}
        )

    async def finishes(self, request: Request) -> Response:
        """Give the finishes that the owner has set."""
        return JSONResponse({"rows": self._of(request).finishes()})

    async def set_finishes(self, request: Request) -> Response:
        """Store the finishes that the owner sets."""
        project, sent = self._of(request), _object(await body(request, MAX_STATE))
        project.set_finishes(sent.get("rows"))
        return JSONResponse({"rows": project.finishes()})

    async def start(self, request: Request) -> Response:
        """Start a run."""
        project, values = self._of(request), _object(await body(request, 10_000))
        settings = runs.settings_of(values, self.cores)
        await run_in_threadpool(runs.start, project, settings)
        return await self.status(request)

    async def cancel(self, request: Request) -> Response:
        """End a run."""
        await run_in_threadpool(runs.cancel, self._of(request))
        return await self.status(request)

    async def result(self, request: Request) -> Response:
        """Give a file of the results."""
        path = results.result_file(self._of(request), request.path_params["file"])
        if path.suffix == ".html":
            headers = {"Content-Security-Policy": _VIEWER_POLICY}
            return FileResponse(path, media_type="text/html", headers=headers)
        return FileResponse(path)

    async def zip(self, request: Request) -> Response:
        """Give all results in one ZIP archive."""
        project = self._of(request)
        content = await run_in_threadpool(results.zipped, project)
        return _download(f"{project.name}.zip", content)

    async def export(self, request: Request) -> Response:
        """Give the house in a format that other programs read."""
        form = request.path_params["form"]
        file = await run_in_threadpool(results.exported, self._of(request), form)
        return _download(*file)


def _object(content: bytes) -> dict[str, Any]:
    """Parse a request's body as a JSON object."""
    try:
        document = parse_json(content.decode("utf-8"), "the request")
    except UnicodeDecodeError:
        raise InputError("UTF-8 text", "other bytes") from None
    if not isinstance(document, dict):
        raise InputError("a JSON object", "other JSON")
    return document


def _download(name: str, content: bytes) -> Response:
    """Return a response that the browser saves as a file."""
    headers = {"Content-Disposition": f'attachment; filename="{name}"'}
    return Response(content, media_type="application/octet-stream", headers=headers)


def _page(page: str, policy: str) -> Response:
    return HTMLResponse(page, headers={"Content-Security-Policy": policy})


#: Names by which a browser on this machine may call the server.
HOSTS = ("127.0.0.1", "localhost")


class Guard:
    """Refuses requests with a wrong host, origin or token, and adds headers to responses.

    This stops pages of other sites: they cannot guess the token, their requests have their own
    origin, and a host name of theirs that resolves to this machine is refused.
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
    """A request's body is larger than allowed."""


def _parts(text: str) -> list[tuple[str, int]]:
    """Return the names and the sizes in bytes of uploaded pictures of storeys."""
    document = parse_json(text, "the request")
    try:
        parts = [(name, size) for name, size in document]
        if len(parts) <= MAX_STOREYS and all(
            isinstance(name, str) and type(size) is int and 0 < size <= MAX_PLAN
            for name, size in parts
        ):
            return parts
    except (TypeError, ValueError):
        pass
    raise InputError(f"names and sizes of at most {MAX_STOREYS} pictures", repr(document)[:60])


async def body(request: Request, most: int) -> bytes:
    """Return a request's body; TooLarge as soon as it has more than `most` bytes."""
    if int(request.headers.get("content-length") or 0) > most:
        raise TooLarge(f"{most / 1e6:g} MB")
    parts, size = [], 0
    async for part in request.stream():
        size += len(part)
        if size > most:
            raise TooLarge(f"{most / 1e6:g} MB")
        parts.append(part)
    return b"".join(parts)


_FOLDER = Path(__file__).parent


def project_page(start: dict[str, Any]) -> tuple[str, str]:
    """Return the page of a project and its content policy; `start` is the project's state."""
    rules = page_rules() | {
        "settings": {
            name: {"title": title, "values": list(values), "value": runs.DEFAULTS[name]}
            for name, title, values in (
                ("method", "Textures by", texture_methods()),
                ("texture_size", "Pixels of a tile", TEXTURE_SIZES),
                ("colours", "Colours as", HOUSE_COLOURS),
                ("walls", "Walls alike in a", HOUSE_WALLS),
            )
        },
        "max_photo": MAX_PHOTO,
        "library": {name: colour for name, (_, _, colour) in LIBRARY.items()},
        "exports": {form: export.purpose for form, export in exports().items()},
    }
    editor = (EDITOR / "editor.html").read_text("utf-8")
    tools = editor[editor.index("<nav") : editor.index("<script")]
    return _filled("studio.html", "studio_page", str(start["title"]), start, rules, tools)


def home_page(start: dict[str, Any]) -> tuple[str, str]:
    """Return the page of all projects and its content policy; `start` is ``{projects, folder}``."""
    return _filled("home.html", "home_page", "Studio", start, {}, "")


def _filled(
    name: str, entry: str, title: str, start: dict[str, Any], rules: dict[str, Any], tools: str
) -> tuple[str, str]:
    program = joined_program(entry, (_FOLDER, EDITOR))
    style = (EDITOR / "editor.css").read_text("utf-8") + (_FOLDER / "studio.css").read_text("utf-8")
    page = html_page(
        _FOLDER / name,
        title=title,
        style=style,
        tools=tools,
        rules=inline_json(rules),
        start=inline_json(start),
        program=program,
    )
    policy = (
        f"default-src 'none'; script-src {source_hash(program)}; style-src {source_hash(style)}; "
        "img-src 'self' data: blob:; connect-src 'self'; frame-src 'self'; form-action 'none'; "
        "base-uri 'none'; frame-ancestors 'none'"
    )
    return page, policy
