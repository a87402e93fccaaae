import io
import sys

import numpy as np
import pytest
from PIL import Image

from plan2scene.mesh.assembly import assemble
from plan2scene.mesh.baking import bake_occlusion

pytest.importorskip("embreex")


@pytest.fixture
def baked(gap_house):
    """Return the parts of a house by name, its occlusion, and that as numbers in [0, 1]."""
    parts = assemble(gap_house).parts
    flat = [part for part in parts if part.surface is not None]
    occlusion = bake_occlusion(parts, flat)
    image = np.asarray(Image.open(io.BytesIO(occlusion.png)))
    return {part.name: part for part in flat}, occlusion, image / 255


def occlusion_at(baked, name, point):
    parts, occlusion, image = baked
    part = parts[name]
    known = np.column_stack([part.mesh.vertices, np.ones(len(part.mesh.vertices))])
    to_uv, *_ = np.linalg.lstsq(known, occlusion.uv[name], rcond=None)
    u, v = np.array([*point, 1.0]) @ to_uv
    return image[int(v * image.shape[0]), int(u * image.shape[1])]


def test_open_floor_is_free_and_corners_are_dark(baked):
    assert occlusion_at(baked, "a/floor", (1.5, 0.0, 2.0)) > 0.97
    beside_wall = occlusion_at(baked, "a/floor", (0.05, 0.0, 2.0))
    corner = occlusion_at(baked, "a/floor", (0.05, 0.0, 0.05))
    assert 0.45 < beside_wall < 0.7 and 0.2 < corner < beside_wall - 0.1


def test_parts_have_places_of_their_own(baked):
    parts, occlusion, image = baked
    assert occlusion.uv.keys() == parts.keys()
    taken = np.zeros(image.shape, int)
    for uv in occlusion.uv.values():
        assert uv.min() >= 0 and uv.max() <= 1
        (left, top), (right, bottom) = uv.min(0), uv.max(0)
        rows = slice(round(top * image.shape[0]), int(np.ceil(bottom * image.shape[0] - 1e-6)))
        columns = slice(round(left * image.shape[1]), int(np.ceil(right * image.shape[1] - 1e-6)))
        taken[rows, columns] += 1
    assert taken.max() == 1


def test_without_a_ray_tracer_there_is_none(gap_house, monkeypatch, caplog):
    monkeypatch.setitem(sys.modules, "embreex.rtcore_scene", None)
    parts = assemble(gap_house).parts
    assert bake_occlusion(parts, parts[:1]) is None and "no occlusion" in caplog.text
    assert bake_occlusion(parts, []) is None
