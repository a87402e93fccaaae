import numpy as np
import pytest
from PIL import Image

from plan2scene import images
from plan2scene.errors import InputError
from plan2scene.photos import photo_files


@pytest.fixture
def small_limits(monkeypatch):
    monkeypatch.setattr(images, "MAX_PIXELS", 10_000)
    monkeypatch.setattr(photo_files, "MAX_SIDE", 100)


def picture(width=800, height=600):
    pixels = np.zeros((height, width, 3), np.uint8)
    pixels[:, : width // 4, 0] = 200
    pixels[..., 1] = np.linspace(40, 200, height)[:, None]
    return Image.fromarray(pixels)


@pytest.mark.parametrize("name", ["RGB.jpg", "RGB.png", "RGBA.png", "L.jpg", "CMYK.tif", "P.png"])
def test_a_large_photo_is_reduced(tmp_path, small_limits, monkeypatch, name):
    picture().convert(name.split(".")[0]).save(tmp_path / name)
    found = photo_files.read_photo(tmp_path / name)
    assert found.shape == (75, 100, 3)
    monkeypatch.setattr(images, "MAX_PIXELS", 10_000_000)
    whole = photo_files.read_photo(tmp_path / name)
    assert whole.shape == found.shape and np.abs(found.astype(int) - whole).mean() < 3


def test_what_cannot_be_reduced_as_it_is_read_is_one_line(tmp_path, small_limits, monkeypatch):
    Image.fromarray(np.full((600, 800), 900, np.uint16)).save(tmp_path / "a.png")
    with pytest.raises(InputError, match="mode I;16 of so many pixels"):
        photo_files.read_photo(tmp_path / "a.png")
    monkeypatch.setattr(images, "MAX_PHOTO_PIXELS", 20_000)
    with pytest.raises(InputError, match="at most 20000 pixels, found 800x600"):
        photo_files.read_photo(tmp_path / "a.png")
