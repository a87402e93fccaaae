import pytest

from plan2scene.errors import InputError
from plan2scene_app.workflow.config import check_checkpoints
from plan2scene_app.workflow.house_table import TableRow, read_table
from plan2scene_app.workflow.planning import photo_paths

HEADER = "house\tsplit\tplan\tassignment\tphotos\n"


def test_only_the_asked_splits_and_the_nearest_names_of_an_unknown_house(tmp_path):
    path = tmp_path / "houses.tsv"
    path.write_text(HEADER + "NA\ttrain\tp\t\t\nb\ttest\tp\tt.csv\tx.jpg|y.jpg\n")
    table = read_table(path)
    row = TableRow("b", "test", "p", "t.csv", ("x.jpg", "y.jpg"))
    assert table.of_splits(["test"]) == {"b": row}
    assert table["NA"] == TableRow("NA", "train", "p", "", ())
    with pytest.raises(InputError, match="split val, found only test, train"):
        table.of_splits(["val"])
    assert list(table.of_splits(["train", "test"], ["b"])) == ["b"]
    with pytest.raises(InputError, match=r"house NA: .* found no such house"):
        table.of_splits(["test"], ["b", "NA"])
    path.write_text(HEADER + "flat_1\ttest\tp\t\t\nflat_2\ttest\tp\t\t\nb\ttest\tp\t\t\n")
    with pytest.raises(InputError, match=r"houses\.tsv, house flat_3: .* but flat_2, flat_1$"):
        read_table(path)["flat_3"]
    with pytest.raises(InputError, match=r"found no such house$"):
        read_table(path)["xyz"]


def test_only_photos_that_exist_inside_the_folder(tmp_path):
    (folder := tmp_path / "photos").mkdir()
    (folder / "a.jpg").write_text("")
    (tmp_path / "secret.jpg").write_text("")
    assert photo_paths(folder, ["a.jpg", "b.jpg", "../secret.jpg"]) == [folder / "a.jpg"]


def test_checkpoints_and_folders_that_are_needed():
    given = {"texture": __file__, "propagation": __file__, "naivesynth": None}
    config = {"metrics": {"vgg16": None, "inception": None}, "weights": "official", "models": {}}
    config |= {"official": given, "photos": {"masks": "embedded", "masks_folder": None}}
    config |= {"crops": {"folder": None}, "textures": {"library_folder": None}}
    config["photos"]["pretrained"] = {"path": None, "id": "a/b", "revision": None}
    check_checkpoints(config)
    check_checkpoints(config | {"weights": "embedded"})
    faults = {
        r"a path for official\.texture, found null": {"official": given | {"texture": None}},
        r"official\.propagation, found null": {"official": given | {"propagation": None}},
        r"official\.naivesynth\), found no such": {"official": given | {"naivesynth": "no.ckpt"}},
        r"models\.kinds\), found no such file": {"models": {"kinds": "no.safetensors"}},
        r"masks_folder\), found null": {"photos": config["photos"] | {"masks": "precomputed"}},
        r"file no: expected a folder \(crops\.folder\), found no": {"crops": {"folder": "no"}},
        r"\(textures\.library_folder\), found no": {"textures": {"library_folder": "no"}},
        "id and revision, in photos": {"photos": config["photos"] | {"masks": "pretrained"}},
    }
    for told, change in faults.items():
        with pytest.raises(InputError, match=told):
            check_checkpoints(config | change)
