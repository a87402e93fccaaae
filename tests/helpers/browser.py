"""A headless Chromium that tests click through; tests are skipped where there is none."""

import os
import shutil
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

CHROMIUM = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
)
#: An npm package beside the one for GLB files.
AXE = Path(os.environ.get("GLTF_VALIDATOR_DIR", "none"), "node_modules/axe-core/axe.min.js")


@contextmanager
def chromium(*options):
    if CHROMIUM is None:
        pytest.skip("no Chromium on PATH")
    with pytest.importorskip("playwright.sync_api").sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=CHROMIUM, args=["--no-sandbox", *(options or ["--disable-gpu"])]
        )
        yield browser
        browser.close()


def serious_violations(evaluate):
    """Return what axe-core, where it is installed, finds serious in a page; `evaluate` runs JS."""
    if not AXE.is_file():
        return []
    evaluate(AXE.read_text() + ";0")
    return evaluate(
        "axe.run(document).then(({ violations }) => violations"
        ".filter(({ impact }) => /serious|critical/.test(impact)).map(({ id }) => id))"
    )


def pages_and_photos(folder, *names):
    """Write two photos, and pages with one line, two lines, and so on."""
    folder.mkdir(exist_ok=True)
    noise = np.random.default_rng(0).integers(0, 255, (90, 120, 3), np.uint8)
    for name in ("b.jpg", "floorplan.jpg"):
        Image.fromarray(noise).save(folder / name)
    sheet = Image.new("RGB", (200, 150), "white")
    for k, name in enumerate(names):
        sheet.paste("black", (40, 40 + 60 * k, 160, 44 + 60 * k))
        sheet.save(folder / name)


class Drawing:
    """An open editor page: clicks and drags in metres of its drawing."""

    def __init__(self, page):
        self.page = page
        self.faults = []
        page.on("pageerror", lambda error: self.faults.append(str(error)))
        page.on(
            "console",
            lambda message: self.faults.append(message.text) if message.type == "error" else None,
        )

    def pixel(self, x, z):
        at = self.page.evaluate(
            "(p) => { const box = editor.view.svg.getBoundingClientRect();"
            " const at = editor.view.toPixels(p); return [box.x + at[0], box.y + at[1]]; }",
            [x, z],
        )
        return at

    def click(self, x, z):
        self.page.mouse.click(*self.pixel(x, z))

    def drag(self, start, end, *, steps=3):
        goal = self.pixel(*end)
        self.page.mouse.move(*self.pixel(*start))
        self.page.mouse.down()
        self.page.mouse.move(*goal, steps=steps)
        self.page.mouse.up()

    def press(self, *keys):
        for key in keys:
            self.page.keyboard.press(key)

    def two_rooms(self):
        """Draw a room of 5 x 3 m by dragging, divide it by a wall, put a door into that."""
        self.press("r")
        self.drag((0, 0), (5, 3))
        self.press("w")
        self.click(3, 0)
        self.click(3, 3)
        self.press("d")
        self.click(3, 1.5)
        self.press("v")

    @property
    def plan(self):
        return self.page.evaluate("editor.store.plan")

    @property
    def photos(self):
        return self.page.evaluate("editor.store.state.photos")
