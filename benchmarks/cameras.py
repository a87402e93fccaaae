"""Compare cameras, rectified planes and scale with the truth of synthetic or real photos.

``python benchmarks/cameras.py ROOT [--labels KIND ...] [--split SPLIT] [--limit N] [--bend K]``
``python benchmarks/cameras.py --real FOLDER [--labels KIND ...]``

ROOT has the layout of docs/conventions.md with ``truth/{split}/{house}/``. Rotations are compared
up to quarter turns about the vertical, because a Manhattan frame is only known up to those.
``--bend`` adds lens distortion: a point at radius r (in half diagonals) moves to ``r (1 + K r^2)``.
FOLDER has ``index.csv`` (name, fx in pixels), ``{name}.jpg`` and ``{name}.mask.png``.
"""

from __future__ import annotations

import argparse
import csv
import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from plane_errors import PlaneError, plane_errors

from plan2scene.camera import Camera
from plan2scene.images import read_image
from plan2scene.photos.camera.calibration import DEFAULT_FOV_DEG, canonical, estimate_camera
from plan2scene.photos.camera.exif import read_exif_focal
from plan2scene.photos.camera.lines import CAMERA, find_segments
from plan2scene.photos.labels.palette import read_label_png
from plan2scene.photos.labels.segmentation import load_segmenter
from plan2scene.photos.planes.planes import split_planes
from plan2scene.photos.planes.walls import room_extent
from plan2scene.plans.scene_json import read_scene_json
from plan2scene.weights import MODELS

KINDS = ("truth", "rough", "network", "none")
#: A plane is square if its error is at most this, degrees.
SQUARE_DEG = 2.0


@dataclass(frozen=True)
class Result:
    """Errors of one photo: degrees, relative errors of focal length and camera height; seconds."""

    photo: str
    rotation_deg: float
    tilt_deg: float
    focal: float
    camera: Camera
    seconds: float
    prior_scale: float = float("nan")
    extent_scale: float = float("nan")
    room_scale: float = float("nan")
    planes: list[PlaneError] = field(default_factory=list)


@dataclass(frozen=True)
class Photo:
    """A photo with its truth."""

    name: str
    truth: Mapping[str, Any]
    house_truth: Path
    plan: Path
    file: Path

    @property
    def mask(self) -> Path:
        """Return its true label mask."""
        return self.house_truth / "masks" / f"{Path(self.name).stem}.png"


def photos_of(root: Path, split: str) -> Iterator[Photo]:
    """Yield every photo of a split."""
    for file in sorted((root / "truth" / split).glob("*/cameras.json")):
        plan = root / "archs_no_objects" / split / f"{file.parent.name}.scene.json"
        for name, value in sorted(json.loads(file.read_text()).items()):
            yield Photo(name, value, file.parent, plan, root / "photos" / name)


def rotation_error_deg(estimate: Camera, truth: Camera) -> tuple[float, float]:
    """Return the angle between rotations up to quarter turns, and between the up vectors."""
    ours, theirs = canonical(estimate.matrix), canonical(truth.matrix)
    best = 180.0
    for quarter in range(4):
        turn = np.radians(90 * quarter)
        about = np.array(
            [[np.cos(turn), 0, np.sin(turn)], [0, 1, 0], [-np.sin(turn), 0, np.cos(turn)]]
        )
        cosine = (np.trace(ours.T @ theirs @ about) - 1) / 2
        best = min(best, float(np.degrees(np.arccos(np.clip(cosine, -1, 1)))))
    tilt = np.degrees(np.arccos(np.clip(ours[:, 1] @ theirs[:, 1], -1, 1)))
    return best, float(tilt)


def roughened(labels: np.ndarray, seed: int) -> np.ndarray:
    """Return labels with borders displaced by smooth noise of 2.5 px (standard deviation)."""
    rng = np.random.default_rng(seed)
    shift = [
        cv2.GaussianBlur(rng.normal(size=labels.shape).astype(np.float32), (0, 0), 8)
        for _ in range(2)
    ]
    y, x = np.mgrid[0 : labels.shape[0], 0 : labels.shape[1]].astype(np.float32)
    moved = [2.5 * s / float(s.std()) + grid for s, grid in zip(shift, (x, y), strict=True)]
    return cv2.remap(labels, moved[0], moved[1], cv2.INTER_NEAREST, borderMode=cv2.BORDER_REPLICATE)


def labeller(kind: str) -> Callable[[np.ndarray, Path], np.ndarray | None]:
    """Return the function from a photo and its true mask file to labels, by kind of labels."""
    if kind == "network":
        network = load_segmenter(MODELS / "segmentation.safetensors")
        return lambda image, _mask: network.labels(image)
    if kind == "rough":
        return lambda _image, mask: roughened(read_label_png(mask), len(mask.name))
    if kind == "truth":
        return lambda _image, mask: read_label_png(mask)
    return lambda _image, _mask: None


def bent(image: np.ndarray, bend: float, interpolation: int) -> np.ndarray:
    """Return an image or label mask with lens distortion `bend`; unknown pixels are black."""
    height, width = image.shape[:2]
    y, x = np.mgrid[0:height, 0:width].astype(np.float32)
    x, y = x - (width - 1) / 2, y - (height - 1) / 2
    straight = np.ones_like(x)
    for _ in range(8):
        radius = (x**2 + y**2) * straight**2 / ((width**2 + height**2) / 4)
        straight = 1 / (1 + bend * radius)
    at_x, at_y = x * straight + (width - 1) / 2, y * straight + (height - 1) / 2
    return cv2.remap(image, at_x, at_y, interpolation)


def measure(
    root: Path, split: str, fov_deg: float, kind: str, limit: int, bend: float
) -> list[Result]:
    """Return the errors of up to `limit` photos, spread over the split."""
    photos = list(photos_of(root, split))
    label = labeller(kind)
    return [
        _of_photo(photo, label, fov_deg, bend)
        for photo in photos[:: max(1, len(photos) // limit)][:limit]
    ]


def _of_photo(
    photo: Photo,
    label: Callable[[np.ndarray, Path], np.ndarray | None],
    fov_deg: float,
    bend: float,
) -> Result:
    """Return the errors of one photo; those of planes only without `bend`."""
    truth = Camera.from_json(photo.truth, file=photo.name)
    image = read_image(photo.file)
    labels = label(image, photo.mask)
    if bend:
        image = bent(image, bend, cv2.INTER_LINEAR)
        labels = None if labels is None else bent(labels, bend, cv2.INTER_NEAREST)
    start = time.perf_counter()
    estimate = estimate_camera(image, labels, fov_deg=fov_deg)
    seconds = time.perf_counter() - start
    rotation, tilt = rotation_error_deg(estimate, truth)
    focal = estimate.focal_px / truth.focal_px - 1
    if labels is None or bend:
        return Result(photo.name, rotation, tilt, focal, estimate, seconds)
    height = photo.truth["position"][1]
    room = read_scene_json(photo.plan, photo.house_truth.name).room(photo.truth["room_id"])
    segments = find_segments(image).walls
    alone = split_planes(labels, estimate, segments=segments)
    extent = room_extent(room)
    only = split_planes(labels, estimate, segments=segments, room_extent_m=extent)
    known = split_planes(
        labels, estimate, segments=segments, room_height_m=room.height, room_extent_m=extent
    )
    errors = plane_errors(
        photo.name,
        photo.truth,
        photo.house_truth / "planes" / photo.mask.name,
        estimate,
        known,
    )
    scale = [p[0].camera_height_m / height - 1 if p else float("nan") for p in (alone, only, known)]
    return Result(photo.name, rotation, tilt, focal, estimate, seconds, *scale, planes=list(errors))


def measure_real(folder: Path, fov_deg: float, kind: str) -> list[Result]:
    """Return the focal errors of a folder of annotated photos."""
    label = labeller(kind)
    results = []
    with (folder / "index.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        path = folder / f"{row['name']}.jpg"
        image = read_image(path)
        labels = label(image, folder / f"{row['name']}.mask.png")
        start = time.perf_counter()
        exif = read_exif_focal(path, (image.shape[0], image.shape[1]))
        estimate = estimate_camera(image, labels, fov_deg=fov_deg, exif=exif)
        seconds = time.perf_counter() - start
        nan = float("nan")
        focal = estimate.focal_px / float(row["fx"]) - 1
        results.append(Result(row["name"], nan, nan, focal, estimate, seconds))
    return results


def figures(results: Sequence[Result]) -> dict[str, str]:
    """Return the figures of a set of photos: name of the figure -> text."""
    found: dict[str, str] = {"photos": str(len(results))}

    def add(name: str, values: Sequence[float], digits: int = 2) -> None:
        kept = np.abs([value for value in values if np.isfinite(value)])
        if len(kept):
            half, most = np.percentile(kept, [50, 90])
            found[name] = f"{half:.{digits}f} / {most:.{digits}f}"

    add("rotation, deg", [r.rotation_deg for r in results])
    add("tilt, deg", [r.tilt_deg for r in results])
    add("focal length, %", [100 * r.focal for r in results], 1)
    high = [r for r in results if r.camera.confidence >= CAMERA.high_confidence]
    found["share of high confidence, %"] = f"{100 * len(high) / max(1, len(results)):.0f}"
    add("focal length at high confidence, %", [100 * r.focal for r in high], 1)
    low = [r for r in results if r.camera.confidence < CAMERA.high_confidence]
    add("focal length at low confidence, %", [100 * r.focal for r in low], 1)
    planes = [plane for r in results for plane in r.planes]
    if planes:
        add("checker lines off square, deg", [p.square_deg for p in planes])
        add("checker lines off the axes, deg", [p.direction_deg for p in planes])
        within = np.mean([p.square_deg <= SQUARE_DEG for p in planes])
        found[f"planes within {SQUARE_DEG:g} deg of square, %"] = f"{100 * within:.0f}"
        add("scale, height prior alone, %", [100 * r.prior_scale for r in results], 1)
        add("scale, room's extent known, %", [100 * r.extent_scale for r in results], 1)
        add("scale, room's height and extent known, %", [100 * r.room_scale for r in results], 1)
        add("distance of a plane, both known, %", [100 * p.distance for p in planes], 1)
    found["seconds per photo"] = f"{np.mean([r.seconds for r in results]):.2f}"
    return found


def table(columns: Mapping[str, dict[str, str]]) -> str:
    """Return figures as a Markdown table with one column per kind of labels."""
    names = list(dict.fromkeys(name for column in columns.values() for name in column))
    lines = ["| median / 90 % | " + " | ".join(columns) + " |", "|---" * (len(columns) + 1) + "|"]
    for name in names:
        cells = [column.get(name, "") for column in columns.values()]
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _print_each(results: Sequence[Result]) -> None:
    """Print one line per photo, the most certain first."""
    for r in sorted(results, key=lambda r: -r.camera.confidence):
        print(
            f"{r.photo}: rotation {r.rotation_deg:.2f}, tilt {r.tilt_deg:.2f}, focal "
            f"{100 * r.focal:+.1f} %, {r.camera.focal_source}, "
            f"confidence {r.camera.confidence:.2f}, scale {100 * r.prior_scale:+.0f} %, "
            f"with the extent {100 * r.extent_scale:+.0f} %, the room {100 * r.room_scale:+.0f} %"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("root", type=Path, nargs="?")
    parser.add_argument("--real", type=Path, help="a folder of annotated real photos")
    parser.add_argument("--split", default="val")
    parser.add_argument("--limit", type=int, default=200)
    parser.add_argument("--fov", type=float, default=DEFAULT_FOV_DEG)
    parser.add_argument("--labels", choices=KINDS, nargs="+", default=["truth", "network"])
    parser.add_argument("--bend", type=float, default=0.0, help="radial distortion to apply")
    parser.add_argument("--each", action="store_true", help="one line per photo too")
    arguments = parser.parse_args()
    if arguments.root is None and arguments.real is None:
        parser.error("a data set (ROOT) or --real FOLDER")
    columns = {}
    for kind in arguments.labels:
        if arguments.real is not None:
            results = measure_real(arguments.real, arguments.fov, kind)
        else:
            drawn = arguments.split, arguments.fov, kind, arguments.limit, arguments.bend
            results = measure(arguments.root, *drawn)
        if not results:
            raise SystemExit(f"no photos with truth in {arguments.real or arguments.root}")
        if arguments.each:
            print(f"masks: {kind}")
            _print_each(results)
        columns[f"masks: {kind}"] = figures(results)
    print(table(columns))


if __name__ == "__main__":
    main()
