import numpy as np
from views import camera_looking

from plan2scene.colour import srgb_to_linear
from plan2scene.house import SurfaceKey
from plan2scene.paint.observations import read_colours, write_colours
from plan2scene.photos.crops.colours import colours_of_photo, surface_colours
from plan2scene.photos.crops.filter import strong_edges
from plan2scene.photos.planes.planes import PhotoPlane, Plane

SIZE = (120, 160)


def test_colours_of_hidden_photos_are_not_read(tmp_path):
    camera = camera_looking(SIZE, heading_deg=0.0, pitch_deg=35.0, focal=110.0)
    mask = np.zeros(SIZE, bool)
    mask[60:] = True
    image = np.full((*SIZE, 3), 128, np.uint8)
    planes = [PhotoPlane(("a", "b"), Plane("floor", 0, (0.0, 1.0, 0.0), -1.5, mask, "plan"))]
    seen = [
        item
        for photo in ("p.jpg", "q.jpg")
        for item in colours_of_photo(image, camera, planes, photo, [mask])
    ]
    write_colours(tmp_path / "colours.parquet", seen, dataset="d", house_id="h")
    found = read_colours(tmp_path / "colours.parquet", ["p.jpg"])
    assert set(found) == {SurfaceKey("a", "floor"), SurfaceKey("b", "floor")}
    ((photo, weight, colours),) = found[SurfaceKey("a", "floor")]
    assert photo == "q.jpg" and weight == seen[0].weight
    np.testing.assert_array_equal(colours, seen[0].colours)
    write_colours(tmp_path / "colours.parquet", [], dataset="d", house_id="h")
    assert read_colours(tmp_path / "colours.parquet", []) == {}


def test_surface_colours_leave_lamps_and_specks_aside():
    image = np.full((240, 320, 3), 128, np.uint8)
    labels = np.zeros((240, 320), np.uint8)
    labels[:120] = 3
    image[:120] = (180, 170, 160)
    image[20:60, 20:60] = 255
    labels[200:204, 10:14] = 1
    found = surface_colours(image, labels, "a.png", ["r1", "r2"], strong_edges(image))
    assert {(item.room_id, item.surface) for item in found} == {
        ("r1", "ceiling"),
        ("r2", "ceiling"),
    }
    expected = srgb_to_linear(np.array([180, 170, 160], np.uint8))
    np.testing.assert_allclose(found[0].colour, expected, atol=1e-6)
