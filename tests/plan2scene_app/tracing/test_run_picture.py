"""A picture as the plan of ``plan2scene run``."""

import numpy as np
import pytest

from plan2scene.errors import InputError
from plan2scene.images import write_png
from plan2scene_app.run import SingleHouse, prepare, read_input


def request(plan, table=None):
    return SingleHouse(
        plan=plan,
        photo_table=table,
        photos_dir=None,
        house="h1",
        method="exemplar",
        metres_per_pixel=None,
        seed=0,
        texture_size=128,
    )


@pytest.fixture
def picture(tmp_path):
    image = np.full((200, 300, 3), 255, np.uint8)
    image[50:150, 100:110] = 0
    path = tmp_path / "scan.any"
    write_png(path, image)
    return path


def test_the_house_table_names_a_picture_whatever_its_name(picture, tmp_path):
    assert read_input(request(picture)) == []
    prepare(request(picture), [], tmp_path)
    table = (tmp_path / "dataset" / "houses.tsv").read_text().splitlines()
    assert table[1].split("\t")[:3] == ["h1", "test", "plan.png"]
    assert (tmp_path / "dataset" / "plan.png").read_bytes() == picture.read_bytes()


def test_photos_of_rooms_that_nobody_has_seen_are_one_line(picture, tmp_path):
    table = tmp_path / "photos.csv"
    table.write_text("room_id,photo\nhall,a.jpg\n")
    with pytest.raises(InputError, match=r"plan2scene trace scan\.any --out plan\.json"):
        read_input(request(picture, table))


def test_an_empty_page_is_told_before_any_job(tmp_path):
    path = tmp_path / "empty.png"
    write_png(path, np.full((200, 300, 3), 255, np.uint8))
    with pytest.raises(InputError, match="an empty page"):
        read_input(request(path))
