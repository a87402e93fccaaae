import zipfile

import numpy as np
import pytest
from flat_picture import flat_picture
from PIL import Image

from plan2scene.errors import InputError
from plan2scene_app import packed_photos
from plan2scene_app.packed_photos import is_packed, photo_files, unpack_photos, unpacked
from plan2scene_app.run import photos_in

rng = np.random.default_rng(0)
PHOTOS = [
    Image.fromarray(rng.integers(0, 255, (24, 32, 3), np.uint8)).resize((640, 480)) for _ in "ab"
]
LOGO = PHOTOS[0].resize((160, 120))


def pdf(path, *pictures):
    first, *more = (picture.copy() for picture in pictures)  # Pillow keeps what it is saved with
    first.save(path, save_all=True, append_images=more, resolution=72)
    return path


def test_photos_of_a_brochure_are_taken_and_plan_and_logo_left_out(tmp_path, caplog):
    plan = Image.fromarray(flat_picture())
    path = pdf(tmp_path / "brochure.pdf", PHOTOS[0], plan, LOGO, PHOTOS[1])
    assert is_packed(path)
    with unpacked(path) as folder:
        assert photos_in(folder, [path]) == ["page01_1.jpg", "page04_1.jpg"]
        taken = np.asarray(Image.open(folder / "page04_1.jpg")).astype(int)
        first = {file.name: file.read_bytes() for file in folder.iterdir()}
    assert np.abs(taken - np.asarray(PHOTOS[1])).mean() < 6
    assert "page02_1.jpg left out: a drawing or a page" in caplog.text
    assert not folder.exists()
    with unpacked(path) as folder:
        assert first == {file.name: file.read_bytes() for file in folder.iterdir()}
        (folder / "page01_1.AAE").touch()  # what a phone writes beside a photo
        assert photos_in(folder, [path])[0] == "page01_1.jpg"


def test_folders_name_the_photos_in_them_and_results_are_left_out(tmp_path):
    for name in ("1.jpg", "bath {a}/1.jpg", "out/work/lock", "out/rooms.jpg", ".cache/2.jpg"):
        (path := tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    assert [*photo_files(tmp_path)] == ["1.jpg", "bath _a__1.jpg"]


@pytest.mark.parametrize(
    ("picture", "size", "told"),
    [
        (LOGO, None, ".*, found none"),
        (Image.fromarray(flat_picture()), None, ".*, found no photo in it"),
        (PHOTOS[0], 100, "a PDF that can be read"),
    ],
)
def test_a_pdf_without_photos_is_one_line_with_its_name(tmp_path, picture, size, told):
    path = pdf(tmp_path / "plan.pdf", picture)
    path.write_bytes(path.read_bytes()[:size])
    fault = pytest.raises(InputError, match=rf"^file {path}: expected {told}")
    with fault, unpacked(path) as folder:
        photos_in(folder, [])


def test_files_of_a_zip_keep_the_folders_that_differ_and_are_not_too_large(tmp_path, monkeypatch):
    monkeypatch.setattr(packed_photos, "MAX_IMAGE_BYTES", 1000)
    names = ("home/bxxth/1.jpg", "home/kitchen/1.jpg", "__MACOSX/home/._1.jpg", "home/.DS_Store")
    with zipfile.ZipFile(path := tmp_path / "photos.zip", "w") as archive:
        for number, name in enumerate(names):
            archive.writestr(name, bytes([number]))
    # No flag says that the name is UTF-8.
    path.write_bytes(path.read_bytes().replace(b"xx", "ä".encode()))
    with unpacked(path) as folder:
        found = {file.name: file.read_bytes() for file in folder.iterdir()}
    assert found == {"bäth_1.jpg": b"\0", "kitchen_1.jpg": b"\1"}
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("1.jpg", bytes(2000))
    fault = pytest.raises(InputError, match=r"photos\.zip: expected photos of at most 1000 bytes")
    with fault, unpacked(path):
        pass


@pytest.mark.parametrize("name", ["../1.jpg", "a/../../1.jpg", "/1.jpg"])
def test_no_file_of_a_zip_leaves_its_folder(name, tmp_path):
    with zipfile.ZipFile(tmp_path / "photos.zip", "w") as archive:
        archive.writestr(name, b"")
        archive.writestr("b/2.jpg", b"")
    (home := tmp_path / "made").mkdir()
    try:
        assert all(path.parent == home for path in unpack_photos(tmp_path / "photos.zip", home))
    except InputError as error:
        assert "photos.zip" in str(error)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["made", "photos.zip"]
