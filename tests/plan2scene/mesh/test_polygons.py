"""Triangulation: areas, holes, faults."""

import numpy as np
import pytest
from shapely.geometry import MultiPolygon, Polygon, box

from plan2scene.mesh.polygons import signed_areas, triangulate


def test_random_stars_keep_their_area_and_turn():
    rng = np.random.default_rng(3)
    for _ in range(30):
        angle = np.sort(rng.uniform(0, 2 * np.pi, 12))
        radius = rng.uniform(0.5, 4.0, 12)
        star = Polygon(np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1))
        if not star.is_valid:
            continue
        points, faces = triangulate(star)
        areas = signed_areas(points, faces)
        assert (areas > 0).all()
        assert areas.sum() == pytest.approx(star.area, rel=1e-9)


def test_holes_and_several_parts():
    shape = MultiPolygon([box(0, 0, 4, 4).difference(box(1, 1, 2, 3)), box(6, 0, 7, 1)])
    points, faces = triangulate(shape)
    assert signed_areas(points, faces).sum() == pytest.approx(16 - 2 + 1)
    centres = points[faces].mean(axis=1)
    assert not any(1 < x < 2 and 1 < z < 3 for x, z in centres)


def test_nothing_gives_nothing():
    points, faces = triangulate(Polygon())
    assert points.shape == (0, 2)
    assert faces.shape == (0, 3)
