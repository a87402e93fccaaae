"""The texture sheet: a picture of a house's reference crops and each method's tiles, 2 x 2."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from plan2scene.evaluation.references import reference_images
from plan2scene.house import SURFACES, SurfaceKey
from plan2scene.images import metric_image, read_image
from plan2scene.io import atomic_path, read_parquet
from plan2scene.mesh.texture_files import texture_index
from plan2scene.metrics.color_freq_tile import color_distance
from plan2scene_app.drawing import INK, PAPER, font

_CELL, _GAP, _LABEL, _HEAD, _CAPTION = 192, 8, 132, 26, 16
_PALE = (225, 225, 225)


@dataclass(frozen=True, eq=False)
class SheetRow:
    """A surface on a sheet: lines of text for its row, and (s, s, 3) uint8 tiles by method.

    `reference` (s, s, 3) uint8 is the crop with which metrics compare the tiles; None if no photo
    shows the surface.
    """

    title: tuple[str, ...]
    reference: np.ndarray | None
    tiles: Mapping[str, np.ndarray]

    def color(self, method: str) -> float:
        """Return COLOR of a method's tile against the reference; NaN without one."""
        if self.reference is None:
            return float("nan")
        tile, reference = metric_image(self.tiles[method]), metric_image(self.reference)
        return color_distance(tile, reference)


def sheet_rows(textures: Mapping[str, str | Path], crops: str | Path) -> dict[SurfaceKey, SheetRow]:
    """Return a row for each surface of a house, room by room.

    `textures` maps a method to its output folder of the texture stage; `crops` is the house's
    ``crops.parquet``.
    """
    references = reference_images(read_parquet(crops)[0], [])
    listed = texture_index(next(iter(textures.values())))
    rows = {}
    for name, entry in sorted(listed.items(), key=lambda item: _order(item[0])):
        key = SurfaceKey(*name.rsplit("/", 1))
        visible, of_all_crops = references.get(key, (None, None))
        tiles = {
            method: read_image(Path(folder) / f"{key.filename}.png")
            for method, folder in textures.items()
        }
        observed = "observed" if entry.get("observed") else "not observed"
        shared = [f"material {entry['material']}"] if "material" in entry else []
        title = (key.room_id, key.surface, str(entry["substance"]), observed, *shared)
        rows[key] = SheetRow(title, of_all_crops if visible is None else visible, tiles)
    return rows


def _order(name: str) -> tuple[str, int]:
    """Return a key that sorts names ``room/surface`` by room, then floor, wall, ceiling."""
    room, surface = name.rsplit("/", 1)
    return room, SURFACES.index(surface)


def write_texture_sheet(
    output: str | Path, textures: Mapping[str, str | Path], crops: str | Path, *, house: str
) -> None:
    """Write a house's sheet as PNG; for the parameters see :func:`sheet_rows`."""
    rows = list(sheet_rows(textures, crops).values())
    page = draw_sheet(f"{house}: tiles, each twice in both directions", rows)
    with atomic_path(output) as temporary:
        page.save(temporary, format="PNG", compress_level=4)


def draw_sheet(title: str, rows: Sequence[SheetRow]) -> Image.Image:
    """Return a picture of rows: the reference crop, then each method's tile with its COLOR."""
    methods = list(rows[0].tiles) if rows else []
    step = _CELL + _GAP
    width = _LABEL + (len(methods) + 1) * step + _GAP
    height = 2 * _HEAD + len(rows) * (step + _CAPTION) + _GAP
    page = Image.new("RGB", (width, height), PAPER)
    draw = ImageDraw.Draw(page)
    draw.text((_GAP, 5), title, font=font(15), fill=INK)
    for column, name in enumerate(["reference crop", *methods]):
        draw.text((_LABEL + column * step, _HEAD + 5), name, font=font(13), fill=INK)
    for index, row in enumerate(rows):
        top = 2 * _HEAD + index * (step + _CAPTION)
        draw.text((_GAP, top), "\n".join(row.title), font=font(12), fill=INK)
        _paste(page, (_LABEL, top), row.reference, 1)
        for column, (method, tile) in enumerate(row.tiles.items(), start=1):
            corner = (_LABEL + column * step, top)
            _paste(page, corner, tile, 2)
            color = row.color(method)
            if np.isfinite(color):
                text = f"COLOR {color:.2f}"
                draw.text((corner[0], top + _CELL + 1), text, font=font(11), fill=INK)
    return page


def _paste(
    page: Image.Image, corner: tuple[int, int], image: np.ndarray | None, times: int
) -> None:
    """Paste an image, repeated `times` in both directions, into a cell; a pale field for None."""
    if image is None:
        page.paste(_PALE, (*corner, corner[0] + _CELL, corner[1] + _CELL))
        return
    repeated = Image.fromarray(np.tile(image, (times, times, 1)))
    page.paste(repeated.resize((_CELL, _CELL), Image.Resampling.BOX), corner)
