"""Trace drawn plans in styles that were not trained on, for docs/measurements/trace.md.

python benchmarks/trace.py [--listings FOLDER [--copies]] [--plans 60] [--opened 0.4] [--dark]
    [--pictures FOLDER]

With --listings, real listings are traced first: FOLDER/HOME/plan.* with FOLDER/HOME.json (the
truth) and FOLDER/score.py, which prints the figures of a traced plan. With --copies, a table shows
the figures for changed copies of the pictures (smaller, turned, photographed and others) instead.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from PIL import Image, ImageOps
from scipy.optimize import linear_sum_assignment
from shapely.geometry import Polygon

from plan2scene.errors import InputError
from plan2scene.images import write_png
from plan2scene.seeds import generator
from plan2scene_app.tracing.settings import SETTINGS
from plan2scene_app.tracing.trace import TracedPlan, overlay, trace_picture, write_trace
from plan2scene_workshop.plans.drawing import DrawnPlan
from plan2scene_workshop.plans.paper import bend, homography, worn
from plan2scene_workshop.plans.views import other_drawing

#: Largest distance of a found corner from a true one, as a share of the plan's longer side.
NEAR = 0.01
#: Largest distance of a found opening's middle from the true one, as a share of its width.
OPENING_NEAR = 0.5
WEARS = ("as drawn", "scanned", "photographed")


@dataclass(frozen=True)
class Truth:
    """A drawn plan in the pixels of its picture."""

    rooms: list[Polygon]
    openings: list[tuple[str, np.ndarray, float]]  #: kind, middle and width in pixels
    metres: float  #: mean size of a pixel in metres
    areas: list[float]  #: areas of the rooms, m2


def test_picture(
    number: int, wear: str, opened: float = 0.0, *, dark: bool = False
) -> tuple[np.ndarray, Truth]:
    """Return picture `number` and its truth; if `dark`, as a negative on dark coloured paper."""
    rng = generator(7, "trace benchmark", number)
    ppm = float(np.exp(rng.uniform(np.log(35), np.log(90))))
    drawn = other_drawing(1000 + number, 7, ppm, held_out=True, finer=1, opened=opened)
    h, w = drawn.labels.shape
    turn = 0.0 if wear == "as drawn" else float(rng.normal(0, 1.5))
    keystone = 0.02 if wear == "photographed" else 0.0
    move = homography((h, w), rng, turn=turn, keystone=keystone)
    image = drawn.image
    if dark:
        paper = generator(7, "dark paper", number).integers(10, 110, 3)
        image = (paper + (255 - image) / 255 * (255 - paper)).astype(np.uint8)
    if wear != "as drawn":
        edge = tuple(int(v) for v in image[0, 0])
        image, _ = bend(image, drawn.labels, move, (h, w), rng, beyond=edge)
        image = worn(image, rng, photographed=wear == "photographed")
    return image, _truth(drawn, move)


def _truth(drawn: DrawnPlan, move: np.ndarray) -> Truth:
    """Return the truth of a drawing after a homography."""

    def pixels(points: np.ndarray) -> np.ndarray:
        flat = ((np.asarray(points, float) - drawn.origin) * drawn.ppm)[:, None].astype(np.float32)
        return cv2.perspectiveTransform(flat, move)[:, 0].astype(float)

    rooms = [Polygon(pixels(np.array(r.exterior.coords))) for r in drawn.plan.rooms]
    openings = []
    for gap in drawn.plan.gaps:
        a, b = pixels(np.array([gap.start, gap.end]))
        openings.append((gap.kind, (a + b) / 2, float(np.linalg.norm(b - a))))
    areas = [room.area for room in drawn.plan.rooms]
    metres = float(np.sqrt(sum(areas) / sum(room.area for room in rooms)))
    return Truth(rooms, openings, metres, areas)


def f1(hits: int, found: int, true: int) -> float:
    """Return the F1 score."""
    return 2 * hits / max(found + true, 1)


def compare(plan: TracedPlan, truth: Truth) -> dict[str, float]:
    """Return the figures of one traced plan."""

    def pixels(points: np.ndarray) -> np.ndarray:
        placed = plan.in_file(np.asarray(points, float))
        if plan.sheet is None:
            return placed
        return cv2.perspectiveTransform(placed[:, None], plan.sheet.to_picture)[:, 0]

    rings = [np.array(room.polygon.exterior.coords) for room in plan.rooms]
    flat = [Polygon(plan.in_file(ring)) for ring in rings]
    rooms = [Polygon(pixels(ring)) for ring in rings]
    overlaps = np.array(
        [[a.intersection(b).area / a.union(b).area for b in truth.rooms] for a in rooms]
    )
    rows, columns = linear_sum_assignment(-overlaps)
    pairs = [(i, j) for i, j in zip(rows, columns, strict=True) if overlaps[i, j] >= 0.5]
    metres = plan.file_metres
    errors = [abs(flat[i].area * metres**2 / truth.areas[j] - 1) for i, j in pairs]
    bounds = np.concatenate([np.array(r.exterior.coords) for r in truth.rooms])
    near = NEAR * float(np.ptp(bounds, axis=0).max())
    # Of a sheet's pixels, as many as the rooms cover, for one of the photo.
    shrunk = np.sqrt(sum(room.area for room in flat) / sum(room.area for room in rooms))
    scale = abs(metres * shrunk / truth.metres - 1)
    return {
        "rooms": f1(len(pairs), len(rooms), len(truth.rooms)),
        "corners": corner_f1(rooms, truth.rooms, near),
        "openings": opening_f1(plan, pixels, truth),
        "area": float(np.median(errors)) if errors else np.nan,
        "scale": scale,
        "sure": plan.scale.confidence,
    }


def corner_f1(found: list[Polygon], true: list[Polygon], near: float) -> float:
    """Return F1 of the distinct corners of all rooms."""
    sets = []
    for polygons in (found, true):
        kept: list[np.ndarray] = []
        for point in np.concatenate([np.array(p.exterior.coords)[:-1] for p in polygons]):
            if all(np.linalg.norm(point - other) > near for other in kept):
                kept.append(point)
        sets.append(np.array(kept))
    apart = np.linalg.norm(sets[0][:, None] - sets[1][None], axis=2)
    rows, columns = linear_sum_assignment(apart)
    hits = int((apart[rows, columns] <= near).sum())
    return f1(hits, len(sets[0]), len(sets[1]))


def opening_f1(plan: TracedPlan, pixels, truth: Truth) -> float:
    """Return F1 of openings; a hit has the right kind and position."""
    found = [(o.kind, pixels(np.array([o.start, o.end])).mean(0)) for o in plan.openings]
    if not found:
        return 0.0
    cost = np.array(
        [
            [
                float(np.linalg.norm(middle - spot)) / width if kind == other else 9.0
                for other, spot, width in truth.openings
            ]
            for kind, middle in found
        ]
    )
    rows, columns = linear_sum_assignment(cost)
    hits = int((cost[rows, columns] <= OPENING_NEAR).sum())
    return f1(hits, len(found), len(truth.openings))


def measure(
    count: int,
    model: Path | None,
    pictures: Path | None,
    opened: float = 0.0,
    *,
    dark: bool = False,
) -> dict[str, list[dict[str, float]]]:
    """Return the figures of every picture by wear; for a refused one all F1 are 0.

    Inner doors are open passages with probability `opened`; `dark` pictures are light on dark.
    """
    results: dict[str, list[dict[str, float]]] = {wear: [] for wear in WEARS}
    with tempfile.TemporaryDirectory() as folder:
        for number in range(count):
            wear = WEARS[number % len(WEARS)]
            image, truth = test_picture(number, wear, opened, dark=dark)
            path = Path(folder) / "plan.png"
            write_png(path, image)
            try:
                plan = trace_picture(path, model=model)
            except InputError as error:
                print(f"plan {number}: {error}")
                results[wear].append(dict.fromkeys(("rooms", "corners", "openings"), 0.0))
                continue
            row = compare(plan, truth)
            results[wear].append(row)
            if pictures is not None:
                write_png(
                    pictures / f"{row['rooms']:.2f}_{row['corners']:.2f}_{number:03d}.png",
                    overlay(plan),
                )
    return results


def print_listings(folder: Path, model: Path | None) -> None:
    """Print the output of score.py and the processor seconds for each listing."""
    for truth in sorted(folder.glob("*.json")):
        for picture in sorted((folder / truth.stem).glob("plan.*")):
            if picture.suffix == ".json":
                continue
            with tempfile.TemporaryDirectory() as made:
                out = Path(made) / "plan.json"
                start = time.process_time()
                try:
                    write_trace(picture, out, model=model)
                except InputError as error:
                    print(f"{truth.stem}: {error}")
                    continue
                print(f"{truth.stem}: {time.process_time() - start:.1f} s", flush=True)
                score = [sys.executable, str(folder / "score.py"), str(folder), truth.stem]
                subprocess.run([*score, str(out)], check=True)


def on_paper(image: Image.Image) -> Image.Image:
    """Return a picture in the middle of a white page that is 1.66 times as wide and high."""
    page = Image.new("RGB", (int(image.width * 1.66), int(image.height * 1.66)), "white")
    page.paste(image, (image.width // 3, image.height // 3))
    return page


def photographed(image: Image.Image) -> Image.Image:
    """Return a phone's photo of a printed picture, held obliquely over a table in uneven light."""
    page = ImageOps.expand(image, round(0.05 * max(image.size)), "white")
    return _photo(page, max(page.size), (20.0, -12.0, 4.0), 1.25)


def close_up(image: Image.Image) -> Image.Image:
    """Return a phone's photo of a printed picture that fills it, held a little aside."""
    page = ImageOps.expand(image, max(image.size) // 2, "white")
    return _photo(page, max(image.size), (8.0, -5.0, 2.0), 1.1)


def _photo(
    page: Image.Image, length: int, degrees: tuple[float, float, float], away: float
) -> Image.Image:
    """Return a photo of a page on a table, from `away` times `length` pixels of the page."""
    size = (3000, 2250) if page.width > page.height else (2250, 3000)
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * page.size / length / 2
    turn = cv2.Rodrigues(np.radians(np.array(degrees)))[0]
    points = np.c_[corners, np.zeros(4)] @ turn.T + [0, 0, away]
    places = points[:, :2] / points[:, 2:] * 0.75 * max(size) + np.array(size) / 2
    own = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32) * np.array(page.size, np.float32)
    move = cv2.getPerspectiveTransform(own, places.astype(np.float32))
    table = np.full((size[1], size[0], 3), (95, 75, 60), np.uint8)
    how = cv2.INTER_AREA, cv2.BORDER_TRANSPARENT
    photo = cv2.warpPerspective(np.asarray(page), move, size, table, *how).astype(np.float32)
    photo *= np.linspace(0.6, 0.95, size[0])[None, :, None] * [1.0, 0.96, 0.88]
    photo = cv2.GaussianBlur(photo, (0, 0), 0.8) + generator(0, "photo").normal(0, 3, photo.shape)
    return Image.fromarray(np.clip(photo, 0, 255).astype(np.uint8))


def on_screen(image: Image.Image) -> Image.Image:
    """Return a picture between the dark bars of a screenshot."""
    width, height = image.size
    screen = Image.new("RGB", (round(1.1 * width), round(1.25 * height)), (32, 32, 32))
    screen.paste(image, (width // 20, height // 8))
    return screen


COPIES = {
    "as it is": lambda image: image,
    "half": lambda image: image.resize((image.width // 2, image.height // 2), Image.LANCZOS),
    "enlarged": lambda image: image.resize(
        (int(image.width * 1.4), int(image.height * 1.4)), Image.BICUBIC
    ),
    "on more paper": on_paper,
    "turned": lambda image: image.rotate(3, expand=True, fillcolor="white", resample=Image.BICUBIC),
    "photographed": photographed,
    "close up": close_up,
    "on a screen": on_screen,
}


def print_copies(folder: Path, model: Path | None) -> None:
    """Print room F1 and the found doors for each copy of each listing's picture."""
    print(f"| listing | {' | '.join(COPIES)} |\n|---|{'---|' * len(COPIES)}")
    for truth in sorted(folder.glob("*.json")):
        cells = []
        (picture,) = (p for p in (folder / truth.stem).glob("plan.*") if p.suffix != ".json")
        for copied in COPIES.values():
            with tempfile.TemporaryDirectory() as made:
                copied(Image.open(picture).convert("RGB")).save(Path(made) / "copy.png")
                try:
                    write_trace(Path(made) / "copy.png", Path(made) / "plan.json", model=model)
                except InputError:
                    cells.append("refused")
                    continue
                score = [sys.executable, "score.py", ".", truth.stem, f"{made}/plan.json"]
                said = subprocess.run(score, cwd=folder, check=True, capture_output=True, text=True)
                rooms = re.search(r"all rooms +F1 ([0-9.]+)", said.stdout)
                doors = re.search(r"found (\d+ of \d+)", said.stdout)
                cells.append(f"{float(rooms[1]):.2f}, {doors[1]}")
        print(f"| {truth.stem} | {' | '.join(cells)} |", flush=True)


def print_table(results: dict[str, list[dict[str, float]]]) -> None:
    """Print the table of docs/measurements/trace.md."""
    print(
        "| pictures | n | room F1 | corner F1 | opening F1 | area error | scale error "
        "| sure of the scale | scale error of those | refused |"
    )
    print("|---|---|---|---|---|---|---|---|---|---|")
    groups = [*results.items(), ("all", [row for rows in results.values() for row in rows])]
    for name, rows in groups:
        told = [row for row in rows if "scale" in row]
        sure = [row for row in told if row["sure"] >= SETTINGS.sure]
        cells = [
            f"{np.mean([row[key] for row in rows]):.3f}" for key in ("rooms", "corners", "openings")
        ]
        cells += [f"{np.nanmedian([row[key] for row in told]):.1%}" for key in ("area", "scale")]
        cells += [f"{len(sure) / max(len(told), 1):.0%}"]
        cells += [f"{np.median([row['scale'] for row in sure]):.1%}" if sure else "-"]
        print(f"| {name} | {len(rows)} | {' | '.join(cells)} | {len(rows) - len(told)} |")


def main() -> None:
    """Print the tables; with --pictures write overlays whose names begin with their figures."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--listings", type=Path)
    parser.add_argument("--copies", action="store_true")
    parser.add_argument("--plans", type=int, default=60)
    parser.add_argument("--opened", type=float, default=0.0)
    parser.add_argument("--dark", action="store_true")
    parser.add_argument("--model", type=Path)
    parser.add_argument("--pictures", type=Path)
    given = parser.parse_args()
    if given.pictures is not None:
        given.pictures.mkdir(parents=True, exist_ok=True)
    if given.listings is not None:
        (print_copies if given.copies else print_listings)(given.listings, given.model)
    if not given.plans:
        return
    found = measure(given.plans, given.model, given.pictures, given.opened, dark=given.dark)
    print_table(found)


if __name__ == "__main__":
    main()
