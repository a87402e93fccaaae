import json

import numpy as np
import pytest
from PIL import Image
from places import PLAN
from typer.testing import CliRunner
from unscaled_drawings import dxf

from plan2scene.errors import InputError, WorkflowError
from plan2scene.materials import random_material
from plan2scene.plans.formats import read_plan
from plan2scene_app import cli


def call(*arguments):
    result = CliRunner().invoke(cli.app, [str(value) for value in arguments])
    if result.exception and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result.exit_code, result.output


def fault_of(monkeypatch, capsys, *arguments):
    monkeypatch.setattr("sys.argv", ["plan2scene", *map(str, arguments)])
    with pytest.raises(SystemExit) as stop:
        cli.main()
    assert stop.value.code == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("ERROR ") and "expected" in line
    return line


def test_metrics_prints_json(tmp_path):
    path = tmp_path / "a.png"
    Image.fromarray(random_material("carpet", 1, size_px=128).albedo).save(path)
    code, output = call("metrics", path, path)
    figures = json.loads(output)
    assert code == 0 and list(figures) == ["color", "freq", "tile", "subs"]
    assert figures["color"] == figures["freq"] == figures["subs"] == 0


def test_masks_are_label_images_and_take_the_place_of_such_alone(tmp_path):
    photo, bad, out = tmp_path / "room one.jpg", tmp_path / "bad.png", tmp_path / "out"
    Image.fromarray(np.full((90, 120, 3), 180, np.uint8)).save(photo)
    bad.write_text("no image")
    code, output = call("masks", bad, photo, "--out", out)
    assert code == 1 and "bad.png" in output  # the bad one is named, the other is done
    labels = Image.open(out / "room one.png")
    assert labels.size == (120, 90) and labels.mode == "L"
    assert set(np.unique(np.asarray(labels))) <= {0, 1, 2, 3}
    assert call("masks", photo, "--out", out)[0] == 0
    Image.fromarray(np.full((90, 120), 180, np.uint8)).save(out / "room one.png")
    before = (out / "room one.png").read_bytes()
    with pytest.raises(InputError, match="expected a folder without other pictures"):
        call("masks", photo, "--out", out)
    assert (out / "room one.png").read_bytes() == before


def test_check_tells_errors_by_its_exit_code_and_of_a_picture_that_it_is_traced(tmp_path):
    assert call("check", PLAN)[0] == 0
    (wrong := tmp_path / "wrong.json").write_text(PLAN.read_text().replace("Bedroom", "Dungeon"))
    code, output = call("check", wrong)
    assert code == 1 and "Dungeon" in output and "expected" in output
    Image.fromarray(np.full((200, 300, 3), 180, np.uint8)).save(tmp_path / "plan.png")
    code, output = call("check", tmp_path / "plan.png")
    assert code == 0
    assert "plan2scene trace" in output and output.splitlines()[-1] == "1 problem"
    (tmp_path / "cut.png").write_bytes((tmp_path / "plan.png").read_bytes()[:60])
    code, output = call("check", tmp_path / "cut.png")
    assert code == 1 and "error: file" in output
    for name, text in (("lock", ""), ("dataset/houses.tsv", "house\n")):  # of a run's output
        (tmp_path / "work" / name).parent.mkdir(exist_ok=True, parents=True)
        (tmp_path / "work" / name).write_text(text)
    assert "dataset/houses.tsv: expected the columns" in call("check", tmp_path)[1]


def test_run_refuses_before_any_work_what_it_cannot_use(tmp_path, monkeypatch, capsys):
    table, out = tmp_path / "photos.csv", tmp_path / "out"
    arguments = ["run", "--plan", PLAN, "--out", out]
    table.write_text("room_id,photo\nno_such_room,x.jpg\n")
    assert "no_such_room" in fault_of(monkeypatch, capsys, *arguments, "--photos", table)
    assert not (out / "work" / ".snakemake").exists()
    with pytest.raises(InputError, match="expected a photo table with --photos-dir"):
        call(*arguments, "--photos", tmp_path, "--photos-dir", tmp_path)
    with pytest.raises(InputError, match=r"other: expected the folder of the photos"):
        call(*arguments, "--photos", table, "--photos-dir", tmp_path / "other")
    out = arguments[-1] = tmp_path / "other"
    with pytest.raises(InputError, match="found 100"):
        call(*arguments, "--texture-size", "100")
    for name in ("../x", ".hidden", "a b"):
        with pytest.raises(InputError, match="expected a house id"):
            call(*arguments, "--house", name)
    (tmp_path / "a.JPG").write_text("no picture")
    (tmp_path / "b.jpg").write_text("no picture")
    table.write_text("room_id,photo\nliving,a.jpg\nhall,b.jpg\n")
    with pytest.raises(InputError, match=r"none of 2; the first, .*a.jpg: no .*, but a\.JPG"):
        call(*arguments, "--photos", table)
    assert not out.exists()


@pytest.mark.parametrize("command", ["masks", "texture", "import", "trace", "convert-checkpoint"])
def test_no_command_overwrites_its_input_or_a_file_that_is_there(tmp_path, command):
    given, mine = tmp_path / "a.png", tmp_path / "mine.json"
    Image.fromarray(np.full((64, 64, 3), 180, np.uint8)).save(given)
    before = given.read_bytes()
    mine.write_text("mended by hand")
    network = ["vgg16"] if command == "convert-checkpoint" else []
    with pytest.raises(InputError, match="expected an output that is no input"):
        call(command, *network, given, "--out", tmp_path if command == "masks" else given)
    assert given.read_bytes() == before
    if command != "masks":
        with pytest.raises(InputError, match="a new file to write, found one that is there"):
            call(command, *network, given, "--out", mine)
    assert mine.read_text() == "mended by hand"


@pytest.mark.parametrize("command", ["run", "texture", "import"])
def test_an_output_that_cannot_be_written_is_one_line(tmp_path, monkeypatch, capsys, command):
    photo, blocked = tmp_path / "a.png", tmp_path / "file" / "x"
    Image.fromarray(np.full((64, 64, 3), 180, np.uint8)).save(photo)
    blocked.parent.write_text("a file, no folder")
    given = {"run": ["--plan", PLAN], "import": [PLAN], "texture": [photo, "--method", "crop"]}
    assert fault_of(monkeypatch, capsys, command, *given[command], "--out", blocked)


@pytest.mark.parametrize(
    ("name", "house"),
    [("план.json", "house"), ("дом 5.json", "house"), ("Küche.json", "Kuche"), ("-x.txt", "x")],
)
def test_a_house_is_called_as_its_plan(tmp_path, name, house):
    (tmp_path / name).write_bytes(PLAN.read_bytes())
    call("edit", tmp_path / name, "--out", tmp_path / "page.html")
    assert f"<title>{house} - " in (tmp_path / "page.html").read_text()
    with pytest.raises(InputError, match=r"expected a page to write, .*, found plan\.json"):
        call("edit", tmp_path / name, "--out", tmp_path / "plan.json")


def test_dxf_layers_by_the_command_line(tmp_path):
    pytest.importorskip("ezdxf")
    plan, out = tmp_path / "flat.dxf", tmp_path / "scene.json"
    plan.write_bytes(dxf())
    scale = ("--metres-per-pixel", 0.001)
    layer = (*scale, "--dxf-layer", "walls=w?,flat")
    code, output = call("check", plan, *scale)
    assert code == 1 and "rooms, or walls that close some" in output
    code, output = call("check", plan, *layer)
    assert code == 0 and "2 rooms, 8 walls" in output
    call("import", plan, *layer, "--out", out)
    assert len(read_plan(out, "flat").rooms) == 2
    for wrong in ("roofs=poly*", "rooms", "rooms=poly", f"rooms={301 * '*'}", "rooms="):
        with pytest.raises(InputError) as caught:
            call("import", plan, "--dxf-layer", wrong, "--out", out)
        assert "\n" not in str(caught.value)


def test_what_a_run_shows_reaches_the_workflow(tmp_path, monkeypatch):
    import yaml

    from plan2scene_app import run as runs
    from plan2scene_app.workflow.config import check_config

    asked, make = [], runs.run
    monkeypatch.setattr(runs, "run", lambda request, *_, **__: asked.append(request) or {})
    for given in (("--walls", "room", "--colours", "photo"), ()):
        assert call("run", "--plan", PLAN, "--out", tmp_path / "out", *given)[0] == 0
    shown = []
    for k, request in enumerate(asked):
        config = yaml.safe_load(runs.prepare(request, [], tmp_path / str(k)).read_text())
        check_config(config)
        shown.append((config["house"]["walls"], config["house"]["colours"]))
    assert shown == [("room", "photo"), ("wall", "paint")]
    assert call("run", "--plan", PLAN, "--out", tmp_path / "out", "--walls", "accent")[0] == 2
    assert call("run", "--plan", PLAN, "--photos", tmp_path, "--out", tmp_path / "out")[0] == 0
    assert [asked[2].photo_table, asked[2].photos_dir] == [None, tmp_path]
    assert call("run", "--plan", tmp_path / "Haus_{3}.json", "--out", tmp_path / "out")[0] == 0
    assert [request.name for request in asked[2:]] == ["out", "Haus_3"]  # PLAN is any plan.json
    # Of a profile that Snakemake finds by itself it prints a line in every run.
    command = []
    monkeypatch.setattr(runs, "run_bound", lambda words, **_: command.extend(words) or 1)
    with pytest.raises(WorkflowError, match="the workflow failed"):
        make(asked[1], tmp_path / "made", cores=1)
    assert command[command.index("--workflow-profile") + 1] == "none"
