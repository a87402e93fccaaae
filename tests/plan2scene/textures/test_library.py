import numpy as np

from plan2scene.house import SUBSTANCES
from plan2scene.images import write_png
from plan2scene.textures.library import TextureLibrary, read_library, write_library


def _flat(*levels):
    tiles = np.stack([np.full((128, 128, 3), level, np.uint8) for level in levels])
    names = tuple(f"t{level}" for level in levels)
    return TextureLibrary(names, ("tile",) * len(levels), tiles, np.ones(len(levels)))


def test_nearest_has_the_nearest_colour():
    library = _flat(10, 100, 200, 250)
    assert library.nearest(np.full((128, 128, 3), 130, np.uint8)) == 1
    assert library.nearest(np.full((128, 128, 3), 255, np.uint8)) == 3
    twins = _flat(10, 100, 100)
    assert twins.nearest(np.full((128, 128, 3), 100, np.uint8)) == 1  # of equals the first


def test_generated_library_repeats_itself_and_covers_each_substance(tmp_path):
    for k in "ab":
        write_library(tmp_path / f"{k}.parquet", folder=None, per_substance=2, seed=5, size_px=64)
    assert (tmp_path / "a.parquet").read_bytes() == (tmp_path / "b.parquet").read_bytes()
    library = read_library(tmp_path / "a.parquet")
    assert [library.of_substance(name) for name in SUBSTANCES] == [[0, 1], [2, 3], [4, 5], [6, 7]]
    assert library.tiles.shape == (8, 64, 64, 3) and (library.size_m > 0.01).all()
    assert len(set(library.names)) == 8


def test_library_of_a_folder(tmp_path):
    image = np.random.default_rng(0).integers(0, 256, (128, 128, 3), dtype=np.uint8)
    write_png(tmp_path / "mine" / "carpet" / "rug.png", image)
    folder = str(tmp_path / "mine")
    write_library(tmp_path / "l.parquet", folder=folder, per_substance=9, seed=0, size_px=128)
    library = read_library(tmp_path / "l.parquet")
    assert library.substances == ("carpet",) and np.array_equal(library.tiles[0], image)
