import io
import shutil

import numpy as np
import pytest
from PIL import Image
from places import PLAN

from plan2scene.errors import InputError
from plan2scene.photos.camera.exif import read_exif_focal
from plan2scene_app.check import check_dataset
from plan2scene_app.cli import cut_views
from plan2scene_app.panoramas import Panorama, cut_panoramas, panorama_of, views_of
from plan2scene_app.run import SingleHouse, read_input

HEADINGS, LINES = np.meshgrid((np.arange(1200) + 0.5) / 1200, (np.arange(600) + 0.5) / 600)


def sphere(path, columns=slice(None), xmp=None):
    """A photo whose colours tell heading (red, green: cosine, sine) and height (blue)."""
    turn = 2 * np.pi * HEADINGS
    flat = np.sin(np.pi * LINES)  # the poles show one point each
    pixels = 127.5 + 127.5 * np.stack([-np.cos(turn) * flat, -np.sin(turn) * flat, 2 * LINES - 1])
    image = Image.fromarray(np.moveaxis(pixels, 0, 2)[:, columns].astype(np.uint8))
    image.save(path, quality=95, **({"xmp": xmp} if xmp else {}))
    return path


def turned(red, green, heading):
    """Degrees from a heading to the one that a colour tells."""
    return (np.degrees(np.arctan2(green, red)) - heading + 180) % 360 - 180


def test_views_look_around_and_know_their_lens(tmp_path):
    path = sphere(tmp_path / "hall.jpg")
    assert panorama_of(path) == Panorama((600, 1200))
    views = cut_panoramas({"hall.jpg": path, "b.jpg": tmp_path / "none.jpg"}, tmp_path)
    assert [*views] == ["hall.jpg"] and len(views["hall.jpg"]) == 6
    beside = cut_panoramas({"hall.jpg": path, "hall_3.png": tmp_path / "none.png"}, tmp_path)
    assert [*beside["hall.jpg"]] == [f"hall_view_{number}.jpg" for number in range(1, 7)]
    for number, file in enumerate(views["hall.jpg"].values()):
        image = np.asarray(Image.open(file)).astype(float)
        height, width = image.shape[:2]
        lens = read_exif_focal(file, (height, width))
        assert lens.told and lens.focal_px == pytest.approx(width / 2, rel=0.01)
        red, green, blue = (image / 127.5 - 1)[height // 2, width // 2]
        assert turned(red, green, 60 * number) == pytest.approx(0, abs=2)
        assert 90 * blue == pytest.approx(10, abs=2)  # degrees below the horizon
        red, green, _ = (image / 127.5 - 1)[height // 2, -1]
        assert turned(red, green, 60 * number + 45.4) == pytest.approx(0, abs=2)


def test_the_command_writes_views_and_no_others(tmp_path, capsys):
    path = sphere(tmp_path / "hall.jpg")
    cut_views([path], tmp_path / "out")
    assert capsys.readouterr().out.split()[0] == str(tmp_path / "out" / "hall_1.jpg")
    for photo, found in ((path, "such a file"), (tmp_path / "out" / "hall_2.jpg", "a flat one")):
        with pytest.raises(InputError, match=f"found {found}"):
            cut_views([photo], tmp_path / "out")


def test_a_check_tells_of_a_panorama_in_a_table(tmp_path):
    shutil.copy(PLAN, tmp_path / "plan.json")
    (tmp_path / "photos").mkdir()
    sphere(tmp_path / "photos" / "hall.jpg")
    (tmp_path / "p.csv").write_text("room_id,photo\nhall,hall.jpg\n")
    row = "house\tsplit\tplan\tassignment\tphotos\nh\ttest\tplan.json\tp.csv\thall.jpg\n"
    (tmp_path / "houses.tsv").write_text(row)
    (problem,) = check_dataset(tmp_path)
    assert "plan2scene views cuts others), found a 360-degree one" in str(problem)


def test_a_part_of_a_sphere_gives_the_views_that_it_shows(tmp_path):
    names = "FullPanoWidthPixels", "FullPanoHeightPixels", "CroppedAreaLeftPixels"
    told = zip((*names, "CroppedAreaImageWidthPixels"), (2400, 1200, 800, 1000), strict=True)
    xmp = 'GPano:ProjectionType="equirectangular"' + "".join(f' GPano:{n}="{v}"' for n, v in told)
    path = sphere(tmp_path / "part.jpg", slice(400, 900), xmp.encode())
    panorama = panorama_of(path)
    assert panorama == Panorama((600, 1200), left=400)
    (first,) = (np.asarray(Image.open(io.BytesIO(v))) for v in views_of(path, panorama))
    red, green, _ = first[first.shape[0] // 2, first.shape[1] // 2] / 127.5 - 1
    assert turned(red, green, 0) == pytest.approx(0, abs=2)


def test_a_strip_without_a_whole_view_is_left_out(tmp_path, caplog):
    xmp = b'GPano:ProjectionType="equirectangular" GPano:FullPanoWidthPixels="1200"'
    xmp += b' GPano:FullPanoHeightPixels="600" GPano:CroppedAreaLeftPixels="300"'
    sphere(tmp_path / "strip.jpg", slice(300, 500), xmp)
    sphere(tmp_path / "flat.jpg", slice(100, 900))
    asked = SingleHouse(PLAN, None, tmp_path, "h", "exemplar", None, 0, 128)
    assert read_input(asked) == ["flat.jpg"]
    assert "strip.jpg, house h: expected a panorama that shows 90 degrees" in caplog.text


def test_flat_photos_are_none_and_wide_ones_without_angles_are_told(tmp_path):
    sphere(tmp_path / "flat.jpg", slice(100, 900))
    Image.fromarray(np.arange(720_000).reshape(600, 1200).astype(np.uint8)).save(tmp_path / "b.png")
    page = Image.new("RGB", (1200, 600), "white")  # a drawing closes, too: its edges are paper
    page.paste("black", (200, 200, 900, 220))
    page.save(tmp_path / "page.png")
    for name in ("flat.jpg", "b.png", "page.png"):
        assert panorama_of(tmp_path / name) is None
    Image.new("RGB", (900, 300)).save(tmp_path / "wide.png")
    with pytest.raises(InputError, match="a panorama without angles"):
        panorama_of(tmp_path / "wide.png")
