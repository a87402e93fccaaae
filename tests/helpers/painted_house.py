import pandas as pd

from plan2scene.images import jpeg_bytes, read_image, write_png
from plan2scene.io import read_json, write_json, write_parquet
from plan2scene.paint.observations import write_colours
from plan2scene.paint.surfaces import write_paint
from plan2scene.textures.painted import paint_textures


def paint_of(folder, planes, **options):
    """Write what planes of photos show and the paint of that; return the paint's file."""
    files = [folder / f"{name}.parquet" for name in ("colours", "materials", "paint")]
    write_colours(files[0], planes, dataset="d", house_id="h")
    write_parquet(files[1], pd.DataFrame({"room_id": [], "surface": [], "material": []}), {})
    write_paint(*files, dataset="d", house="h", **options)
    return files[2]


def file_of(name):
    return name.replace("/", "_")


def textures_of(folder, tiles, **entry):
    folder.mkdir()
    usual = {"size_m": 1.0, "observed": True, "substance": "plaster", "source": "crops"}
    for name, tile in tiles.items():
        write_png(folder / f"{file_of(name)}.png", tile)
        (folder / f"{file_of(name)}.jpg").write_bytes(jpeg_bytes(tile, quality=95))
    index = {name: usual | entry.get(name, {}) for name in tiles}
    write_json(folder / "textures.json", {"method": "toy", "surfaces": index})
    whole = {"origin_m": [0.0, 0.0], "extent_m": [1.0, 1.0], "px_per_m": 64.0}
    write_json(folder / "maps.json", {"surfaces": dict.fromkeys(tiles, whole)})
    return folder


class Painted:
    """Tiles, painted: their pictures, entries and maps."""

    def __init__(self, paint, folder, tiles, entry=(), **options):
        self.folder = folder / "out"
        given = textures_of(folder / "t", tiles, **dict(entry))
        paint_textures(given, paint, self.folder, **options)
        files = (read_json(self.folder / f"{name}.json") for name in ("textures", "maps"))
        self.surfaces, self.maps = (file["surfaces"] for file in files)

    def tile(self, name):
        return read_image(self.folder / f"{file_of(name)}.png")
