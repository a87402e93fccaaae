"""A house with odd and damaged photos: the run goes on, and each photo left out is named."""

import json
import struct
import zlib
from pathlib import Path

import pytest
from clones import DEMO, Clone, demo_rows, make_clone, photos_of, write_table
from PIL import Image

from plan2scene.io import read_parquet

#: name of a photo that must be left out: a word of its line
BAD = {
    "bomb.png": "found 3600000000",
    "cut.jpg": "decodes",
    "empty.jpg": "an empty file",
    "phone.jpg": "HEIF",
    "point.png": "found 1x1",
    "strip.png": "found 20000x10",
    "text.jpg": "found text",
}


def odd_copies(photos: list[Path]) -> None:
    """Replace photos by the same pictures: CMYK, turned by EXIF, a palette, grey with 16 bits."""
    first, second, third, fourth = photos[:4]
    Image.open(first).convert("CMYK").save(first, format="JPEG", quality=92)
    exif = Image.Exif()
    exif[0x0112] = 6
    upright = Image.open(second).convert("RGB")
    upright.transpose(Image.Transpose.ROTATE_90).save(second, "JPEG", quality=92, exif=exif)
    Image.open(third).convert("P", palette=Image.Palette.ADAPTIVE).save(third, format="PNG")
    grey = Image.open(fourth).convert("L").convert("I").point(lambda value: value * 257)
    grey.convert("I;16").save(fourth, format="PNG")


def damaged(folder: Path, good: Path) -> None:
    head = struct.pack(">IIBBBBB", 60000, 60000, 8, 2, 0, 0, 0)
    chunk = struct.pack(">I", 13) + b"IHDR" + head + struct.pack(">I", zlib.crc32(b"IHDR" + head))
    body = struct.pack(">I", 0) + b"IDAT"
    (folder / "bomb.png").write_bytes(b"\x89PNG\r\n\x1a\n" + chunk + body)
    (folder / "cut.jpg").write_bytes(good.read_bytes()[:3000])
    (folder / "empty.jpg").write_bytes(b"")
    (folder / "phone.jpg").write_bytes(b"\0\0\0\x18ftypheic\0\0\0\0mif1heic")
    Image.new("RGB", (1, 1)).save(folder / "point.png")
    Image.new("RGB", (20000, 10)).save(folder / "strip.png")
    (folder / "text.jpg").write_text("the kitchen")


@pytest.fixture(scope="session")
def odd(tmp_path_factory) -> tuple[Clone, str, list[str]]:
    """Run the photo stages of a house with such photos; return (clone, output, good photos)."""
    row = next(row for row in demo_rows() if len(photos_of(row)) >= 4)
    good = photos_of(row)[:4]
    clone = make_clone(tmp_path_factory.mktemp("odd") / "clone", [row])
    folder = clone.root / "data" / "photos"
    damaged(folder, folder / good[0])
    odd_copies([folder / name for name in good])
    table = clone.root / "data" / row["assignment"]
    room = table.read_text().splitlines()[1].split(",")[0]
    table.write_text(table.read_text() + "".join(f"{room},{name}\n" for name in BAD))
    write_table(clone.root / "data", [row | {"photos": "|".join([*photos_of(row), *BAD])}])
    house = f"results/tiny/houses/{row['house']}"
    run = clone.snakemake("--", f"{house}/crops.parquet", f"{house}/contact_sheet.png")
    assert run.returncode == 0, run.stdout[-4000:]
    return clone, run.stdout, good


def folder_of(clone: Clone) -> Path:
    return clone.root / "results" / "tiny" / "houses" / clone.houses()[0]


@pytest.mark.parametrize("name", sorted(BAD))
def test_a_photo_that_cannot_be_used_is_one_line(odd, name):
    clone, output, _ = odd
    lines = json.loads((folder_of(clone) / "masks" / "warnings.json").read_text())
    fitting = [line for line in lines if f"photo {name} " in line]
    assert len(fitting) == 1, lines
    assert BAD[name] in fitting[0]
    assert "expected" in fitting[0]
    assert fitting[0] in output  # where the user looks
    assert "Traceback" not in output


def test_odd_photos_are_used_like_others(odd):
    clone, _, good = odd
    cameras = json.loads((folder_of(clone) / "masks" / "cameras.json").read_text())
    assert set(good) <= set(cameras)
    assert not set(BAD) & set(cameras)
    for name in good:
        with Image.open(DEMO / "photos" / name) as image:
            assert (cameras[name]["width"], cameras[name]["height"]) == image.size
    crops, _ = read_parquet(folder_of(clone) / "crops.parquet")
    assert set(good) & set(crops["photo"])
    assert not set(BAD) & set(crops["photo"])


def test_the_contact_sheet_shows_them_all(odd):
    clone, _, good = odd
    with Image.open(folder_of(clone) / "contact_sheet.png") as sheet:
        assert sheet.size[1] > 200 * (len(good) + len(BAD))
