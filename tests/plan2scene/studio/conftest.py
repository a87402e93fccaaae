"""A running studio, asked as a browser asks it."""

import contextlib
import http.client
import json
import socket
import threading
from pathlib import Path

import pytest
from browser import Drawing, chromium

TOKEN = "a-token-of-the-tests"


class Studio:
    """A server in a thread and the folder of its homes."""

    def __init__(self, root: Path):
        import uvicorn

        from plan2scene.studio.app import studio_app

        self.root = root
        listener = socket.create_server(("127.0.0.1", 0))
        self.port = listener.getsockname()[1]
        app = studio_app(root, TOKEN, self.port, cores=1)
        self.server = uvicorn.Server(uvicorn.Config(app, log_level="warning", ws="none"))
        self.thread = threading.Thread(target=self.server.run, args=([listener],), daemon=True)
        self.thread.start()
        self.url = f"http://127.0.0.1:{self.port}/{TOKEN}/"

    def stop(self):
        self.server.should_exit = True
        self.thread.join(timeout=20)

    def ask(self, method, path, body=None, *, token=TOKEN, **headers):
        """Return the status and the body of an answer (parsed where it is JSON)."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=90)
        sent = json.dumps(body).encode() if isinstance(body, dict) else body
        named = {name.replace("_", "-"): value for name, value in headers.items()}
        connection.request(method, f"/{token}/{path}", body=sent, headers=named)
        answer = connection.getresponse()
        content = answer.read()
        self.headers = dict(answer.getheaders())
        connection.close()
        kind = answer.getheader("content-type") or ""
        return answer.status, json.loads(content) if "json" in kind else content


@pytest.fixture(scope="module")
def studio(tmp_path_factory):
    pytest.importorskip("uvicorn")
    pytest.importorskip("starlette")
    found = Studio(tmp_path_factory.mktemp("homes"))
    yield found
    found.stop()


@pytest.fixture(scope="module")
def context():
    """Yield a browser's context, its window 1280x800."""
    with chromium() as browser:
        yield browser.new_context(viewport={"width": 1280, "height": 800})


@pytest.fixture
def open_home(context, studio):
    """Yield a context manager: a new home of that name opened; a program's fault fails the test."""

    @contextlib.contextmanager
    def opened(name):
        page = context.new_page()
        page.goto(studio.url)
        page.fill("#new input", name)
        page.click("#new button")
        page.wait_for_url("**/p/*/")
        drawing = Drawing(page)
        page.wait_for_selector("body[data-ready]")
        yield drawing
        page.close()
        assert drawing.faults == []

    return opened
