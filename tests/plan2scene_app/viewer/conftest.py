from dataclasses import replace

import numpy as np
import pytest
from sample_houses import one_room

from plan2scene.house import Opening, SurfaceKey
from plan2scene.images import png_bytes
from plan2scene.mesh.glb import write_glb
from plan2scene.mesh.texture_files import TileTexture


def checks(first, second):
    rows, columns = np.indices((64, 64)) // 8
    image = np.where(((rows + columns) % 2)[..., None] == 0, first, second).astype(np.uint8)
    return png_bytes(image)


@pytest.fixture
def small_house():
    window = Opening("win", "window", 1.0, 2.5, 0.9, 2.0)
    return replace(one_room("Bedroom", 4.0, 3.0, {0: [window]}, "r"), id="small")


@pytest.fixture
def small_glb(small_house, tmp_path):
    textures = {
        SurfaceKey("r", "floor"): TileTexture(checks((220, 20, 20), (20, 20, 220)), 1.0, True),
        SurfaceKey("r", "wall"): TileTexture(checks((10, 160, 10), (10, 90, 10)), 1.0, False),
    }
    path = tmp_path / "house.glb"
    write_glb(small_house, textures, path)
    return path
