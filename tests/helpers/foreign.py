"""Every reader of bytes from strangers, good examples of each, and ways to damage them.

`READERS` is what tests and benchmarks/fuzz.py go through: a new reader is an entry.
"""

import io
import json
import re
import struct
import tempfile
import zipfile
from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import torch
import yaml
from hypothesis import configuration
from hypothesis import strategies as st
from PIL import Image
from places import PLAN, STOREYS
from safetensors.torch import save
from unscaled_drawings import dxf

from plan2scene.checkpoints.reading import fitted_state, read_checkpoint, state_dict_of
from plan2scene.datasets.assignments import read_assignment
from plan2scene.datasets.import_plan import add_object_boxes
from plan2scene.errors import InputError
from plan2scene.images import image_from_bytes
from plan2scene.io import read_parquet, write_json, write_parquet
from plan2scene.materials import load_texture_folder
from plan2scene.mesh.texture_files import textured
from plan2scene.photos.camera.exif import read_exif_focal
from plan2scene.photos.crops.extract_crops import CropFiles, read_precomputed_crops, write_crops
from plan2scene.photos.labels.palette import labels_from_folder
from plan2scene.photos.locate.pose import read_poses
from plan2scene.photos.photo_files import read_photo
from plan2scene.plans.formats import read_plan
from plan2scene.plans.geometry import room_polygon
from plan2scene.plans.plan_json import house_of_plan
from plan2scene.plans.scene_json import house_of_scene
from plan2scene.plans.scene_writer import house_to_scene
from plan2scene.plans.validate import validate_house
from plan2scene.stage_json import FORMS, read_stage_json
from plan2scene.weights import filled, load_model_file, read_model_arrays
from plan2scene_app.run import shipped_config
from plan2scene_app.studio.projects import Project
from plan2scene_app.studio.runs import status
from plan2scene_app.workflow.config import check_config
from plan2scene_app.workflow.drops import read_unobserved
from plan2scene_app.workflow.house_table import read_table

# Else it keeps what it knows of the sources in the folder where the tests are started.
configuration.set_hypothesis_home_dir(Path(tempfile.gettempdir()) / "plan2scene_hypothesis")
SHAPES = {"weight": (2, 3), "bias": (2,)}


@dataclass(frozen=True)
class Reader:
    """Reads a file called `name`; `examples` are whole files of its kind."""

    name: str
    examples: Callable[[], list[bytes]]
    read: Callable[[Path], object]


def house():
    return read_plan(PLAN, "h1")


def numbers(value):
    if isinstance(value, torch.Tensor):
        value = value.numpy()
    if isinstance(value, np.ndarray):
        yield from [float(v) for v in (value.min(), value.max())] if value.size else []
    elif isinstance(value, float) or (isinstance(value, int) and abs(value) < 2**63):
        yield float(value)
    elif is_dataclass(value):
        yield from (v for field in fields(value) for v in numbers(getattr(value, field.name)))
    elif isinstance(value, dict):
        yield from (v for item in value.values() for v in numbers(item))
    elif isinstance(value, list | tuple):
        yield from (v for item in value for v in numbers(item))


def read_any_plan(path):
    """Return a plan; what holds must survive the round trip through scene.json.

    What no home has must be told: silent nonsense is worse than a fault.
    """
    found = read_plan(path, "h1", 0.05)
    lines = validate_house(found, file=path)
    outlines = [room_polygon(room) for room in found.rooms]
    judged = {
        "a wall thicker than 1 m": max((wall.depth for wall in found.walls), default=0) > 1,
        "a wall higher than 8 m": max((wall.height for wall in found.walls), default=0) > 8,
        "a room over 500 m2": max(outline.area for outline in outlines) > 500,
        "a room under 0.05 m2": min(outline.area for outline in outlines) < 0.05,
        "a room under 0.2 m": any(outline.buffer(-0.1).is_empty for outline in outlines),
        "no walls": not found.walls,
        "a number over 200": max(map(abs, numbers(found)), default=0) > 200,
    }
    assert lines or not any(judged.values()), [name for name, holds in judged.items() if holds]
    assert house_of_scene(house_to_scene(found), "h1") == found
    return found


def own_plans():
    room = {"id": "a", "types": ["Bedroom"], "polygon": [[0, 0], [4, 0], [4, 3], [0, 3]]}
    small = {"format": "plan2scene-plan", "version": 1, "rooms": [room]}
    return [PLAN.read_bytes(), *as_json(small), STOREYS.read_bytes()]


def scenes():
    return as_json(house_to_scene(house()))


def raster_plans():
    rows = [f"{40 * i} 0 {40 * i} 80 wall 1 1" for i in range(4)]
    rows += [f"0 {40 * i} 120 {40 * i} wall 1 1" for i in range(3)]
    rows += ["40 10 40 30 door 1 1", "10 10 20 20 bedroom 1 1", "50 10 60 20 toilet 1 1"]
    lines = ["200 200", "4", "0 0 90 0 3 0", "90 0 90 90 3 0", "0 90 90 90 0 3", "0 0 0 90 3 0"]
    return ["\n".join(rows).encode(), "\n".join([*lines, "10 0 30 0 door 1 1"]).encode()]


def drawings():
    """Return an SVG plan in CubiCasa's classes: a room of 4 x 3 m, its walls and a door."""
    boxes = {"Wall a": (-5, -5, 205, 5), "Wall b": (-5, 145, 205, 155), "Wall c": (-5, -5, 5, 155)}
    boxes |= {"Wall d": (195, -5, 205, 155), "Door Swing": (50, -5, 95, 5)}
    boxes |= {"Space Bedroom": (0, 0, 200, 150)}
    parts = [
        f'<g class="{name}"><polygon points="{x0},{y0} {x1},{y0} {x1},{y1} {x0},{y1} "/></g>'
        for name, (x0, y0, x1, y1) in boxes.items()
    ]
    head = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 300 300">'
    return [f'<?xml version="1.0"?>{head}{"".join(parts)}</svg>'.encode()]


def scans():
    corners = [(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)]
    walls = []
    for (x0, z0), (x1, z1) in zip(corners, corners[1:] + corners[:1], strict=True):
        size = abs(x1 - x0) + abs(z1 - z0)
        x, z = (x1 - x0) / size, (z1 - z0) / size
        transform = [x, 0, z, 0, 0, 1, 0, 0, -z, 0, x, 0, *[(x0 + x1) / 2, 1.2, (z0 + z1) / 2, 1]]
        wall = {"identifier": f"w{x0}{z0}", "category": {"wall": {}}, "story": 0}
        walls.append({**wall, "dimensions": [size, 2.4, 0], "transform": transform})
    room = {"walls": walls, "floors": [], "sections": [], "doors": [], "windows": []}
    return [json.dumps(room | {"openings": [], "story": 0}).encode()]


def homes():
    points = [(0, 0), (400, 0), (400, 300), (0, 300)]
    inside = "".join(f'<point x="{x}" y="{y}"/>' for x, y in points)
    text = f'<home version="7000" name="h" wallHeight="250"><room id="r">{inside}</room></home>'
    return [zipped({"Home.xml": text.encode(), "ContentDigests": b"x"})]


def layouts():
    """Return a zind_data.json: a floor of a cleaned plan and one of a panorama."""
    ring = [[0, 0], [4, 0], [4, 3], [0, 3]]
    room = {"vertices": ring, "pins": [{"label": "bath"}], "doors": [[1, 0], [2, 0]]}
    place = {"rotation": 10, "scale": 1, "translation": [1, 1]}
    layout = {"vertices": ring, "windows": [[1, 0], [2, 0], [-1, 1]]}
    pano = {"is_primary": True, "label": "hall", "ceiling_height": 2, "layout_raw": layout}
    panos = {"p": {"q": {**pano, "floor_plan_transformation": place}}}
    scales = {"f1": 1.0, "f2": 1.5}
    parts = {"redraw": {"f1": {"r": room}}, "merger": {"f2": {"c": panos}}}
    return [json.dumps({"scale_meters_per_coordinate": scales, **parts}).encode()]


def models():
    from plan2scene_app.exports.ifc4 import write_ifc

    small = {**json.loads(own_plans()[1]), "openings": [DOOR]}
    with tempfile.TemporaryDirectory() as folder:
        write_ifc(house_of_plan(small, "h1"), {}, Path(folder))
        return [(Path(folder) / "house.ifc").read_bytes()]


def parquets():
    rows = {"room": ["a", "b"] * 50, "x": np.arange(100.0), "image": [b"png"] * 100}
    with tempfile.TemporaryDirectory() as folder:
        write_parquet(Path(folder) / "x.parquet", pd.DataFrame(rows), {"house": "h1"})
        return [(Path(folder) / "x.parquet").read_bytes()]


def configs():
    config = shipped_config()
    return [json.dumps(config).encode(), yaml.safe_dump(config).encode()]


def read_config(path):
    try:
        document = yaml.load(path.read_bytes(), Loader=yaml.CSafeLoader)
    except (yaml.YAMLError, ValueError, RecursionError):
        return None  # Snakemake reads the file and says so itself
    if isinstance(document, dict):
        check_config(document)
    return document if isinstance(document, dict) else None


def saved(image, kind="PNG", **options):
    buffer = io.BytesIO()
    image.save(buffer, kind, **options)
    return buffer.getvalue()


def zipped(entries):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in entries.items():
            archive.writestr(name, content)
    return buffer.getvalue()


def as_json(value):
    return [json.dumps(value).encode()]


def pictures():
    image = Image.fromarray((np.arange(48 * 40 * 3) % 251).astype(np.uint8).reshape(40, 48, 3))
    exif = Image.Exif()
    exif[0x0112] = 6
    exif.get_ifd(0x8769)[0xA405] = 24
    found = [saved(image, "JPEG", exif=exif), saved(image, exif=exif), saved(image, "GIF")]
    found += [saved(image, "WEBP", lossless=True), saved(image, "TIFF", compression="tiff_lzw")]
    found.append(saved(image, "TIFF", exif=exif))
    for mode in ("L", "RGBA", "P", "CMYK", "I;16", "1", "LA"):
        other = Image.new(mode, (40, 40)) if mode == "I;16" else image.convert(mode)
        found.append(saved(other, "TIFF" if mode == "CMYK" else "PNG"))
    return found


def masks():
    labels = Image.fromarray((np.arange(1600) % 4).astype(np.uint8).reshape(40, 40))
    return [saved(labels), *pictures()[6:9]]


def crops():
    return [saved(Image.new("RGB", (128, 128), (9, 99, 199)))]


def read_picture(path):
    image = read_photo(path)
    assert image.dtype == np.uint8 and image.shape[2:] == (3,) and max(image.shape) <= 1600
    image_from_bytes(path.read_bytes())
    return read_exif_focal(path, image.shape[:2])


def read_crop(path):
    folder = path.parent / "crops" / "wall"
    folder.mkdir(parents=True, exist_ok=True)
    path.replace(folder / "p_0_crop0.png")
    out = CropFiles(*(path.parent / f"written_{k}" for k in range(5)))
    made = read_precomputed_crops(house(), {"p.jpg": ["living"]}, folder.parent)
    write_crops(made, out, dataset="d", house_id=house().id)


def read_texture(path):
    folder = path.parent / "library" / "wood"
    folder.mkdir(parents=True, exist_ok=True)
    path.replace(folder / "a.png")
    return load_texture_folder(folder.parent, size_px=64)


def weights():
    state = {name: torch.ones(shape) for name, shape in SHAPES.items()}
    header = {"format": "plan2scene", "architecture": json.dumps({"inputs": 3, "outputs": 2})}
    return [save(state, metadata=header), save(state)]


def read_weights(path):
    read_model_arrays(path)
    state, architecture = load_model_file(path)

    def build(inputs, outputs):
        return torch.nn.Linear(inputs, outputs)

    return dict(filled(lambda: build(**architecture), state, "a layer", path).state_dict())


def checkpoints():
    found = []
    for legacy in (True, False):
        buffer = io.BytesIO()
        state = {name: torch.ones(shape) for name, shape in SHAPES.items()}
        document = {"model_state_dict": state, "epoch": 3, "loss": np.float64(1)}
        torch.save(document, buffer, _use_new_zipfile_serialization=not legacy)
        found.append(buffer.getvalue())
    return found


def read_released(path):
    return fitted_state(state_dict_of(read_checkpoint(path), path), SHAPES, path)


DOOR = {"kind": "door", "from": [1, 0], "to": [2, 0], "bottom": 0, "top": 2}
BOXES = {"objects": [{"type": "bed", "bound_box": {"p1": [1, 1], "p2": [2, 2.5]}}]}
UNOBSERVED = {"0.0": [], "0.6": ["a.jpg", "b.jpg"], "1": ["c.jpg"]}
CAMERA = {"width": 40, "height": 30, "focal_px": 30.5, "cx": 19.5, "cy": 14.5, "located": 0.9}
CAMERA |= {"rotation": [[1, 0, 0], [0, -1, 0], [0, 0, -1]], "focal_source": "exif"}
CAMERA |= {"confidence": 0.5, "fallback": False, "room_id": "living", "position": [1, 1.6, 1]}
TILE = {"size_m": 2.0, "observed": True, "substance": "wood", "source": "crop", "crops": ["a"]}
TILE |= {"material": "floor-1", "origin_m": [0.5, 0], "evidence": {"photos": ["a"], "like": None}}
MAP = {"origin_m": [0, 0], "extent_m": [2, 3.5], "px_per_m": 100, "pattern": "planks"}
#: A good example of every form of what stages leave.
LEFT = {
    "cameras": {"a.jpg": CAMERA, "b.jpg": CAMERA | {"room_id": None, "rooms": {"hall": 0.5}}},
    "kinds": {"source": "embedded", "photos": {"a.jpg": [0.5, 0.1, 0.1, 0.1, 0.1, 0.1]}},
    "spots": [["a.jpg", "b.jpg", 3]],
    "likeness": [["a.jpg", "b.jpg", -0.25]],
    "warnings": ["photo a.jpg left out: no picture"],
    "photo_rooms": {"a.jpg": ["living", "hall"]},
    "light": {"gains": {"a.jpg": [1.1, 1.0, 0.9]}},
    "textures": {"method": "crop", "surfaces": {"living/floor": TILE}},
    "maps": {"surfaces": {"living/floor": MAP}},
    "doors": {"": [90, 60, 30], "d1": [255, 255, 255]},
    "trim": {"": [90, 60, 30], "hall": [0, 0, 0]},
    "sheet": {"house": "h1", "photos": ["photo_1.jpg"], "methods": ["crop"]},
}


RUN = {"state": "failed", "settings": {"method": "crop"}, "fault": "disk", "pid": 1, "born": 1.0}


def read_studio(path):
    return json.dumps(Project(path.parent).state())


def read_run(path):
    found = status(Project(path.parent))
    assert isinstance(found["state"], str), found
    assert isinstance(found["settings"], dict), found


def read_left(path):
    found = read_stage_json(path, path.stem)
    if path.stem == "cameras":
        read_poses(path)
    if path.stem in ("textures", "maps", "doors"):
        for form in {"textures", "maps", "doors"} - {path.stem}:
            write_json(path.with_name(f"{form}.json"), LEFT[form])
        for suffix in (".png", ".jpg"):
            path.with_name(f"living_floor{suffix}").write_bytes(crops()[0])
        textured(path.parent, house())
    return found


ASSIGNMENTS = [b"room_id,photo\nliving,a.jpg\nhall,b.jpg\n", b'photo,"roomId",x\n"a.jpg",hall,1\n']
TABLE = "house\tsplit\tplan\tassignment\tphotos\nh1\ttest\tp.json\ta.csv\ta.jpg|b.jpg\n"

READERS = (
    Reader("plan.json", own_plans, read_any_plan),
    Reader("scene.json", scenes, read_any_plan),
    Reader("plan.txt", raster_plans, read_any_plan),
    Reader("plan.svg", drawings, read_any_plan),
    Reader("scan.json", scans, read_any_plan),
    Reader("home.sh3d", homes, read_any_plan),
    Reader("zind_data.json", layouts, read_any_plan),
    Reader("plan.dxf", lambda: [dxf(20, "WALL")], read_any_plan),
    Reader("plan.ifc", models, read_any_plan),
    Reader("boxes.json", lambda: as_json(BOXES), lambda path: add_object_boxes(house(), path)),
    Reader("table.csv", lambda: ASSIGNMENTS, lambda path: read_assignment(path, house())),
    Reader("houses.tsv", lambda: [TABLE.encode()], read_table),
    Reader("unobserved_photos.json", lambda: as_json(UNOBSERVED), read_unobserved),
    Reader("config.yaml", configs, read_config),
    Reader("photo.jpg", pictures, read_picture),
    Reader("mask.png", masks, lambda path: labels_from_folder(path.parent, "mask.jpg", (40, 40))),
    Reader("crop.png", crops, read_crop),
    Reader("texture.png", pictures, read_texture),
    Reader("crops.parquet", parquets, read_parquet),
    Reader("model.safetensors", weights, read_weights),
    Reader("checkpoint.pt", checkpoints, read_released),
    Reader("studio.json", lambda: as_json({"photos": ["a.jpg"], "place": None}), read_studio),
    Reader("run.json", lambda: as_json(RUN), read_run),
    *(Reader(f"{f}.json", lambda f=f: as_json(LEFT[f]), read_left) for f in FORMS),
)

#: What tends to hurt readers of text, of bytes, and of JSON.
WORDS = [b"", *rb"""0 -1 1e308 1e400 NaN nan inf null true " { } [ ] , ; ' \ | %s CON""".split()]
WORDS += [b"\t", b"\n", b"\r", b"\x00", b"\xff", b"\xef\xbb\xbf", b"../../x", b"/etc/passwd"]
WORDS += [b"{house}", b"\xe2\x80\xa8", b"\xed\xa0\x80", b"\\ud800", b"&a [*a]"]
WORDS += [b"9" * 400, b"a" * 400, b"[" * 3000, b"!!python/object:os.system"]
DIGITS = [b"0", b"-1", b"1e20", b"1e308", b"0.001", b"999999999", b"3.5", b"7", b"nan"]
NUMBERS = [struct.pack("<I", value) for value in (0xFFFFFFFF, 1 << 20)]
NUMBERS += [struct.pack(">I", 0x7FFFFFFF), struct.pack("<Q", 2**63)]
NUMBERS += [struct.pack("<H", 0xFFFF), struct.pack(">H", 0)]
NUMBERS += [struct.pack("<f", float(value)) for value in ("nan", "inf")]
VALUES = [None, True, 0, -1, 1e308, 10**400, 0.001, 1000, 2**63, "x", "", "..", "\ud800", "living"]
VALUES += ["CON", "a" * 400, [], {}, [1], [[1]], {"a": 1}, [None] * 50]


def places(value):
    """Return (container, key) of everything inside a JSON value."""
    keys = value if isinstance(value, dict) else range(len(value))
    found = []
    for key in keys:
        found.append((value, key))
        if isinstance(value[key], dict | list):
            found += places(value[key])
    return found


def _other_values(draw, data):
    document = json.loads(data)
    for _ in range(draw(st.integers(1, 3))):
        found = places(document)
        if not found:
            break
        container, key = found[draw(st.integers(0, len(found) - 1))]
        way = draw(st.integers(0, 3))
        if way == 0:
            del container[key]
        elif way == 1 and isinstance(container, list):
            container.append(json.loads(json.dumps(container[key])))
        elif way == 2 and isinstance(container[key], int | float):
            container[key] = draw(st.floats(width=32) | st.integers(-10, 10))
        else:
            container[key] = json.loads(json.dumps(draw(st.sampled_from(VALUES))))
    return json.dumps(document).encode()


def _other_numbers(draw, data):
    for _ in range(draw(st.integers(1, 3))):
        found = [match.span() for match in re.finditer(rb"-?\d+(?:\.\d*)?", data)]
        if not found:
            break
        start, end = found[draw(st.integers(0, len(found) - 1))]
        data = data[:start] + draw(st.sampled_from(DIGITS)) + data[end:]
    return data


def _other_bytes(draw, data):
    """Return bytes that are cut, changed, repeated or have odd words put in."""
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, len(data)))
        end = min(len(data), at + draw(st.sampled_from([0, 1, 2, 4, 8, 60])))
        way = draw(st.integers(0, 5))
        new, after = b"", data[end:]
        if way == 0:
            after = b""
        elif way == 2:
            new = data[at:end] * (1 + draw(st.sampled_from([1, 3, 500])))
        elif way == 3:
            new = draw(st.sampled_from(WORDS))
        elif way == 4:
            new, after = draw(st.sampled_from(NUMBERS)), data[at + 4 :]
        elif way == 5:
            new = draw(st.binary(max_size=8))
        data = data[:at] + new + after
    return data


@cache
def _examples(reader):
    """Return a reader's examples, made once: a DXF holds the time at which it was written."""
    return reader.examples()


@st.composite
def foreign_bytes(draw, reader):
    """Return what a stranger may hand over as a file of a reader's kind."""
    data = draw(st.sampled_from(_examples(reader)))
    way = draw(st.integers(0, 9))
    if way == 0:
        return draw(st.binary(max_size=200))
    if way <= 6 and data.lstrip()[:1] == b"{":
        return _other_values(draw, data)
    if way <= 8 and zipfile.is_zipfile(io.BytesIO(data)) and b"Home.xml" in data:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            entries = {name: archive.read(name) for name in archive.namelist()}
        first = next(iter(entries))
        entries[first] = draw(st.sampled_from([_other_bytes, _other_numbers]))(draw, entries[first])
        return zipped(entries)
    if way <= 4 and b"\x00" not in data:
        return _other_numbers(draw, data)
    return _other_bytes(draw, data)


def outcome(reader, data, folder):
    """Return "read", "one line" or "unforeseen"; raise for anything else that a reader does.

    Unforeseen is one line that stands for an exception which the reader did not expect.
    `folder` is empty before and after: what a reader writes must lie in it.
    """
    path = folder / reader.name
    path.write_bytes(data)
    try:
        found = list(numbers(reader.read(path)))
        assert np.isfinite(found).all(), "a number that is not finite, without a word"
    except InputError as fault:
        assert re.fullmatch(r"[^\n\r]*expected [^\n\r]+, found [^\n\r]*", str(fault)), str(fault)
        assert len(str(fault)) < 1500, str(fault)
        str(fault).encode()
        return "one line" if fault.__cause__ is None else "unforeseen"
    return "read"
