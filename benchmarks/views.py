"""Compare each photo with a drawing of the house from the same position by CIEDE2000.

python benchmarks/views.py HOUSE PHOTOS                    # at the positions that were found
python benchmarks/views.py HOUSE PHOTOS --cameras cameras.csv --masks MASKS

HOUSE is results/{dataset}/houses/{house}. Known cameras are a table `photo, hfov_deg, yaw_deg,
pitch_deg, roll_deg, x, y, z, inside_room` (yaw 0 looks along x, 90 along z), with masks of labels.

The house is drawn without light. Photo and house are averaged over cells of 8x8 pixels. Exposure
and white balance do not count: each photo has one gain (three factors, the median over its
surfaces). Joinery is where the photo shows no surface but the house shows a door, frame, skirting
or window. The last column is a house with one colour for each kind, the median of the photos.
"""

import argparse
import csv
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from plan2scene.camera import Camera, as_rows, focal_of
from plan2scene.colour import delta_e_2000, linear_to_srgb, rgb_to_lab, srgb_to_linear
from plan2scene.images import read_image
from plan2scene.mesh.assembly import assemble
from plan2scene.mesh.texture_files import textured
from plan2scene.photos.labels.palette import DOOR, read_label_png
from plan2scene.photos.locate.pose import read_poses
from plan2scene.plans.scene_json import read_scene_json
from plan2scene_app.pictures.renderer import Triangles, look_at

CELL, WIDTH = 8, 256
KINDS = ("other", "floor", "wall", "ceiling", "joinery")
JOINERY = ("door", "passage", "threshold", "skirting", "window")
LEAST_CELLS = 24  # smallest number of surface cells of a photo with its own gain


def known_cameras(path: Path) -> Iterator[tuple[str, Camera]]:
    """Yield photos and their cameras (1 pixel wide and high) from a table as described above."""
    for row in csv.DictReader(path.open()):
        if row["inside_room"] != "1":
            continue
        yaw, pitch, roll = (np.radians(float(row[f"{k}_deg"])) for k in ("yaw", "pitch", "roll"))
        ahead = np.array([np.cos(pitch) * np.cos(yaw), np.sin(pitch), np.cos(pitch) * np.sin(yaw)])
        eye = np.array([float(row[k]) for k in "xyz"])
        focal = focal_of(np.radians(float(row["hfov_deg"])), 1)
        level = look_at(eye, eye + ahead, focal, (1, 1))
        right, down, ahead = level.matrix
        right, down = (
            np.cos(roll) * right - np.sin(roll) * down,
            np.cos(roll) * down + np.sin(roll) * right,
        )
        yield row["photo"], replace(level, rotation=as_rows(np.array([right, down, ahead])))


def cells(values: np.ndarray) -> np.ndarray:
    """Return the cells (n, 64, ...) of pixels (h, w, ...)."""
    high, wide = (size // CELL for size in values.shape[:2])
    parts = values.reshape(high, CELL, wide, CELL, *values.shape[2:])
    return parts.swapaxes(1, 2).reshape(high * wide, CELL * CELL, *values.shape[2:])


def gain(shown: np.ndarray, photo: np.ndarray) -> np.ndarray:
    return np.exp(np.median(np.log(photo + 1e-3) - np.log(shown + 1e-3), axis=0))


def fitted(shown: np.ndarray, photo: np.ndarray, kind: np.ndarray, of: np.ndarray) -> np.ndarray:
    """Return CIEDE2000 (n,) of cells after one gain for each photo."""
    surface = np.isin(kind, (1, 2, 3))
    made = shown * gain(shown[surface], photo[surface])
    for number in np.unique(of):
        own = surface & (of == number)
        if own.sum() >= LEAST_CELLS:
            made[of == number] = shown[of == number] * gain(shown[own], photo[own])
    labs = [rgb_to_lab(linear_to_srgb(np.clip(colours, 0, 1))) for colours in (made, photo)]
    return delta_e_2000(*labs)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("house", type=Path)
    parser.add_argument("photos", type=Path)
    parser.add_argument("--cameras", type=Path)
    parser.add_argument("--masks", type=Path)
    given = parser.parse_args()
    scene = read_scene_json(given.house / "scene.json", given.house.name)
    house, textures = textured(given.house / "textures", scene)
    parts = assemble(house).parts
    triangles = Triangles.of(parts, textures)
    counts = [len(part.mesh.faces) for part in parts]
    is_joinery = np.repeat([any(f"/{w}" in part.name for w in JOINERY) for part in parts], counts)
    is_pane = np.repeat([part.material == "glass" for part in parts], counts)
    cameras = list(known_cameras(given.cameras)) if given.cameras else []
    if not cameras:
        for name, pose in sorted(read_poses(given.house / "cameras.json").items()):
            lift = house.level_of(pose.room_id).elevation
            x, y, z = pose.position
            cameras.append((name, replace(pose.camera, position=(x, y + lift, z))))
    rows = []
    for number, (name, camera) in enumerate(cameras):
        photo = read_image(given.photos / name)
        size = round(WIDTH * photo.shape[0] / photo.shape[1]) // CELL * CELL, WIDTH
        camera = camera.resized(size)
        camera = replace(camera, cy=(size[0] - 1) / 2) if given.cameras else camera
        fragments = triangles.visible(camera, np.ones(len(is_pane), dtype=bool))
        view = np.full((size[0] * size[1], 3), np.nan)
        view[fragments.pixels] = triangles.looks(camera, fragments)
        flags = np.zeros((len(view), 2), dtype=bool)
        flags[fragments.pixels, 0] = (is_joinery & ~is_pane)[fragments.triangles]
        flags[fragments.pixels, 1] = is_pane[fragments.triangles]
        small = cv2.resize(
            srgb_to_linear(photo).astype(np.float32), size[::-1], interpolation=cv2.INTER_AREA
        )
        masks = given.masks or given.house / "masks"
        mask = read_label_png(masks / f"{Path(name).stem}.png", openings=True)
        labels = cells(cv2.resize(mask, size[::-1], interpolation=cv2.INTER_NEAREST))
        shares = np.stack([(labels == k).mean(axis=1) for k in range(DOOR)], axis=1)
        joinery, pane = cells(flags.reshape(*size, 2)).mean(axis=1).T
        kind = np.where(shares.max(axis=1) >= 0.9, shares.argmax(axis=1), -1)
        kind = np.where((kind == 0) & (joinery >= 0.5), KINDS.index("joinery"), kind)
        shown = cells(view.reshape(*size, 3)).mean(axis=1)
        keep = np.isfinite(shown).all(axis=1) & (pane <= 0.1)
        rows.append((shown[keep], cells(small).mean(axis=1)[keep], kind[keep]))
        rows[-1] += (np.full(keep.sum(), number),)
    shown, photo, kind, of = (np.concatenate(column) for column in zip(*rows, strict=True))
    medians = [
        np.median(photo[kind == k], axis=0) if (kind == k).any() else np.full(3, 0.2)
        for k in range(len(KINDS))
    ]
    flat = np.array(medians)[np.maximum(kind, 0)]
    ours, one = (fitted(colours, photo, kind, of) for colours in (shown, flat))
    print(f"{len(cameras)} photos\n\n| cells | n | house | one colour |\n|---|---|---|---|")
    groups = {name: kind == k for k, name in enumerate(KINDS) if k}
    groups |= {"surfaces": np.isin(kind, (1, 2, 3)), "all": kind > -9}
    for name, chosen in groups.items():
        if chosen.any():
            means = f"{ours[chosen].mean():.2f} | {one[chosen].mean():.2f}"
            print(f"| {name} | {chosen.sum()} | {means} |")


if __name__ == "__main__":
    main()
