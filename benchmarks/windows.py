"""Measure the crop filter against windows of real photos that were judged by eye.

``python benchmarks/windows.py FLAT... [--masks true network] [--windows CSV]``

FLAT has the layout of a scored flat: ``scene/*.scene.json``, ``photo_assignments/*.csv``,
``photos/`` and, for the true labels, ``gt/masks/`` (4, openings, counts as other). The CSV
(``benchmarks/windows.csv``) has a line for each window: the flat, the photo, the surface, the
corners in the photo (pixels, clockwise from the crop's top left) and whether it is a usable sample
of that surface, as judged by eye; it holds no pixels. A window is kept if it lies on one plane of
the labels and the filter has no reason against it; the vote of a surface's windows is not used.
The script prints precision and recall of the kept windows, and for each reason the number of its
windows and how many of them are usable.
"""

from __future__ import annotations

import argparse
import csv
import tempfile
from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from plan2scene.camera import Camera
from plan2scene.datasets.assignments import rooms_of_photos
from plan2scene.images import read_image
from plan2scene.io import read_json
from plan2scene.photos.camera.lines import find_segments
from plan2scene.photos.crops.filter import inner_mask, judge_of, strong_edges, with_reason
from plan2scene.photos.crops.sampling import (
    CROP_PX,
    SAMPLING,
    Candidate,
    Reason,
    cut_window,
    window_pixels,
)
from plan2scene.photos.labels.labeller import labeller
from plan2scene.photos.labels.palette import read_label_png, write_label_png
from plan2scene.photos.masks import make_masks
from plan2scene.photos.planes.planes import Plane, split_planes
from plan2scene.photos.planes.rectification import RectifiedPlane, plane_axes, rectify
from plan2scene.photos.planes.walls import RoomSize
from plan2scene.plans.scene_json import read_scene_json
from plan2scene.weights import MODELS

_OFF = "not on the surface"  # the reason against a window outside the labels' planes
_COVERED = 0.98  # smallest share of a window that must lie on its plane


@dataclass(frozen=True)
class Looked:
    """A window that was judged by eye: corners (4, 2) in the photo, pixels."""

    photo: str
    surface: str
    corners: np.ndarray
    usable: bool


def read_windows(path: Path) -> dict[str, list[Looked]]:
    """Return the windows of each flat."""
    found: dict[str, list[Looked]] = defaultdict(list)
    with path.open(newline="") as file:
        for row in csv.DictReader(file):
            corners = np.array([float(row[f"{axis}{k}"]) for k in range(4) for axis in "xy"])
            usable = row["usable"] == "1"
            item = Looked(row["photo"], row["surface"], corners.reshape(4, 2), usable)
            found[row["flat"]].append(item)
    return found


def masks_of(flat: Path, photos: dict[str, Path], kind: str, work: Path) -> Path:
    """Return the folder of masks and cameras of a flat."""
    folder = work / kind / flat.name
    truth = work / "labels" / flat.name
    truth.mkdir(parents=True, exist_ok=True)
    if kind == "true":
        for photo in photos:
            name = f"{Path(photo).stem}.png"
            labels = read_image(flat / "gt" / "masks" / name)[..., 0].copy()
            labels[labels == 4] = 0
            write_label_png(truth / name, labels)
    source = "precomputed" if kind == "true" else "embedded"
    label = partial(
        labeller, source, model=MODELS / "segmentation.safetensors", precomputed_dir=truth
    )
    make_masks(photos, label, folder, house_id=flat.name)
    return folder


def verdicts(flat: Path, windows: list[Looked], kind: str, work: Path) -> Iterator[tuple[str, ...]]:
    """Yield the reasons against each window (none for a good one), photo by photo."""
    house = read_scene_json(next((flat / "scene").glob("*.json")), flat.name)
    rooms = rooms_of_photos(next((flat / "photo_assignments").glob("*.csv")), house)
    photos = {photo: flat / "photos" / photo for photo in rooms}
    folder = masks_of(flat, photos, kind, work)
    cameras = read_json(folder / "cameras.json")
    for photo, group in _by_photo(windows).items():
        image = read_image(photos[photo])
        camera = Camera.from_json(cameras[photo])
        size = RoomSize.of(house.room(rooms[photo][0]))
        planes = split_planes(
            read_label_png(folder / f"{Path(photo).stem}.png"),
            camera,
            segments=find_segments(image).walls,
            room_height_m=size.height_m,
            room_extent_m=size.extent_m,
        )
        for window in group:
            yield _reasons(image, camera, planes, window)


def _by_photo(windows: list[Looked]) -> dict[str, list[Looked]]:
    """Return windows by their photo, in order."""
    groups: dict[str, list[Looked]] = defaultdict(list)
    for window in windows:
        groups[window.photo].append(window)
    return groups


def _reasons(
    image: np.ndarray, camera: Camera, planes: list[Plane], window: Looked
) -> tuple[str, ...]:
    """Return the reasons against a window on the plane that contains it."""
    for plane in planes:
        if plane.surface != window.surface:
            continue
        rays = camera.rays(window.corners)
        facing = -(rays @ np.array(plane.normal))
        if (facing <= 0.05).any():
            continue
        points = (rays * (-plane.offset / facing)[:, None]) @ plane_axes(plane)[:2].T
        size_m = float(np.ptp(points, axis=0).mean())
        density = CROP_PX / size_m / (1.2 * SAMPLING.upsampling[1])
        rectified = rectify(image, camera, plane, min_density=density)
        place = rectified and _place(rectified, points.mean(axis=0), size_m)
        if not rectified or place is None:
            continue
        side = window_pixels(rectified, size_m)
        crop = cut_window(rectified, camera, 0, *place, size_m)
        mask = rectify(
            image,
            camera,
            replace(plane, mask=inner_mask(plane.mask, strong_edges(image))),
            min_density=density,
        )
        inside = mask is not None and _place(mask, points.mean(axis=0), size_m) is not None
        rectified.mask[place[0] : place[0] + side, place[1] : place[1] + side] = True
        verdict = judge_of(plane.surface, inside=inside)(rectified, *place, side, crop)
        candidate = Candidate(crop, verdict, plane.surface, plane.index)
        if plane.scale_source == "prior":
            candidate = with_reason(candidate, Reason.UNKNOWN_DISTANCE)
        return tuple(candidate.verdict.reasons)
    return (_OFF,)


def _place(rectified: RectifiedPlane, middle: np.ndarray, size_m: float) -> tuple[int, int] | None:
    """Return (row, column) of a window about `middle` (2,) in metres; None if off the mask."""
    side = window_pixels(rectified, size_m)
    corner = (middle - size_m / 2 - np.array(rectified.origin)) / rectified.metres_per_pixel
    column, row = (int(v) for v in np.rint(corner))
    height, width = rectified.mask.shape
    slack = round(0.05 * side)
    if min(row, column) < -slack or row + side > height + slack or column + side > width + slack:
        return None
    row, column = (min(max(v, 0), n - side) for v, n in ((row, height), (column, width)))
    if min(row, column) < 0:
        return None
    covered = rectified.mask[row : row + side, column : column + side].mean()
    return (row, column) if covered >= _COVERED else None


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("flats", nargs="+", type=Path)
    parser.add_argument("--masks", nargs="+", default=["true"], choices=["true", "network"])
    parser.add_argument("--windows", type=Path, default=Path(__file__).with_suffix(".csv"))
    options = parser.parse_args()
    looked = read_windows(options.windows)
    for kind in options.masks:
        found: list[tuple[bool, tuple[str, ...]]] = []
        with tempfile.TemporaryDirectory() as work:
            for flat in options.flats:
                windows = [w for group in _by_photo(looked[flat.name]).values() for w in group]
                reasons = verdicts(flat, windows, kind, Path(work))
                found += [(w.usable, r) for w, r in zip(windows, reasons, strict=True)]
        _print(kind, found)


def _print(kind: str, found: list[tuple[bool, tuple[str, ...]]]) -> None:
    """Print precision and recall of the kept windows, and the table of reasons."""
    kept = [usable for usable, reasons in found if not reasons]
    every = sum(usable for usable, _ in found)
    print(f"\n{kind} labels: {len(found)} windows, {every} usable, {len(kept)} kept")
    print(f"precision {np.mean(kept):.2f}, recall {sum(kept) / every:.2f}\n")
    print("| reason | windows | of them usable |\n|---|---|---|")
    count: Counter[str] = Counter(str(r) for _, reasons in found for r in reasons)
    for reason, total in count.most_common():
        wrong = sum(usable for usable, reasons in found if reason in reasons)
        print(f"| {reason} | {total} | {wrong} |")


if __name__ == "__main__":
    main()
