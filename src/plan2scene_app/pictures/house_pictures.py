"""Pictures of a textured house: from above, rooms at eye level, beside its photos, floors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from plan2scene.images import jpeg_bytes, write_png
from plan2scene.io import atomic_path
from plan2scene.mesh.assembly import assemble
from plan2scene.mesh.rays import Rays
from plan2scene.mesh.texture_files import textured
from plan2scene.photos.locate.pose import read_poses
from plan2scene.plans.scene_json import read_scene_json
from plan2scene_app.pictures.lit_picture import painter_of
from plan2scene_app.pictures.pattern_sheet import draw_patterns
from plan2scene_app.pictures.photo_views import render_photo_views
from plan2scene_app.pictures.preview import render_preview
from plan2scene_app.pictures.room_views import render_rooms

#: JPEG quality.
_QUALITY = 90


def draw_house(
    scene_json: str | Path,
    textures_dir: str | Path,
    preview: str | Path,
    rooms: str | Path,
    views: str | Path,
    floors: str | Path,
    *,
    house_id: str,
    photos: Mapping[str, Path],
    cameras: str | Path | None,
    patterns: str | Path | None,
    objects: bool = True,
    traced: bool = False,
    threads: int = 1,
) -> None:
    """Write pictures of a house: from above (PNG); rooms, photo views and floors (JPEG).

    Parameters
    ----------
    preview, rooms, views, floors : path
        Outputs of :mod:`.preview`, :mod:`.room_views`, :mod:`.photo_views`, :mod:`.pattern_sheet`.
    photos : mapping of str to path
        Photos by name.
    cameras : path or None
        ``cameras.json``; None if no photo was read.
    patterns : path or None
        ``patterns.parquet``; None if floors are not laid.
    traced : bool
        Whether rooms and views are drawn by path tracing, if Mitsuba is installed.
    threads : int
        Number of views drawn in parallel; with `traced` only one, as Mitsuba has its own threads.

    Other parameters are those of :func:`plan2scene.mesh.build.build_house`.
    """
    house, textures = textured(textures_dir, read_scene_json(scene_json, house_id))
    house = house if objects else replace(house, icons=())
    built = assemble(house)
    write_png(preview, render_preview(house, textures, built))
    painter = painter_of(house, textures, built.parts, traced=traced)
    poses = {} if cameras is None else read_poses(cameras)
    sheets = {
        rooms: render_rooms(house, Rays.of(built.parts), painter),
        views: render_photo_views(house, photos, poses, painter, 1 if traced else threads),
        floors: draw_patterns(house, patterns),
    }
    for output, sheet in sheets.items():
        with atomic_path(output) as temporary:
            temporary.write_bytes(jpeg_bytes(sheet, quality=_QUALITY))
