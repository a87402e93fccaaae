import numpy as np
import pytest
from PIL import Image

from plan2scene.errors import InputError
from plan2scene.plans.plan_file import PlanFile
from plan2scene_app.svg import svg_picture
from plan2scene_app.tracing.picture import read_plan_picture

RECT = '<rect x="1" y="1" width="1" height="4"/>'


def drawn(tmp_path, head, inside=RECT):
    (path := tmp_path / "plan.svg").write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" xmlns:x="http://www.w3.org/1999/xlink" {head}>'
        f"{inside}</svg>"
    )
    return path


def test_a_drawing_is_a_picture_of_a_plan(tmp_path):
    for head in ('viewBox="0 0 4 8" width="100%"', 'width="4mm" height="8mm"'):
        path = drawn(tmp_path, head)
        assert PlanFile(path, "h1").is_picture
        dark = np.asarray(svg_picture(path, 80).convert("L")) < 128
        assert dark.shape == (80, 40) and dark[10:50, 10:20].all() and dark.sum() == 400
        assert read_plan_picture(path).file_size == (3000, 1500)


def test_pictures_outside_the_file_are_left_out(tmp_path):
    Image.new("RGB", (8, 8)).save(tmp_path / "secret.png")
    links = f'<image x:href="{tmp_path}/secret.png" width="4" height="8"/>'
    assert np.asarray(svg_picture(drawn(tmp_path, 'viewBox="0 0 4 8"', links), 80)).min() == 255


@pytest.mark.parametrize("head", ["", 'viewBox="0 0 1 9999"', 'viewBox="0 0 a 1"'])
def test_a_drawing_without_a_usual_size_is_one_line(tmp_path, head):
    with pytest.raises(InputError, match=r"^file .*plan\.svg: expected (an SVG with a|sides)"):
        svg_picture(drawn(tmp_path, head), 80)
