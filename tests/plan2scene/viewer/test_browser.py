"""The viewer in a headless browser: textured pixels, controls that work."""

import os
import shutil
import subprocess

import numpy as np
import pytest
from PIL import Image

from plan2scene.floorplans import write_scene_json
from plan2scene.viewer import build_viewer
from plan2scene.viewer.index_page import write_index

BROWSER = next(
    (
        found
        for name in ("chromium", "chromium-browser", "google-chrome")
        if (found := shutil.which(name))
    ),
    None,
)
WIDTH, HEIGHT = 900, 600

pytestmark = pytest.mark.skipif(BROWSER is None, reason="no Chromium on PATH")


def screenshot(page, tmp_path):
    """Return the browser's picture of a file as (h, w, 3) int array."""
    picture = tmp_path / "shot.png"
    command = [
        BROWSER,
        "--headless=new",
        "--no-sandbox",
        "--enable-unsafe-swiftshader",
        "--disable-background-networking",
        "--no-first-run",
        "--hide-scrollbars",
        "--force-device-scale-factor=1",
        f"--window-size={WIDTH},{HEIGHT}",
        f"--user-data-dir={tmp_path / 'profile'}",
        "--virtual-time-budget=6000",
        "--run-all-compositor-stages-before-draw",
        f"--screenshot={picture}",
        page.as_uri(),
    ]
    environment = {**os.environ, "HOME": str(tmp_path)}
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, env=environment)
    assert picture.is_file(), done.stderr[-2000:]
    return np.asarray(Image.open(picture).convert("RGB")).astype(int)


def with_action(page, script):
    """Add a script that runs once the viewer has started."""
    text = page.read_text(encoding="utf-8")
    before = "start().catch"
    assert text.count(before) == 1
    page.write_text(text.replace(before, f"start().then(() => {{ {script} }}).catch"), "utf-8")


def test_textured_pixels(small_glb, tmp_path):
    page = tmp_path / "viewer.html"
    build_viewer(small_glb, page, house_id="small")
    scene = screenshot(page, tmp_path)[:, 290:]  # right of the panel
    red, green, blue = scene[..., 0], scene[..., 1], scene[..., 2]
    is_red = (red > 120) & (green < 80) & (blue < 80)
    is_blue = (blue > 120) & (green < 80) & (red < 80)
    is_green = (green > red + 40) & (green > blue + 40)
    assert is_red.sum() > 2000
    assert is_blue.sum() > 2000
    assert is_green.sum() > 2000
    # Squares of the floor's checks change many times along a row of the picture.
    row = max(range(scene.shape[0]), key=lambda y: (is_red | is_blue)[y].sum())
    changes = np.abs(np.diff(is_red[row].astype(int))).sum()
    assert changes > 8
    assert len(np.unique(scene.reshape(-1, 3), axis=0)) > 100


def test_ceilings_hide_the_floor_and_rooms_are_listed(small_glb, tmp_path):
    page = tmp_path / "viewer.html"
    build_viewer(small_glb, page, house_id="small")
    with_action(
        page,
        'document.getElementById("ceilings").click();'
        'document.getElementById("walk").click();'
        "Object.assign(eye, {pitch: 1.3});"
        'const names = [...document.querySelectorAll("#rooms button")].map((b) => b.textContent);'
        'if (names.join(",") !== "Bedroom12.0 m\\u00b2") document.body.replaceChildren();'
        "refresh();",
    )
    scene = screenshot(page, tmp_path)
    above = scene[200:500, 400:800]
    # Looking up at a ceiling without texture: light, no red or blue floor.
    assert (above.min(axis=2) > 180).mean() > 0.9
    assert not ((above[..., 0] > 120) & (above[..., 1] < 80)).any()
    panel = scene[20:60, 20:250]
    assert (panel.max(axis=2) < 100).any()  # the title is still there


def test_a_click_tells_the_surface(small_glb, tmp_path):
    page = tmp_path / "viewer.html"
    build_viewer(small_glb, page, house_id="small")
    with_action(
        page,
        'document.getElementById("plan").click();'
        "const part = pick(290 + (window.innerWidth - 290) / 2, window.innerHeight / 2);"
        "describe(part);"
        'const text = document.getElementById("info").textContent;'
        'const good = text.includes("Floor") && text.includes("12.00") && text.includes("observed")'
        ' && text.includes("Bedroom");'
        'document.body.style.background = good ? "#00ff00" : "#ff0000";'
        'document.getElementById("view").remove();',
    )
    scene = screenshot(page, tmp_path)
    assert tuple(scene[300, 600]) == (0, 255, 0)


def test_occlusion_darkens_and_never_brightens(small_glb, tmp_path):
    pytest.importorskip("embreex")
    page = tmp_path / "viewer.html"
    build_viewer(small_glb, page, house_id="small")
    shaded = screenshot(page, tmp_path)[:, 290:]
    with_action(page, "parts.forEach((part) => { part.shade = null; }); refresh();")
    plain = screenshot(page, tmp_path)[:, 290:]
    assert (shaded <= plain + 2).all()
    seen = (plain.max(2) - plain.min(2)) > 40  # the painted surfaces, not the page
    assert (plain - shaded).max(2)[seen].mean() > 4
    assert (plain == shaded).all(2)[seen].mean() > 0.02  # the open floor keeps its colour


NAME = '"><script>document.body.remove()</script><img src=x onerror=document.body.remove()>'


def test_a_name_of_markup_is_text(small_glb, tmp_path):
    page = tmp_path / "viewer.html"
    build_viewer(small_glb, page, house_id=NAME)
    with_action(
        page,
        'const title = document.querySelector("h1").textContent;'
        'const good = title.startsWith("\\"><scr" + "ipt>") && title.endsWith("remove()>");'
        'document.body.style.background = good ? "#00ff00" : "#ff0000";'
        'document.getElementById("view").remove();',
    )
    assert tuple(screenshot(page, tmp_path)[300, 600]) == (0, 255, 0)


def test_the_index_page_shows_pictures_and_runs_nothing(small_house, tmp_path):
    folder = tmp_path / "houses" / "small"
    write_scene_json(small_house, folder / "scene.json")
    Image.new("RGB", (400, 300), (255, 0, 0)).save(folder / "preview.png")
    table = tmp_path / "table.csv"
    table.write_text(f"method\n{NAME.replace(',', '')}\n")
    write_index(
        tmp_path / "index.html",
        scenes=[folder / "scene.json"],
        table=table,
        plot=tmp_path / "plot.png",
        dataset=NAME,
        method=NAME,
    )
    page = tmp_path / "index.html"
    text = page.read_text(encoding="utf-8")
    blue = "<script>document.body.replaceChildren()</script></body>"
    page.write_text(text.replace("</body>", blue), encoding="utf-8")
    red = (screenshot(page, tmp_path) == (255, 0, 0)).all(axis=2)
    assert red.sum() > 2000
