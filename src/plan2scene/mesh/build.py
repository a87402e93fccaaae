"""The house stage: scene.json and a folder of textures in, a textured 3D house out."""

from __future__ import annotations

import logging
from dataclasses import replace
from pathlib import Path

from plan2scene.house import House, SurfaceKey
from plan2scene.images import jpeg_bytes, write_png
from plan2scene.io import atomic_path
from plan2scene.mesh.glb import write_glb
from plan2scene.mesh.house_mesh import assemble
from plan2scene.mesh.preview import render_preview
from plan2scene.mesh.room_views import render_rooms
from plan2scene.mesh.textures import TileTexture, textured
from plan2scene.parallel import each
from plan2scene.plans import read_scene_json, write_scene_json


def _load(
    scene_json: str | Path, textures_dir: str | Path, house_id: str
) -> tuple[House, dict[SurfaceKey, TileTexture]]:
    """Return a normalised plan and the textures that a method left for it."""
    return textured(textures_dir, read_scene_json(scene_json, house_id))


def build_house(
    scene_json: str | Path,
    textures_dir: str | Path,
    glb: str | Path,
    textured_scene_json: str | Path,
    preview: str | Path,
    rooms: str | Path,
    *,
    house_id: str,
    objects: bool = True,
    relief: bool = True,
    traced: bool = False,
    threads: int = 1,
) -> None:
    """Write a house as GLB, as scene.json with textures in the official form, and as pictures.

    Parameters
    ----------
    scene_json : path
        The normalised plan.
    textures_dir : path
        A method's tiles with ``textures.json``; surfaces without one get a plain colour.
    glb, textured_scene_json, preview : path
        Outputs; the preview is a PNG, see :func:`~plan2scene.mesh.preview.render_preview`.
    rooms : path
        Output: a JPEG, see :func:`~plan2scene.mesh.room_views.render_rooms`.
    house_id : str
    objects : bool
        Whether the plan's fixed objects are shown (:mod:`plan2scene.mesh.objects`).
    relief : bool
        Whether surfaces of the GLB have normal maps (:mod:`plan2scene.mesh.relief`).
    traced : bool
        Whether rooms are drawn by path tracing, where Mitsuba is installed.
    threads : int
        Of model and pictures, how many are made at a time.
    """
    house, textures = _load(scene_json, textures_dir, house_id)
    shown = house if objects else replace(house, icons=())
    assembly = assemble(shown)

    def write_model() -> None:
        write_glb(shown, textures, glb, assembly.parts, relief=relief)
        plain = {key: (tile.png, tile.size_m) for key, tile in textures.items()}
        write_scene_json(house, textured_scene_json, plain)

    def write_preview() -> None:
        write_png(preview, render_preview(shown, textures, assembly))

    def write_rooms() -> None:
        pictures = render_rooms(shown, textures, assembly.parts, traced=traced)
        with atomic_path(rooms) as temporary:
            temporary.write_bytes(jpeg_bytes(pictures, quality=90))

    for _ in each(lambda write: write(), (write_model, write_preview, write_rooms), threads):
        pass
    logging.getLogger("plan2scene").info(
        "house %s: %d rooms, %d parts, %d triangles, %d textures",
        house_id,
        len(house.rooms),
        len(assembly.parts),
        sum(len(part.mesh.faces) for part in assembly.parts),
        len(textures),
    )
