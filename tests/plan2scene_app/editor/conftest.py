import pytest
from browser import Drawing, chromium

from plan2scene_app.editor.editor_page import write_editor


@pytest.fixture(scope="module")
def browser():
    with chromium() as found:
        yield found


@pytest.fixture(scope="module")
def empty_page(tmp_path_factory):
    path = tmp_path_factory.mktemp("editor") / "editor.html"
    write_editor(None, path, house_id="home")
    return path


@pytest.fixture
def drawing(browser, empty_page):
    context = browser.new_context(viewport={"width": 1280, "height": 800}, accept_downloads=True)
    found = Drawing(context.new_page())
    found.page.goto(empty_page.as_uri())
    yield found
    context.close()
    assert found.faults == []
