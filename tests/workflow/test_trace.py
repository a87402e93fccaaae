"""A plan that is a picture: the workflow traces it, for real."""

import cv2
import numpy as np
import pytest
from clones import make_clone

SCENE = "results/tiny/houses/flat/scene.json"


@pytest.fixture
def clone(tmp_path):
    """A house whose plan is the picture of two rooms with a door between them and one outside."""
    row = {"house": "flat", "split": "test", "plan": "flat.jpg", "assignment": "", "photos": ""}
    clone = make_clone(tmp_path / "clone", [row])
    image = np.full((350, 500, 3), 255, np.uint8)
    cv2.rectangle(image, (40, 40), (460, 310), (0, 0, 0), -1)
    for corners in ((50, 50, 249, 299), (256, 50, 449, 299), (249, 100, 256, 145)):
        cv2.rectangle(image, corners[:2], corners[2:], (255, 255, 255), -1)
    cv2.rectangle(image, (100, 300), (145, 311), (255, 255, 255), -1)
    cv2.imwrite(str(clone.root / "data" / "flat.jpg"), image)
    return clone


def test_a_picture_is_traced_before_it_is_read(clone):
    run = clone.snakemake(SCENE)
    assert run.returncode == 0, run.stdout[-3000:]
    made = {path.name for path in (clone.root / SCENE).parent.iterdir() if path.is_file()}
    assert {"scene.json", "plan.json", "plan.overlay.png", "plan.doubts.txt"} <= made
