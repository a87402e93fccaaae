from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from plan2scene.errors import InputError
from plan2scene.images import read_image, write_png
from plan2scene_app.run import SingleHouse, prepare, read_input


def request(plan, table=None):
    return SingleHouse(plan, table, None, "h1", "exemplar", None, seed=0, texture_size=128)


@pytest.fixture
def picture(tmp_path):
    image = np.full((200, 300, 3), 255, np.uint8)
    image[50:150, 100:110] = 0
    path = tmp_path / "scan.any"
    write_png(path, image)
    return path


@pytest.mark.parametrize("form", ["PNG", "PDF"])
def test_the_house_table_names_a_picture_whatever_its_name(picture, tmp_path, form):
    Image.open(picture).save(picture, format=form)
    assert read_input(request(picture)) == []
    prepare(request(picture), [], tmp_path)
    table = (tmp_path / "dataset" / "houses.tsv").read_text().splitlines()
    assert table[1].split("\t")[:3] == ["h1", "test", "plan.png"]
    assert (tmp_path / "dataset" / "plan.png").read_bytes() == picture.read_bytes()


@pytest.mark.parametrize("names", [("ground floor", "1st_floor"), ("1st_floor", "ground floor")])
def test_pictures_of_storeys_become_one_page(names, tmp_path, caplog):
    paths = [tmp_path / f"{name}.png" for name in names]
    for path, shade in zip(paths, (0, 120) if "ground" in names[0] else (120, 0), strict=True):
        page = np.full((300, 200, 3), 255, np.uint8)
        page[60:240, 50:150] = shade
        page[70:230, 60:140] = 255
        write_png(path, 255 - page if shade == 0 else page)  # one is light on dark
    given = replace(request(paths[0]), storeys=(paths[1],), photos_dir=tmp_path)
    with pytest.raises(InputError, match="no photo in it"):  # both are plans
        read_input(given)
    prepare(given, [], tmp_path / "work")
    made = tmp_path / "work" / "dataset" / "plan.png"
    page = read_image(made)
    left, right = page[:, : page.shape[1] // 2], page[:, page.shape[1] // 2 :]
    assert (page[[0, -1]] == 255).all() and (page[:, [0, -1]] == 255).all()
    assert left.min() == 0 and right.min() == 120  # the ground floor is the first
    assert (left.min(axis=2) < 255).sum() == (right.min(axis=2) < 255).sum() == 180 * 100 - 160 * 80
    before = made.stat().st_mtime_ns
    prepare(given, [], tmp_path / "work")
    assert made.stat().st_mtime_ns == before


def test_what_is_no_picture_of_a_storey_and_no_table_is_one_line(picture, tmp_path):
    (other := tmp_path / "first.json").write_text("{}")
    write_png(empty := tmp_path / "empty.png", np.full((200, 300, 3), 255, np.uint8))
    twice = replace(request(picture), storeys=(picture,))
    faults = {
        "a picture of each storey": replace(twice, storeys=(other,)),
        "without a scale, found --metres": replace(twice, metres_per_pixel=0.02),
        "another picture for each storey": twice,
        "an empty page": request(empty),
        "a folder of photos, or a table, found a PNG picture": request(picture, table=picture),
    }
    for told, given in faults.items():
        with pytest.raises(InputError, match=told):
            read_input(given)


def test_a_folder_of_photos_is_given_with_a_picture(picture, tmp_path, caplog):
    photos = tmp_path / "photos"
    (photos / "kitchen").mkdir(parents=True)
    for name, least in (("kitchen/b.jpg", 90), ("a.png", 180), ("a copy.png", 180)):
        grey = np.linspace(least, least + 60, 64 * 64).reshape(64, 64, 1)
        write_png(photos / name, np.repeat(grey, 3, axis=2).astype(np.uint8))
    write_png(photos / "other plan.png", read_image(picture)[8:])
    (photos / "notes.txt").write_text("no photo")
    (photos / picture.name).symlink_to(picture)
    given = replace(request(picture), photos_dir=photos)
    names = read_input(given)
    assert names == ["a copy.png", "kitchen_b.jpg"]
    told = "\n".join(caplog.messages)
    assert "other plan.png left out: a drawing or a page" in told
    assert "a.png left out: a copy.png is the same" in told
    assert "notes.txt" in told
    prepare(given, names, tmp_path)
    dataset = tmp_path / "dataset"
    rows = (dataset / "houses.tsv").read_text().splitlines()[1].split("\t")
    assert rows[3:] == ["photoroom.csv", "a copy.png|kitchen_b.jpg"]
    assert (dataset / "photoroom.csv").read_text() == "room_id,photo\n,a copy.png\n,kitchen_b.jpg\n"
    assert (dataset / "photos" / "kitchen_b.jpg").is_file()


def test_a_table_is_given_with_a_picture_whose_rooms_have_no_names_yet(picture, tmp_path):
    write_png(tmp_path / "a.png", np.full((64, 64, 3), 180, np.uint8))
    table = tmp_path / "photos.csv"
    table.write_text("room_id,photo\nhall,a.png\n")
    assert read_input(request(picture, table)) == ["a.png"]
