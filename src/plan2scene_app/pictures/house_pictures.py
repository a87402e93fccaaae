"""Pictures of a textured house: its preview, and its rooms at eye level."""

from __future__ import annotations

from pathlib import Path

from plan2scene.images import jpeg_bytes, write_png
from plan2scene.io import atomic_path
from plan2scene.mesh.assembly import assemble
from plan2scene.mesh.build import textured_house
from plan2scene_app.pictures.preview import render_preview
from plan2scene_app.pictures.room_views import render_rooms


def draw_preview(
    scene_json: str | Path,
    textures_dir: str | Path,
    output: str | Path,
    *,
    house_id: str,
    objects: bool = True,
) -> None:
    """Write a PNG of the house from above and at a slant (:mod:`plan2scene_app.pictures.preview`).

    Parameters as of :func:`plan2scene.mesh.build.build_house`.
    """
    house, textures = textured_house(scene_json, textures_dir, house_id, objects=objects)
    write_png(output, render_preview(house, textures, assemble(house)))


def draw_rooms(
    scene_json: str | Path,
    textures_dir: str | Path,
    output: str | Path,
    *,
    house_id: str,
    objects: bool = True,
    traced: bool = False,
) -> None:
    """Write a JPEG of each room as seen by a person in it.

    `traced`: by path tracing, where Mitsuba is installed. Other parameters as of
    :func:`plan2scene.mesh.build.build_house`.
    """
    house, textures = textured_house(scene_json, textures_dir, house_id, objects=objects)
    pictures = render_rooms(house, textures, assemble(house).parts, traced=traced)
    with atomic_path(output) as temporary:
        temporary.write_bytes(jpeg_bytes(pictures, quality=90))
