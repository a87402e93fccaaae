import contextlib
import socket
import threading

import pytest
from browser import Drawing, chromium
from studio_client import TOKEN, StudioClient

from plan2scene_app.studio.projects import Projects


class Studio(StudioClient):
    def __init__(self, root):
        from plan2scene_app.studio.app import studio_app
        from plan2scene_app.studio.server import http_server

        self.root = root
        listener = socket.create_server(("127.0.0.1", 0))
        self.port = listener.getsockname()[1]
        self.server = http_server(studio_app(root, TOKEN, self.port, cores=1))
        self.thread = threading.Thread(target=self.server.run, args=([listener],), daemon=True)
        self.thread.start()
        self.url = f"http://127.0.0.1:{self.port}/{TOKEN}/"

    def stop(self):
        self.server.should_exit = True
        self.thread.join(timeout=20)

    def home_of(self, page):
        return self.root / page.url.split("#")[0].rstrip("/").split("/")[-1]

    def new_home(self, page, name):
        page.goto(self.url)
        page.fill("#new input", name)
        page.click("#new button")
        page.wait_for_url("**/p/*/")  # of the name what a folder may be called


@pytest.fixture(scope="module")
def studio(tmp_path_factory):
    pytest.importorskip("uvicorn")
    pytest.importorskip("starlette")
    found = Studio(tmp_path_factory.mktemp("homes"))
    yield found
    found.stop()


@pytest.fixture
def project(tmp_path):
    return Projects(tmp_path).make("home")


@pytest.fixture(scope="module")
def context():
    with chromium() as browser:
        yield browser.new_context(viewport={"width": 1280, "height": 800})


@pytest.fixture
def open_home(context, studio):
    """Yield a context manager: a new home of that name opened; a program's fault fails the test."""

    @contextlib.contextmanager
    def opened(name):
        page = context.new_page()
        studio.new_home(page, name)
        drawing = Drawing(page)
        page.wait_for_selector("body[data-ready]")
        yield drawing
        page.close()
        assert drawing.faults == []

    return opened
