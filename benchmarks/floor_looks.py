"""Draw each floor beside the photo that shows most of it, to compare them by eye.

python benchmarks/floor_looks.py HOUSE PHOTOS OUT          # OUT/{room_id}.png

HOUSE is results/{dataset}/houses/{house}. The house is drawn without light from the position of
the photo. If that is not known, it is drawn with the photo's focal length from 1.5 m above the
floor, along the longest direction of the room.
"""

import argparse
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from plan2scene.camera import Camera
from plan2scene.colour import linear_to_srgb
from plan2scene.house import Room
from plan2scene.images import read_image
from plan2scene.mesh.assembly import assemble
from plan2scene.mesh.texture_files import textured
from plan2scene.photos.locate.pose import read_poses
from plan2scene.photos.planes.planes import plane_of_row, read_planes
from plan2scene.plans.scene_json import read_scene_json
from plan2scene.stage_json import read_stage_json
from plan2scene_app.pictures.renderer import Triangles, look_at

HEIGHT_M, WIDTH = 1.5, 720
MARGIN = 0.05  #: share of the picture's height that is shown above the floor


def standing(camera: Camera, room: Room, lift: float) -> Camera:
    """Return the camera moved to one end of a room, looking along its longer side."""
    outline = np.array(room.rings[0])
    low, high = outline.min(axis=0), outline.max(axis=0)
    middle, long = 0.5 * (low + high), np.arange(2) == np.argmax(high - low)
    (x, z), (to_x, to_z) = middle - 0.45 * (high - low) * long, middle
    eye, target = np.array([x, lift + HEIGHT_M, z]), np.array([to_x, lift, to_z])
    return look_at(eye, target, camera.focal_px, (camera.height, camera.width))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("house", type=Path)
    parser.add_argument("photos", type=Path)
    parser.add_argument("out", type=Path)
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    scene = read_scene_json(given.house / "scene.json", given.house.name)
    house, textures = textured(given.house / "textures", replace(scene, icons=()))
    triangles = Triangles.of(assemble(house).parts, textures)
    poses = read_poses(given.house / "cameras.json")
    frames = read_stage_json(given.house / "masks/cameras.json", "cameras")
    best: dict[str, tuple[int, str, np.ndarray]] = {}
    for photo, rows in sorted(read_planes(given.house / "planes.parquet").items()):
        camera = Camera.from_json(frames[photo])
        for item in (plane_of_row(row, (camera.height, camera.width)) for row in rows):
            if item.plane.surface == "floor" and item.own:
                for room in item.rooms:
                    seen = int(item.plane.mask.sum()), photo, item.plane.mask
                    best[room] = max(best.get(room, (0, "", seen[2])), seen, key=lambda b: b[0])
    for room in house.rooms:
        if room.id not in best:
            continue
        _, name, mask = best[room.id]
        photo = read_image(given.photos / name)
        camera, lift = Camera.from_json(frames[name]), house.level_of(room.id).elevation
        if name in poses and poses[name].room_id == room.id:
            x, y, z = poses[name].position
            camera = replace(poses[name].camera, position=(x, y + lift, z))
        else:
            camera = standing(camera, room, lift)
        size = round(WIDTH * photo.shape[0] / photo.shape[1]), WIDTH
        camera = camera.resized(size)
        seen = triangles.visible(camera, np.ones(len(triangles.glass), dtype=bool))
        view = np.ones((size[0] * size[1], 3))
        view[seen.pixels] = triangles.looks(camera, seen)
        drawn = np.rint(255 * linear_to_srgb(np.clip(view, 0, 1))).reshape(*size, 3)
        small = cv2.resize(photo, size[::-1], interpolation=cv2.INTER_AREA)
        top = int(np.flatnonzero(mask.any(axis=1))[0] / mask.shape[0] * size[0])
        top = max(0, top - round(MARGIN * size[0]))
        pair = np.hstack([small[top:], drawn[top:].astype(np.uint8)])
        cv2.imwrite(str(given.out / f"{room.id}.png"), cv2.cvtColor(pair, cv2.COLOR_RGB2BGR))
        print(f"{room.id}: {name}{'' if camera.position[1] != lift + HEIGHT_M else ', from 1.5 m'}")


if __name__ == "__main__":
    main()
