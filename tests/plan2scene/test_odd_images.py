import io
import os
import struct
import subprocess
import sys
import zlib

import numpy as np
import pytest
from PIL import Image, ImageCms, features

from plan2scene import images
from plan2scene.errors import InputError
from plan2scene.images import read_image
from plan2scene_app import pdf

#: What is drawn: four flat quarters, no two alike however the picture is turned.
QUARTERS = ((200, 40, 30), (40, 160, 60), (30, 60, 190), (230, 220, 60))
WIDTH, HEIGHT = 48, 32
GREYS = (30, 90, 160, 240)


def drawn():
    """Return (32, 48, 3) uint8: quarters, row by row."""
    return in_quarters(np.array(QUARTERS, np.uint8))


def in_quarters(values):
    picture = np.zeros((HEIGHT, WIDTH, *values.shape[1:]), values.dtype)
    for k, value in enumerate(values):
        row, column = divmod(k, 2)
        picture[row * 16 : row * 16 + 16, column * 24 : column * 24 + 24] = value
    return picture


def grey(levels=GREYS):
    return np.repeat(in_quarters(np.array(levels, np.uint8))[..., None], 3, axis=2)


def saved(image, form, **options):
    buffer = io.BytesIO()
    image.save(buffer, format=form, **options)
    return buffer.getvalue()


def rgb():
    return Image.fromarray(drawn())


def chunk(kind, body):
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def png(width, height, kind, depth, rows):
    head = struct.pack(">IIBBBBB", width, height, depth, kind, 0, 0, 0)
    body = chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + body


def rgb16_png():
    values = drawn().astype(">u2") * 257
    return png(WIDTH, HEIGHT, 2, 16, b"".join(b"\0" + row.tobytes() for row in values))


#: Quarters and mirror of the stored pixels of each orientation.
TURNS = (0, 0), (0, 1), (2, 0), (2, 1), (1, 1), (1, 0), (-1, 1), (-1, 0)


def turned(orientation):
    """Return a JPEG whose stored pixels become `drawn` when the orientation is applied."""
    quarter, mirrored = TURNS[orientation - 1]
    stored = np.rot90(drawn()[:, ::-1] if mirrored else drawn(), quarter)
    exif = Image.Exif()
    exif[0x0112] = orientation
    return saved(Image.fromarray(np.ascontiguousarray(stored)), "JPEG", quality=95, exif=exif)


def with_profile(form, **options):
    """Return `drawn` with red and green exchanged, in the pixels and in the embedded profile."""
    profile = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    for old, new in ((b"rXYZ", b"temp"), (b"gXYZ", b"rXYZ"), (b"temp", b"gXYZ")):
        profile = profile[:128] + profile[128:400].replace(old, new) + profile[400:]
    names = ("sRGB".encode("utf-16-be"), "wide".encode("utf-16-be"))
    pixels = np.ascontiguousarray(drawn()[..., [1, 0, 2]])
    return saved(Image.fromarray(pixels), form, icc_profile=profile.replace(*names), **options)


def with_alpha(mode):
    alpha = in_quarters(np.array([255, 255, 255, 0], np.uint8))
    image = rgb().convert("L" if mode == "LA" else "RGB")
    image.putalpha(Image.fromarray(alpha))
    return saved(image, "PNG")


def luma():
    return tuple(int(v) for v in np.asarray(rgb().convert("L"))[[0, 0, 16, 16], [0, 24, 0, 24]])


def filled(picture, rows, columns, level):
    picture = picture.copy()
    picture[rows, columns] = level
    return picture


def white_last(picture):
    return filled(picture, slice(16, None), slice(24, None), 255)


def palette_png():
    image = Image.fromarray(in_quarters(np.arange(4, dtype=np.uint8)), mode="P")
    image.putpalette([v for colour in QUARTERS for v in colour])
    return saved(image, "PNG", transparency=3)


def animated():
    other = Image.fromarray(255 - drawn())
    return saved(rgb(), "GIF", save_all=True, append_images=[other, other], duration=50)


def deep_grey(form, kind=np.uint16):
    return saved(Image.fromarray(in_quarters(np.array(GREYS, kind)) * 257), form)


def float_tiff(white):
    values = in_quarters(np.array(GREYS, np.float32)) / 255 * white
    values[0, 0] = np.nan
    return saved(Image.fromarray(values), "TIFF")


def damaged_exif():
    good = turned(6)
    place = good.index(b"Exif")
    return good[: place + 6] + b"\xff" * 12 + good[place + 18 :]


def damaged_icc():
    return saved(rgb(), "JPEG", quality=95, icc_profile=b"\x00\x00\x02\x00lcms" + b"\xa5" * 500)


def png_with(*extra):
    whole = saved(rgb(), "PNG")
    return whole[:33] + b"".join(extra) + whole[33:]


MPO = {"save_all": True, "quality": 95}
#: name: (bytes, expected pixels, largest error per channel)
WORKS = {
    "rgb.png": (lambda: saved(rgb(), "PNG"), drawn, 0),
    "cmyk.tif": (lambda: saved(rgb().convert("CMYK"), "TIFF"), drawn, 0),
    "grey16.png": (lambda: deep_grey("PNG"), grey, 0),
    "grey16.tif": (lambda: deep_grey("TIFF"), grey, 0),
    "rgb16.png": (rgb16_png, drawn, 0),
    "int32.tif": (lambda: deep_grey("TIFF", np.int32), grey, 0),
    "float_to_1.tif": (lambda: float_tiff(1.0), lambda: filled(grey(), 0, 0, 0), 0),
    "float_to_255.tif": (lambda: float_tiff(255.0), lambda: filled(grey(), 0, 0, 0), 0),
    "palette_transparent.png": (palette_png, lambda: white_last(drawn()), 0),
    "alpha.png": (lambda: with_alpha("RGBA"), lambda: white_last(drawn()), 0),
    "grey_alpha.png": (lambda: with_alpha("LA"), lambda: white_last(grey(luma())), 0),
    "animated.gif": (animated, drawn, 0),
    "two_pictures.jpg": (lambda: saved(rgb(), "MPO", append_images=[rgb()], **MPO), drawn, 12),
    "damaged_exif.jpg": (damaged_exif, lambda: np.ascontiguousarray(np.rot90(drawn())), 12),
    "damaged_icc.jpg": (damaged_icc, drawn, 12),
    "profile.jpg": (lambda: with_profile("JPEG", quality=95), drawn, 14),
    **{f"turned_{k}.jpg": (lambda k=k: turned(k), drawn, 12) for k in range(1, 9)},
}


@pytest.mark.parametrize("name", sorted(WORKS))
def test_odd_but_whole_images_give_the_pixels_that_were_drawn(tmp_path, name):
    make, expected, tolerance = WORKS[name]
    path = tmp_path / name
    path.write_bytes(make())
    found, wanted = read_image(path), expected()
    assert found.shape == wanted.shape and found.dtype == np.uint8
    # JPEG blurs across the border of two quarters: only flat parts are compared exactly.
    error = np.abs(found.astype(int) - wanted)
    if tolerance > 2:
        error = error[[6, 6, -7, -7], [8, -9, 8, -9]]
    assert error.max() <= tolerance, name


@pytest.mark.parametrize("form", ["JPEG", "PNG", "TIFF", "WEBP"])
def test_a_reduced_image_is_upright(form):
    exif = Image.Exif()
    exif[0x0112] = 6
    stored = Image.fromarray(np.rot90(drawn())).resize((320, 480), Image.Resampling.NEAREST)
    with Image.open(io.BytesIO(saved(stored, form, exif=exif))) as image:
        found = images.to_small_srgb(image, 48)
    rows, columns = found.shape[0] // 4, found.shape[1] // 4
    corners = found[[rows, rows, -rows, -rows], [columns, -columns, columns, -columns]]
    assert np.abs(corners.astype(int) - QUARTERS).max() < 12


def wrong_checksum(kind):
    whole = bytearray(saved(rgb(), "PNG"))
    place = whole.index(kind)
    whole[place + 4 + struct.unpack_from(">I", whole, place - 4)[0]] ^= 0xFF
    return bytes(whole)


def half_png():
    values = np.random.default_rng(0).integers(0, 256, (64, 64, 3), dtype=np.uint8)
    whole = saved(Image.fromarray(values), "PNG")
    return whole[: len(whole) // 2]


FAILS = {
    "cut.png": (half_png, "truncated"),
    "wrong_checksum_head.png": (lambda: wrong_checksum(b"IHDR"), "PNG"),
    "no_pixels.png": (lambda: png(0, 0, 2, 8, b""), "found"),
    "renamed.svg.png": (lambda: b'<svg xmlns="http://www.w3.org/2000/svg"/>', "SVG"),
    "renamed_page.jpg": (lambda: b"<!DOCTYPE html><html></html>", "HTML"),
    "renamed.pdf.jpg": (lambda: b"%PDF-1.7\n", "PDF"),
    "postscript.jpg": (lambda: b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 9 9\n", "PostScript"),
    "phone.heic": (lambda: b"\0\0\0\x18ftypheic\0\0\0\0mif1heic" + b"\0" * 99, "HEIC"),
    "zeros.jpg": (lambda: b"\0" * 4096, "none"),
    "random.jpg": (lambda: np.random.default_rng(1).bytes(4096), "found"),
}


def test_of_a_pdf_the_page_with_the_most_lines_is_read(tmp_path):
    import pypdfium2

    path, raw = tmp_path / "brochure.pdf", pypdfium2.raw
    with pypdfium2.PdfDocument.new() as document:
        for count in (1, 4, 2):
            page = document.new_page(300, 200)
            for k in range(count):
                line = raw.FPDFPageObj_CreateNewPath(20, 20 + 40 * k)
                raw.FPDFPath_LineTo(line, 280, 20 + 40 * k)
                raw.FPDFPath_SetDrawMode(line, 0, True)
                raw.FPDFPage_InsertObject(page.raw, line)
            page.gen_content()
        document.save(path)
    assert pdf.pages_by_lines(path) == [2, 3, 1] and pdf.page_count(path) == 3
    for page_of, lines in ((pdf.page_picture(), 4), (pdf.page_picture(3), 2)):
        pixels, _ = images.read_reduced_image(path, 64, page_of=page_of)
        dark = pixels[:, pixels.shape[1] // 2].mean(axis=1) < 200
        assert (np.diff(dark.astype(int)) == 1).sum() == lines
    rgb().save(tmp_path / "plan.png")
    assert pdf.page_count(tmp_path / "plan.png") == 1


def test_photos_of_phones_and_pages_are_read(tmp_path):
    import pillow_heif

    heic = tmp_path / "phone.HEIC"
    pillow_heif.from_pillow(rgb().resize((480, 320), Image.Resampling.NEAREST)).save(heic)
    assert np.abs(read_image(heic)[::10, ::10].astype(int) - drawn()).max() < 40
    if features.check("avif"):
        rgb().resize((480, 320), Image.Resampling.NEAREST).save(tmp_path / "site.avif")
        found = read_image(tmp_path / "site.avif")[::10, ::10].astype(int)
        assert np.abs(found - drawn()).mean() < 4
    page = tmp_path / "plan.pdf"
    rgb().save(page, format="PDF", resolution=1.0)
    pixels, size = images.read_reduced_image(page, 64, page_of=pdf.page_picture())
    assert size == (2000, 3000)
    assert np.abs(pixels[500::1000, 750::1500].reshape(4, 3) - np.array(QUARTERS)).max() < 12
    with pytest.raises(InputError, match="found a PDF"):
        read_image(page)  # no photo
    page.write_bytes(page.read_bytes()[:200])
    with pytest.raises(InputError, match="a PDF that can be read"):
        images.read_reduced_image(page, 64, page_of=pdf.page_picture())


@pytest.mark.parametrize("name", sorted(FAILS))
def test_damaged_images_give_one_clear_line(tmp_path, name):
    make, words = FAILS[name]
    path = tmp_path / name
    path.write_bytes(make())
    with pytest.raises(InputError) as error:
        read_image(path, house_id="h1")
    line = str(error.value)
    assert line.startswith(f"file {path}, house h1: expected an image")
    assert words in line and "\n" not in line and len(line) < 600


def test_folders_and_pipes_are_no_images(tmp_path):
    (tmp_path / "folder.jpg").mkdir()
    os.mkfifo(tmp_path / "pipe.jpg")  # opening it would wait for ever
    (tmp_path / "gone.jpg").symlink_to(tmp_path / "nowhere")
    found = {"folder.jpg": "a folder", "pipe.jpg": "no plain file", "gone.jpg": "no such file"}
    for name, words in found.items():
        with pytest.raises(InputError, match=f"{name}.* found {words}"):
            read_image(tmp_path / name)


def riff(kind, body):
    data = b"WEBP" + kind + struct.pack("<I", len(body)) + body
    return b"RIFF" + struct.pack("<I", len(data)) + data


def bombs():
    """Return small files that declare huge pictures, or unpack to much."""
    side = 60000
    whole = saved(rgb(), "JPEG", quality=90)
    place = whole.index(b"\xff\xc0")
    huge_jpeg = whole[: place + 5] + struct.pack(">HH", side, side) + whole[place + 9 :]
    bmp, gif = (bytearray(saved(rgb(), form)) for form in ("BMP", "GIF"))
    struct.pack_into("<ii", bmp, 18, side, side)
    struct.pack_into("<HH", gif, 6, side, side)
    tif = saved(rgb(), "TIFF")
    for tag in (256, 257):
        place = tif.index(struct.pack("<HHI", tag, 4, 1))
        tif = tif[: place + 8] + struct.pack("<I", side) + tif[place + 12 :]
    unpacks_to_much = zlib.compress(bytes(200_000_000), 1)  # more than the reader is allowed
    return {
        "bomb.png": png(side, side, 2, 8, b"\0" * 1000),
        "bomb_near_limit.png": png(8000, 7000, 6, 16, b"\0" * 1000),
        "bomb.jpg": huge_jpeg,
        "bomb.bmp": bytes(bmp),
        "bomb.gif": bytes(gif),
        "bomb.tif": tif,
        "bomb.ppm": f"P6 {side} {side} 255\n".encode(),
        "bomb_lossy.webp": riff(b"VP8 ", b"\0\0\0\x9d\x01\x2a\xff\x3f\xff\x3f" + b"\0" * 99),
        "bomb_lossless.webp": riff(b"VP8L", b"\x2f" + b"\xff" * 99),
        "bomb_canvas.webp": riff(b"VP8X", b"\0\0\0\0" + b"\xff\x3f\0" * 2),
        "bomb_text.png": png_with(chunk(b"zTXt", b"Comment\0\0" + unpacks_to_much)),
        "bomb_profile.png": png_with(chunk(b"iCCP", b"x\0\0" + unpacks_to_much)),
    }


READ_ALL = """
import resource, sys
from PIL import Image, ImageCms
from plan2scene.errors import InputError
from plan2scene.images import read_image
Image.init()
# Not ru_maxrss: that one begins with the parent's.
peak = lambda: int(open("/proc/self/status").read().split("VmHWM:")[1].split()[0])
before = peak()
# What the process has mapped by now, and 120 MB more.
mapped = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (mapped + 120_000_000,) * 2)
for path in sys.argv[1:]:
    try:
        print("image", read_image(path).shape)
    except InputError as error:
        print("line", error)
print("megabytes", (peak() - before) // 1024)
"""


def test_bombs_are_refused_with_little_memory(tmp_path):
    files = bombs()
    for name, data in files.items():
        (tmp_path / name).write_bytes(data)
    options = {"env": os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}}
    paths = [str(tmp_path / name) for name in files]
    options |= {"text": True, "capture_output": True, "check": False}
    run = subprocess.run([sys.executable, "-c", READ_ALL, *paths], **options)
    assert run.returncode == 0, run.stderr
    *lines, last = run.stdout.splitlines()
    assert len(lines) == len(files)
    for path, line in zip(paths, lines, strict=True):
        if path.endswith(("_text.png", "_profile.png")):
            continue  # the picture is sound: it may be read or refused, within the memory
        assert line.startswith(f"line file {path}: expected an image"), line
        if "near_limit" not in path:
            assert f"at most {images.MAX_PIXELS} pixels" in line
    assert 0 <= int(last.split()[1]) < 120, run.stdout
