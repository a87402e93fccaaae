"""A texture method of another package: command line, configuration and tables follow."""

from dataclasses import replace

import pandas as pd
import pytest

from plan2scene.config import check_config, shipped_config
from plan2scene.errors import InputError
from plan2scene.evaluation.houses import propagated_at
from plan2scene.evaluation.paper_table import TableRequest, paper_table
from plan2scene.io import read_json
from plan2scene.textures.inputs import Visible


@pytest.fixture
def toy(toy_installed):
    return "toy"


def _config(name):
    config = shipped_config()
    config["methods"] = ["crop", name]
    config["house"]["method"] = name
    config["study"]["pairs"] = [[name, "crop"]]
    config["textures"]["seam_correction"] = {name: True}
    return config


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("methods", ["magic"]),
        ("house", {"method": "magic"}),
        ("study", {"pairs": [["magic", "crop"]]}),
    ],
)
def test_a_name_that_nobody_registered_is_refused_in_one_line(key, value):
    config = _config("synth")
    config[key] = config[key] | value if isinstance(value, dict) else value
    with pytest.raises(InputError, match=rf"{key}.*'magic' is not one of") as error:
        check_config(config)
    assert "\n" not in str(error.value)


def test_the_paper_s_table_has_it(toy, house, embeddings, references, compare, tmp_path):
    _, propagated = propagated_at(house, embeddings, [], tmp_path)
    bare = replace(house, files=replace(house.files, library=None))  # it asks for none
    metrics = compare(bare, {"0.0": Visible(propagated)}, [toy], tmp_path / "tiles")
    listing = read_json(tmp_path / "tiles" / "0.0" / toy / "textures.json")
    assert (listing["method"], len(listing["surfaces"])) == (toy, 12)
    paths = [tmp_path / f"table.{suffix}" for suffix in ("csv", "parquet", "png")]
    request = TableRequest("d", ("h1",), (toy,), "0.0", 0)
    paper_table([metrics], [references], *paths, request=request)
    rows = pd.read_csv(paths[0])
    assert set(rows["method"]) == {toy}
    assert rows["n"].tolist() == [4, 0, 4]
