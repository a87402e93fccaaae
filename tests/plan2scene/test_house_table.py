import pytest

from plan2scene.datasets.house_table import (
    TableRow,
    check_metrics,
    check_official,
    load_houses,
    photo_paths,
)
from plan2scene.errors import InputError

HEADER = "house\tsplit\tplan\tassignment\tphotos\n"


def test_only_the_asked_splits(tmp_path):
    path = tmp_path / "houses.tsv"
    path.write_text(HEADER + "a\ttrain\tp\t\t\nb\ttest\tp\t\tx.jpg|y.jpg\n")
    table = load_houses(path, splits=["test"])
    assert table == {"b": TableRow("b", "test", "p", "", ("x.jpg", "y.jpg"))}
    with pytest.raises(InputError, match="split val"):
        load_houses(path, splits=["val"])
    assert list(load_houses(path, splits=["train", "test"], houses=["b"])) == ["b"]
    with pytest.raises(InputError, match=r"house a: .* found no such house"):
        load_houses(path, splits=["test"], houses=["b", "a"])


def test_a_missing_table_is_an_error_unless_it_is_yet_to_be_made(tmp_path):
    with pytest.raises(InputError):
        load_houses(tmp_path / "none.tsv", splits=["test"])
    assert load_houses(tmp_path / "none.tsv", splits=["test"], may_be_absent=True) == {}


def test_only_photos_that_exist_inside_the_folder(tmp_path):
    folder = tmp_path / "photos"
    folder.mkdir()
    (folder / "a.jpg").write_text("")
    (tmp_path / "secret.jpg").write_text("")
    assert photo_paths(folder, ["a.jpg", "b.jpg", "../secret.jpg"]) == [folder / "a.jpg"]


def test_official_weights_need_their_checkpoints(tmp_path):
    there = tmp_path / "a.ckpt"
    there.write_bytes(b"")
    given = {"texture": str(there), "propagation": str(there), "naivesynth": None}
    check_official({"weights": "official", "official": given})
    check_official({"weights": "embedded", "official": {"texture": None, "propagation": None}})
    for name in ("texture", "propagation"):
        with pytest.raises(InputError, match=f"a path for official.{name}, found null"):
            check_official({"weights": "official", "official": given | {name: None}})
    with pytest.raises(InputError, match=r"official\.naivesynth\), found no such file"):
        check_official({"weights": "official", "official": given | {"naivesynth": "no.ckpt"}})


def test_networks_of_the_metrics_must_be_there(tmp_path):
    there = tmp_path / "a.pth"
    there.write_bytes(b"")
    check_metrics({"vgg16": None, "inception": str(there)})
    with pytest.raises(InputError, match=r"metrics\.vgg16\), found no such file"):
        check_metrics({"vgg16": "no.ckpt", "inception": None})
