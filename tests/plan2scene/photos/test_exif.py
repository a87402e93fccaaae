import numpy as np
import pytest
from PIL import ExifTags, Image

from plan2scene.photos.camera.exif import ExifFocal, read_exif_focal

SIZE = (300, 400)
Tag = ExifTags.Base
EQUIVALENT = Tag.FocalLengthIn35mmFilm


def photo(path, tags, size=SIZE, orientation=1):
    exif = Image.Exif()
    exif[Tag.Orientation] = orientation
    exif.get_ifd(ExifTags.IFD.Exif).update(tags)
    Image.new("RGB", (size[1], size[0]), (90, 120, 150)).save(path, exif=exif)
    return path


@pytest.mark.parametrize(
    ("name", "orientation", "size"),
    [("a.jpg", 1, SIZE), ("a.webp", 1, SIZE), ("a.jpg", 6, SIZE[::-1])],
)
def test_equivalent_is_by_the_diagonal_whichever_way_up(tmp_path, name, orientation, size):
    tags = {EQUIVALENT: 26, Tag.ExifImageWidth: 4000, Tag.ExifImageHeight: 3000}
    found = read_exif_focal(photo(tmp_path / name, tags, orientation=orientation), size)
    assert found == ExifFocal(pytest.approx(26 / np.hypot(36, 24) * 500, rel=1e-4))


@pytest.mark.parametrize("equivalent", [2, 900])
def test_absurd_values_are_refused_with_a_line(tmp_path, equivalent):
    found = read_exif_focal(photo(tmp_path / "a.jpg", {EQUIVALENT: equivalent}), SIZE)
    assert found.focal_px is None and f"{equivalent} mm not used" in found.warning


def test_what_tells_no_lens_never_raises(tmp_path):
    (tmp_path / "text.jpg").write_text("no photo")
    Image.new("RGB", (4, 4)).save(tmp_path / "a.png")
    for name in ("text.jpg", "a.png", "missing.jpg"):
        assert read_exif_focal(tmp_path / name, SIZE) == ExifFocal()
