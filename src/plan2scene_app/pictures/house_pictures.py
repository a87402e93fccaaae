"""Pictures of a textured house: its preview, and its rooms at eye level."""

from __future__ import annotations

from pathlib import Path

from plan2scene.images import jpeg_bytes, write_png
from plan2scene.io import atomic_path
from plan2scene.mesh.assembly import assemble
from plan2scene.mesh.build import textured_house
from plan2scene_app.pictures.preview import render_preview
from plan2scene_app.pictures.room_views import render_rooms


def draw_house(
    scene_json: str | Path,
    textures_dir: str | Path,
    preview: str | Path,
    rooms: str | Path,
    *,
    house_id: str,
    objects: bool = True,
    traced: bool = False,
) -> None:
    """Write a PNG of the house from above and at a slant, and a JPEG of each room at eye level.

    `traced`: the rooms by path tracing, where Mitsuba is installed. Other parameters as of
    :func:`plan2scene.mesh.build.build_house`.
    """
    house, textures = textured_house(scene_json, textures_dir, house_id, objects=objects)
    built = assemble(house)
    write_png(preview, render_preview(house, textures, built))
    pictures = render_rooms(house, textures, built.parts, traced=traced)
    with atomic_path(rooms) as temporary:
        temporary.write_bytes(jpeg_bytes(pictures, quality=90))
