"""Textures and environments of folders made here: splits, relief, refusals."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from plan2scene.errors import InputError
from plan2scene.images import write_png
from plan2scene_workshop.rendering.sources import TEXTURE_PX, load_textures


def _flat_folder(folder: Path, substance: str = "floor_wood") -> Path:
    """Write nine grey textures, the first with normals that lean to one side in half of it."""
    write_png(folder / "grey.png", np.full((32, 32, 3), 120, np.uint8))
    normals = np.full((32, 32, 3), (128, 128, 255), np.uint8)
    normals[:, 16:] = (220, 220, 160)
    write_png(folder / "normal.png", normals)
    rows = [f"grey.png,{substance},{'normal.png' if k == 0 else ''}\n" for k in range(9)]
    (folder / "index.csv").write_text("file,substance,normal\n" + "".join(rows))
    return folder


def test_flat_textures_have_their_relief_and_their_split(tmp_path: Path) -> None:
    folder = _flat_folder(tmp_path)
    train, held_out = (load_textures(folder, train=train) for train in (True, False))
    assert (len(train), len(held_out)) == (8, 1)
    assert train[0].substance == "wood" and train[0].albedo.shape == (TEXTURE_PX, TEXTURE_PX, 3)
    left, right = (
        float(train[0].albedo[:, part].mean()) for part in (slice(0, 200), slice(300, None))
    )
    assert left == pytest.approx(120, abs=1) and abs(right - left) > 5
    assert np.ptp(train[1].albedo) == 0


def test_unknown_substances_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="expected a substance of"):
        load_textures(_flat_folder(tmp_path, "floor_lava"), train=True)
    with pytest.raises(InputError, match=r"index\.csv of textures"):
        load_textures(tmp_path / "none", train=True)
