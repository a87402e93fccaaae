"""A house by all methods in one job: the files are those of the stages on their own."""

import numpy as np
import pytest

from plan2scene.evaluation.comparison import Compared, Settings, Visible, compare_house
from plan2scene.evaluation.houses import HouseFiles, Models, propagated_at
from plan2scene.evaluation.measure import measure_house, read_references
from plan2scene.io import read_json, read_parquet
from plan2scene.textures.stage import make_textures

METHODS = ("crop", "naivesynth", "synth")
HIDDEN = {"0.0": [], "0.6": ["p2.jpg"]}
SEAMS = {"crop": False, "naivesynth": True, "synth": False}


@pytest.fixture(scope="module")
def drops(files, models, tmp_path_factory):
    root = tmp_path_factory.mktemp("drops")
    visible = {}
    for drop, hidden in HIDDEN.items():
        (root / drop).mkdir()
        visible[drop] = Visible(propagated_at(files, models, hidden, root / drop)[1], hidden)
    return visible


def pairs(root, made=()):
    return [
        Compared(
            method,
            drop,
            root / drop / method / "textures",
            root / drop / method / "metrics.parquet",
            (method, drop) in made,
        )
        for drop in HIDDEN
        for method in METHODS
    ]


def alone(one, files, models, visible):
    """Make the textures of a method as its own job does."""
    make_textures(
        one.method,
        visible.propagated,
        files.crops,
        files.scene,
        one.textures,
        house="h1",
        hidden_photos=visible.hidden_photos,
        library=files.library,
        model=models.decoder(one.method),
        seed=5,
        size_px=64,
        seam_correction=SEAMS[one.method],
    )


def test_textures_and_metrics_are_those_of_the_stages(files, models, drops, tmp_path):
    compared, own = pairs(tmp_path / "compared"), pairs(tmp_path / "own")
    compare_house(files, models, drops, compared, Settings(5, 64, SEAMS))
    for one, other in zip(compared, own, strict=True):
        alone(other, files, models, drops[other.drop])
        names = sorted(path.name for path in other.textures.iterdir())
        assert names == sorted(path.name for path in one.textures.iterdir())
        for name in names:
            assert (one.textures / name).read_bytes() == (other.textures / name).read_bytes()
        measure_house(
            other.textures,
            read_references(files.crops, HIDDEN[other.drop]),
            models.features,
            other.metrics,
            dataset="d",
            house="h1",
            method=other.method,
            drop=other.drop,
        )
        assert one.metrics.read_bytes() == other.metrics.read_bytes()


def test_textures_that_are_there_are_measured_as_they_are(files, models, drops, tmp_path):
    compared = pairs(tmp_path, made={("synth", "0.0")})
    chosen = next(one for one in compared if one.made)
    # What stands there is another method's: only the metrics can tell.
    crop = Compared("crop", "0.0", chosen.textures, chosen.metrics, False)
    alone(crop, files, models, drops["0.0"])
    before = {path.name: path.read_bytes() for path in chosen.textures.iterdir()}
    compare_house(files, models, drops, compared, Settings(5, 64, SEAMS))
    assert {path.name: path.read_bytes() for path in chosen.textures.iterdir()} == before
    measured = read_parquet(chosen.metrics)[0]
    assert set(measured["method"]) == {"synth"}
    theirs = read_parquet(compared[0].metrics)[0]
    assert np.array_equal(measured["color"], theirs["color"])
    assert read_json(compared[2 + 3].textures / "textures.json")["method"] == "synth"


def test_only_decoded_methods_get_more_images(files, models, drops, tmp_path):
    compared = pairs(tmp_path)
    compare_house(files, models, drops, compared, Settings(5, 64, SEAMS, images=3))
    for one in compared:
        lengths = {len(row) for row in read_parquet(one.metrics)[0]["further_features"]}
        size = len(read_parquet(one.metrics)[0]["features"].iloc[0])
        assert lengths == ({0} if one.method == "crop" else {2 * size})


def test_a_job_s_inputs_become_files_and_models(files, models):
    paths = {name: str(getattr(files, name)) for name in ("scene", "crops", "library")}
    paths |= {"embeddings": str(files.embeddings)}
    assert HouseFiles.of(paths, "h1", "d") == files
    assert str(HouseFiles.of({**paths, "pool": "pool.parquet"}, "h1", "d").crop_pool) == (
        "pool.parquet"
    )
    named = {name: str(path) for name, path in vars(models).items()}
    assert Models.of({**named, "scene": "x"}) == models
