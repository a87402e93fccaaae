"""Files from strangers: what is read, what is refused, and that writes are all or nothing."""

import io

import numpy as np
import pandas as pd
import pytest
from PIL import Image

from plan2scene import images
from plan2scene import io as p2s_io
from plan2scene.errors import InputError


def picture(mode: str) -> Image.Image:
    values = np.arange(48, dtype=np.uint8).reshape(4, 4, 3)
    return Image.fromarray(values).convert(mode)


@pytest.mark.parametrize("mode", ["RGB", "L", "P", "1", "RGBA", "LA", "CMYK", "YCbCr"])
def test_every_mode_becomes_rgb(tmp_path, mode):
    suffix = "tif" if mode in ("CMYK", "YCbCr") else "png"
    path = tmp_path / f"x.{suffix}"
    picture(mode).save(path)
    image = images.read_image(path)
    assert image.shape == (4, 4, 3)
    assert image.dtype == np.uint8


def test_16_bit_keeps_its_brightness(tmp_path):
    path = tmp_path / "x.png"
    Image.fromarray(np.full((2, 2), 32768, dtype=np.uint16)).save(path)
    assert np.all(images.read_image(path) == 128)


def test_transparent_pixels_are_white(tmp_path):
    path = tmp_path / "x.png"
    Image.new("RGBA", (2, 2), (255, 0, 0, 0)).save(path)
    assert np.all(images.read_image(path) == 255)


def test_exif_rotation_is_applied(tmp_path):
    path = tmp_path / "x.jpg"
    exif = Image.Exif()
    exif[0x0112] = 6
    Image.new("RGB", (8, 4)).save(path, exif=exif)
    assert images.read_image(path).shape == (8, 4, 3)


def damaged() -> dict[str, bytes]:
    buffer = io.BytesIO()
    Image.fromarray(np.random.default_rng(0).integers(0, 255, (64, 64, 3), np.uint8)).save(
        buffer, format="JPEG"
    )
    whole = buffer.getvalue()
    return {
        "truncated.jpg": whole[: len(whole) // 2],
        "text.jpg": b"not an image",
        "empty.jpg": b"",
        "header.png": b"\x89PNG\r\n\x1a\n" + b"\0" * 40,
    }


@pytest.mark.parametrize("name", sorted(damaged()))
def test_what_is_no_image_gives_one_line(tmp_path, name):
    path = tmp_path / name
    path.write_bytes(damaged()[name])
    with pytest.raises(InputError) as error:
        images.read_image(path, house_id="h")
    text = str(error.value)
    assert name in text and "house h" in text and "expected" in text and "\n" not in text


def test_too_many_pixels_are_refused_before_decoding(tmp_path, monkeypatch):
    monkeypatch.setattr(images, "MAX_PIXELS", 99)
    path = tmp_path / "x.png"
    Image.new("RGB", (10, 10)).save(path)
    with pytest.raises(InputError, match="10x10"):
        images.read_image(path)


@pytest.mark.parametrize(
    "name", ["../x.jpg", "/etc/passwd", "a/../../x", "", " x", "a\\b", "C:x", "a\nb", "./x", "a//b"]
)
def test_names_that_leave_the_folder_are_refused(tmp_path, name):
    with pytest.raises(InputError):
        p2s_io.safe_join(tmp_path, name)


def test_plain_names_are_joined(tmp_path):
    assert p2s_io.safe_join(tmp_path, "Küche 1.jpg") == tmp_path / "Küche 1.jpg"
    assert p2s_io.safe_join(tmp_path, "sub/x.jpg") == tmp_path / "sub" / "x.jpg"


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path):
    path = tmp_path / "x.txt"
    path.write_text("old")
    with pytest.raises(RuntimeError), p2s_io.atomic_path(path) as temporary:
        temporary.write_text("half")
        raise RuntimeError
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_directory_is_replaced_as_a_whole(tmp_path):
    target = tmp_path / "d"
    target.mkdir()
    (target / "stale").write_text("")
    with p2s_io.atomic_directory(target) as temporary:
        (temporary / "new").write_text("")
    assert [p.name for p in target.iterdir()] == ["new"]
    assert [p.name for p in tmp_path.iterdir()] == ["d"]


def test_parquet_round_trip_with_metadata(tmp_path):
    frame = pd.DataFrame({"a": [1, 2], "v": [[0.5, 1.0], [2.0]]})
    p2s_io.write_parquet(tmp_path / "x.parquet", frame, {"house": "h"})
    back, metadata = p2s_io.read_parquet(tmp_path / "x.parquet")
    assert metadata == {"schema_version": 1, "house": "h"}
    assert [list(v) for v in back["v"]] == [[0.5, 1.0], [2.0]]


def test_foreign_parquet_is_refused(tmp_path):
    pd.DataFrame({"a": [1]}).to_parquet(tmp_path / "x.parquet")
    with pytest.raises(InputError):
        p2s_io.read_parquet(tmp_path / "x.parquet")


def test_png_bytes_round_trip():
    image = np.arange(48, dtype=np.uint8).reshape(4, 4, 3)
    assert np.array_equal(images.image_from_bytes(images.png_bytes(image)), image)
    assert images.png_bytes(image) == images.png_bytes(image.copy())


def test_deep_json_is_one_line(tmp_path):
    path = tmp_path / "x.json"
    path.write_text("[" * 200_000)
    with pytest.raises(InputError):
        p2s_io.read_json(path)
