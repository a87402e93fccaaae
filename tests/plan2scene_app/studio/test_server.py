import io
import json
import socket
import zipfile
from importlib.util import find_spec
from urllib.parse import quote

import pytest
from PIL import Image
from places import PLAN

from plan2scene.plans.formats import read_plan
from plan2scene.plans.scene_writer import write_scene_json
from plan2scene_app.studio import app, server


@pytest.fixture(scope="module")
def home(studio):
    status, found = studio.ask("POST", "projects", {"name": "home"})
    assert (status, found) == (200, {"name": "home"})
    return "p/home"


def test_nobody_without_the_token_the_host_and_the_origin(studio, home):
    assert studio.ask("GET", f"{home}/state")[0] == 200
    here = f"127.0.0.1:{studio.port}"
    assert studio.ask("GET", f"{home}/state", Origin=f"http://{here}")[0] == 200
    assert studio.ask("GET", f"{home}/state", token="another")[0] == 403
    assert studio.ask("GET", "", token="")[0] == 403
    assert studio.ask("GET", f"{home}/state", Host="evil.example")[0] == 403
    assert studio.ask("GET", f"{home}/state", Host=f"evil.example:{studio.port}")[0] == 403
    for origin in ("http://evil.example", "null", f"http://evil.example@{here}.evil"):
        assert studio.ask("POST", f"{home}/run", {}, Origin=origin)[0] == 403


def test_pages_load_nothing_from_outside(studio, home):
    for path in ("", f"{home}/"):
        status, page = studio.ask("GET", path)
        assert status == 200
        policy = studio.headers["content-security-policy"]
        assert "default-src 'none'" in policy and "unsafe" not in policy
        assert b"http://" not in page.replace(b"http://www.w3.org/2000/svg", b"")
        assert studio.headers["referrer-policy"] == "no-referrer"


def test_no_path_leads_outside(studio, home):
    (studio.root.parent / "secret.txt").write_text("secret")
    results = "../../../secret.txt ..%2f..%2f..%2fsecret.txt textures/..%2f..%2fplan.json"
    inside = [f"results/{path}" for path in (*results.split(), "work/config.yaml")]
    inside += [f"photos/{path}" for path in ("..%2fplan.json", "%2e%2e%2fstudio.json")]
    for path in (*(f"{home}/{path}" for path in inside), "p/..%2f/state", "p/%2e%2e/state"):
        status, content = studio.ask("GET", path)
        assert status in (400, 404), path
        assert b"secret" not in (content if isinstance(content, bytes) else b"")


def test_uploads_have_limits(studio, home, monkeypatch):
    monkeypatch.setattr(app, "MAX_PHOTO", 1000)
    assert studio.ask("PUT", f"{home}/photos/a.jpg", b"x" * 1001)[0] == 413
    assert studio.ask("PUT", f"{home}/photos/a.jpg", iter([b"x" * 600] * 3))[0] == 413
    status, found = studio.ask("PUT", f"{home}/photos/a.jpg", b"x" * 500)
    assert status == 400 and "expected" in found["error"]
    assert studio.ask("PUT", f"{home}/state", b"[1]")[0] == 400
    assert studio.ask("PUT", f"{home}/state", b"{" * 100_000)[0] == 400
    assert studio.ask("PUT", f"{home}/state", b'{"plan": {"name": "\\ud800"}}')[0] == 400


@pytest.mark.parametrize(
    "sent",
    [b"", b"GET / HTTP/1.1\r\nHost:", b"PUT / HTTP/1.1\r\nHost: x\r\nContent-Length: 99\r\n\r\n{"],
)
def test_half_sent_requests_end(studio, monkeypatch, sent):
    monkeypatch.setattr(server, "PATIENCE", 0.3)
    with socket.create_connection(("127.0.0.1", studio.port), timeout=5) as connection:
        connection.sendall(sent)
        while connection.recv(1000):
            pass


def test_the_token_is_in_a_file_of_this_user_alone(tmp_path):
    address = "http://127.0.0.1:1/token/"
    with server.redirect_file(tmp_path / "homes", address) as file:
        assert address in file.read_text() and file.stat().st_mode & 0o777 == 0o600
    assert not file.exists()


def test_plans_of_other_formats_and_pictures_are_read(studio, home):
    status, found = studio.ask("POST", f"{home}/plan", PLAN.read_bytes())
    assert status == 200 and found["plan"]["rooms"][0]["id"] == "living"
    picture = io.BytesIO()
    Image.new("RGB", (80, 60), "white").save(picture, "PNG")
    status, found = studio.ask("POST", f"{home}/plan", picture.getvalue())
    assert (found["picture"]["width"], found["picture"]["height"]) == (80, 60)
    assert studio.ask("GET", f"{home}/picture")[1][:4] == b"\x89PNG"
    status, found = studio.ask("POST", f"{home}/plan", b"no plan at all")
    assert status == 400 and found["error"].startswith("expected a plan (")


@pytest.mark.parametrize(
    ("parts", "error"),
    [
        ('[["a.png", 9], ["b.png", 9]]', "expected pictures of 18 bytes in all, found 17"),
        ('[["a.png", 8], ["b.png", 9]]', "file a.png: expected an image"),
        ('[["a.png", -8], ["b.png", 25]]', "expected names and sizes of at most 6 pictures"),
        ('{"a.png": 17}', "expected names and sizes of at most 6 pictures"),
    ],
)
def test_pictures_of_storeys_are_refused_in_one_line(studio, home, parts, error):
    status, found = studio.ask("POST", f"{home}/plan?parts={quote(parts)}", b"no picture at all")
    assert status == 400 and error in found["error"]


def test_results_are_given_and_zipped(studio, home):
    assert studio.ask("GET", f"{home}/zip")[0] == 400
    assert studio.ask("GET", f"{home}/export/map")[0] == 400
    house = studio.root / "home" / "house"
    (house / "textures").mkdir(parents=True)
    write_scene_json(read_plan(PLAN, "home"), house / "house.scene.json")
    document = {"method": "none", "surfaces": {}}
    (house / "textures" / "textures.json").write_text(json.dumps(document))
    status, content = studio.ask("GET", f"{home}/export/map")
    assert status == 200, content
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        assert set(archive.namelist()) == {"home/map.pgm", "home/map.yaml"}
    if find_spec("pxr"):
        status, content = studio.ask("GET", f"{home}/export/usd")
        assert status == 200, content
        assert 'filename="home.usdz"' in studio.headers["content-disposition"]
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            assert archive.namelist()[0].endswith(".usdc")
    assert studio.ask("GET", f"{home}/export/..%2fplan")[0] in (400, 404)
    (house / "house.scene.json").unlink()
    (house / "house.glb").write_bytes(b"glTF")
    (house / "viewer.html").write_text("<p>house</p>")
    (house / "textures" / "hall_floor.png").write_bytes(b"png")
    assert studio.ask("GET", f"{home}/results/house.glb") == (200, b"glTF")
    studio.ask("GET", f"{home}/results/viewer.html")
    policy = studio.headers["content-security-policy"]
    assert policy.startswith("sandbox allow-scripts allow-downloads;")
    _, content = studio.ask("GET", f"{home}/zip")
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        assert set(archive.namelist()) == {
            "home/house.glb",
            "home/viewer.html",
            "home/textures/hall_floor.png",
        }
    found = studio.ask("GET", f"{home}/run")[1]
    assert found["state"] == "none" and found["results"]["tiles"] == ["hall_floor.png"]
