"""Rotation and focal length of estimated cameras against the truth of a synthetic data set.

``python benchmarks/cameras.py ROOT [--limit N] [--fov DEG] [--split SPLIT] [--labels KIND]``

ROOT has the layout of docs/conventions.md with ``truth/{split}/{house}/cameras.json``. A rotation
is compared up to quarter turns about the vertical, as the heading of a Manhattan frame is.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from plan2scene.io import read_image
from plan2scene.photos.camera import Camera, canonical, estimate_camera
from plan2scene.photos.masks import read_label_png
from plan2scene.photos.segmentation import load_segmenter
from plan2scene.weights import MODELS


@dataclass(frozen=True)
class Result:
    """Errors of one photo: degrees, relative focal length, seconds."""

    photo: str
    rotation_deg: float
    tilt_deg: float
    focal: float
    source: str
    fallback: bool
    confidence: float
    seconds: float


def truths(root: Path, split: str) -> Iterator[tuple[str, Camera, Path, Path]]:
    """Yield photo name, true camera, photo file and true mask of every photo of a split."""
    for file in sorted((root / "truth" / split).glob("*/cameras.json")):
        for photo, value in sorted(json.loads(file.read_text()).items()):
            mask = file.parent / "masks" / f"{Path(photo).stem}.png"
            yield photo, Camera.from_json(value, file=file), root / "photos" / photo, mask


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


def measure(root: Path, split: str, fov_deg: float, labels: str, limit: int) -> list[Result]:
    """Return the errors of up to `limit` photos, spread over the split."""
    photos = list(truths(root, split))
    chosen = photos[:: max(1, len(photos) // limit)][:limit]
    results = []
    network = load_segmenter(MODELS / "segmentation.safetensors") if labels == "network" else None
    for photo, truth, file, mask in chosen:
        image = read_image(file)
        if network is not None:
            known = network.labels(image)
        else:
            known = None if labels == "none" else read_label_png(mask)
        if known is not None and labels == "rough":
            known = roughened(known, len(results))
        start = time.perf_counter()
        estimate = estimate_camera(image, known, fov_deg=fov_deg)
        seconds = time.perf_counter() - start
        rotation, tilt = rotation_error_deg(estimate, truth)
        results.append(
            Result(
                photo,
                rotation,
                tilt,
                estimate.focal_px / truth.focal_px - 1,
                estimate.focal_source,
                estimate.fallback,
                estimate.confidence,
                seconds,
            )
        )
    return results


def table(results: list[Result]) -> str:
    """Return the summary: all photos, then those by source of the focal length."""
    groups = {
        "all": results,
        "vanishing_points": [r for r in results if r.source == "vanishing_points"],
        "config": [r for r in results if r.source == "config" and not r.fallback],
        "fallback": [r for r in results if r.fallback],
    }
    lines = [
        "| photos | n | rotation deg median | 90 % | tilt deg median | 90 % "
        "| focal error % median | 90 % | seconds |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for name, group in groups.items():
        if not group:
            continue
        columns = [
            np.percentile([getattr(r, field) for r in group], q)
            for field in ("rotation_deg", "tilt_deg")
            for q in (50, 90)
        ]
        columns += [np.percentile([100 * abs(r.focal) for r in group], q) for q in (50, 90)]
        columns.append(np.mean([r.seconds for r in group]))
        lines.append(f"| {name} | {len(group)} | " + " | ".join(f"{c:.2f}" for c in columns) + " |")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("root", type=Path)
    parser.add_argument("--split", default="val")
    parser.add_argument("--limit", type=int, default=200)
    parser.add_argument("--fov", type=float, default=60.0)
    parser.add_argument("--labels", choices=("truth", "rough", "network", "none"), default="none")
    parser.add_argument("--each", action="store_true", help="one line per photo too")
    arguments = parser.parse_args()
    results = measure(
        arguments.root, arguments.split, arguments.fov, arguments.labels, arguments.limit
    )
    if not results:
        raise SystemExit(f"no photos with truth in {arguments.root / 'truth' / arguments.split}")
    if arguments.each:
        for r in sorted(results, key=lambda r: -r.rotation_deg):
            print(
                f"{r.photo}: rotation {r.rotation_deg:.2f}, tilt {r.tilt_deg:.2f}, "
                f"focal {100 * r.focal:+.1f} %, {r.source}, confidence {r.confidence:.2f}"
            )
    print(table(results))


if __name__ == "__main__":
    main()
