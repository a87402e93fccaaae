import importlib.util
import shutil

from places import ROOT


def test_the_example_makes_a_house_and_a_metric(tmp_path):
    spec = importlib.util.spec_from_file_location("pipeline", ROOT / "examples" / "pipeline.py")
    pipeline = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(pipeline)
    home, example = tmp_path / "home", ROOT / "resources" / "examples" / "two_storeys"
    (home / "photos").mkdir(parents=True)
    shutil.copy(example / "plan.json", home)
    table = (example / "photos.csv").read_text().splitlines()[:2]
    (home / "photos.csv").write_text("\n".join(table) + "\n")
    for row in table[1:]:
        shutil.copy(example / "photos" / row.split(",")[1], home / "photos")
    assert 0.0 < pipeline.make_house(home, tmp_path / "out") < 0.2
    assert (tmp_path / "out" / "house.glb").read_bytes()[:4] == b"glTF"
