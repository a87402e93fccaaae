"""Measure how fast viewers load and draw in Chromium with software WebGL, 1280x720.

    python benchmarks/viewer.py results/demo/houses/*/viewer.html

Each page is loaded. Then the view is turned for a number of frames with every light, from outside
and inside: first at the page's full resolution (`--ratio 1`), then like a user by holding a key,
when slow machines draw at a lower resolution. The script prints the milliseconds until the page is
ready (by its own clock), frames per second, processor time of all browser processes per frame,
frames per second while the key is held, and the resolution of these frames.
"""

from __future__ import annotations

import argparse
import os
import platform
import sys
from pathlib import Path
from typing import Any

CLONE = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(CLONE / "tests" / "helpers"))
SIZE = (1280, 720)
TURN = """(async () => {
  const frame = () => new Promise(requestAnimationFrame), axis = new THREE.Vector3(0, 1, 0);
  const turn = async () => {
    eye.yaw += 0.02;
    camera.position.sub(orbit.target).applyAxisAngle(axis, 0.02).add(orbit.target);
    orbit.update();
    clearTimeout(resting);
    draw(RATIO);
    await frame();
  };
  pending = true; // what turns asks for a picture, too: one a turn is enough
  for (let k = 0; k < 3; k++) await turn();
  const start = performance.now();
  for (let k = 0; k < COUNT; k++) await turn();
  pending = false;
  return (performance.now() - start) / 1000;
})()"""
HELD = """(async () => {
  const later = (ms) => new Promise((done) => setTimeout(done, ms));
  const drawn = () => renderer.info.render.frame;
  hold("arrowright");
  await later(1000);
  const start = performance.now(), first = drawn();
  await later(2000);
  const rate = (drawn() - first) / ((performance.now() - start) / 1000), fine = PACES[pace];
  keys.clear();
  await later(500);
  return [rate, fine];
})()"""


def processor_seconds() -> float:
    """Return the processor time of all running processes that this one started."""
    rows = {}
    for folder in Path("/proc").iterdir():
        if folder.name.isdigit():
            try:
                fields = (folder / "stat").read_text().rsplit(")", 1)[1].split()
            except OSError:
                continue
            rows[int(folder.name)] = int(fields[1]), int(fields[11]) + int(fields[12])
    mine, ticks = {os.getpid()}, 0
    for pid in sorted(rows):  # parents before children
        if rows[pid][0] in mine:
            mine.add(pid)
            ticks += rows[pid][1]
    return ticks / os.sysconf("SC_CLK_TCK")


def measure(view: Any, page: Path, count: int, ratio: float) -> None:
    """Print the lines of one page."""
    turn = TURN.replace("COUNT", str(count)).replace("RATIO", str(ratio))
    before = processor_seconds()
    view.open(page.resolve())
    ready = view.run("document.body.dataset.ready")
    size = page.stat().st_size / 1e6
    used = processor_seconds() - before
    name = page.resolve().parent.name if page.stem == "viewer" else page.stem
    print(f"\n{name}: {size:.1f} MB, ready after {ready} ms, {used:.1f} s of processor time\n")
    print("| light | view | a second | processor ms | key held | as fine | draws | triangles |")
    print("|---|---|---|---|---|---|---|---|")
    for look in ("plain", "day", "lit"):
        for mode in ("orbit", "walk"):
            view.run(f'setLook("{look}"); setMode("{mode}")')
            before = processor_seconds()
            seconds = view.run(turn)
            used = 1000 * (processor_seconds() - before) / (count + 3)
            drawn = view.run("Object.values(renderer.info.render).slice(1, 3)")
            held, fine = view.run(HELD)
            row = [look, mode, f"{count / seconds:.1f}", f"{used:.0f}", f"{held:.1f}", fine, *drawn]
            print(f"| {' | '.join(map(str, row))} |", flush=True)


def main() -> None:
    from viewer_page import ViewerPage

    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("pages", nargs="+", type=Path)
    parser.add_argument("--pictures", type=int, default=40)
    parser.add_argument("--ratio", type=float, default=1.0, help="drawn pixels of the page's")
    given = parser.parse_args()
    print(f"{os.cpu_count()} cores, {platform.machine()}, load {os.getloadavg()[0]:.1f}")
    with ViewerPage(SIZE) as view:
        for page in given.pages:
            measure(view, page, given.pictures, given.ratio)


if __name__ == "__main__":
    main()
