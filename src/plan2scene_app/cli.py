"""The command line (``plan2scene --help``): a thin layer over the library and the workflow."""

from __future__ import annotations

import json
import logging
import re
import shlex
import sys
from collections.abc import Iterable
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from plan2scene.errors import InputError, WorkflowError, one_line_errors
from plan2scene.provenance import package_versions
from plan2scene.textures.methods import texture_methods
from plan2scene_app.exports.registry import export_house, exports

if TYPE_CHECKING:
    from plan2scene_app.run import SingleHouse

app = typer.Typer(no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False)


class Colours(StrEnum):
    """Colours of a house's surfaces: as paint without light, or as the photos show them."""

    PAINT = "paint"
    PHOTO = "photo"


class Walls(StrEnum):
    """Which walls of a house share a texture: all of a room, or accent walls have their own."""

    ROOM = "room"
    WALL = "wall"


_HouseId = Annotated[str | None, typer.Option(help="House id; default: the plan's name.")]
_Layers = Annotated[
    list[str] | None,
    typer.Option(
        "--dxf-layer",
        metavar="KIND=PATTERN",
        help="Layers of a DXF drawing that are rooms, walls, doors or windows: A-WALL*,I-WALL*.",
    ),
]
_Scale = Annotated[float | None, typer.Option(min=1e-6, help="Metres of a pixel or drawing unit.")]


def _house_id(plan: Path, chosen: str | None) -> str:
    """Return the chosen house id, or one made from the plan's file name."""
    from plan2scene_app.ids import fit_id

    name = chosen or fit_id(_house_name(plan), "house")
    if not re.fullmatch(r"[A-Za-z0-9_][A-Za-z0-9_.-]*", name):
        raise InputError("a house id of letters, digits, '_', '.', '-'", repr(name))
    return name


#: File names that say no more than that they are a plan.
_ANY_PLAN = re.compile(r"(floor|house|grund)?[ _-]*(plans?|riss|brochure|image)[ _-]*\d*", re.I)


def _house_name(plan: Path, out: Path | None = None) -> str:
    """Return the house's name: the plan's file name, or that of `out` if it is any plan's."""
    name = plan.name.split(".")[0]
    if out is not None and _ANY_PLAN.fullmatch(name):
        name = out.resolve().name or name
    shown = "".join(letter for letter in name if letter.isprintable() and letter not in "{}")
    return shown.encode("utf-8", "replace").decode()[:100]


def _layers(pairs: list[str] | None) -> dict[str, str]:
    """Parse options of the form KIND=PATTERN; return the patterns of DXF layers by kind."""
    from plan2scene_app.plan_formats.dxf import layers_of

    return layers_of(pairs or ())


def _known_method(name: str) -> str:
    """Return `name` if it is a registered texture method; raise BadParameter otherwise."""
    if name not in texture_methods():
        raise typer.BadParameter(f"{name!r} is not one of {', '.join(texture_methods())}")
    return name


_Method = Annotated[
    str,
    typer.Option(
        parser=_known_method,
        metavar=f"[{'|'.join(texture_methods())}]",
        help="How textures are made.",
    ),
]


def _print_version(asked: bool) -> None:
    if asked:
        print(package_versions("plan2scene"))
        raise typer.Exit


@app.callback()
def common(
    _: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Its version.")
    ] = False,
) -> None:
    """Make textured 3D houses from floorplans and photos."""


@app.command("run")
def run_house(
    out: Annotated[Path, typer.Option(help="Folder for the results.")],
    plan: Annotated[
        list[Path] | None,
        typer.Option(
            help="Floorplan in any format that is read. Give pictures of single storeys one by one."
        ),
    ] = None,
    photos: Annotated[
        Path | None,
        typer.Option(
            help="Folder, ZIP or PDF of photos, or CSV table: photo, and room_id where known."
        ),
    ] = None,
    photos_dir: Annotated[
        Path | None,
        typer.Option(help="Folder, ZIP or PDF of the table's photos; default: beside it."),
    ] = None,
    homes: Annotated[
        Path | None,
        typer.Option(help="Many homes: a folder with a folder or ZIP of plan and photos for each."),
    ] = None,
    method: _Method = "exemplar",
    cores: Annotated[int, typer.Option(min=1)] = 2,
    house: _HouseId = None,
    metres_per_pixel: _Scale = None,
    dxf_layer: _Layers = None,
    texture_size: Annotated[int, typer.Option(help="128, 256 or 512 pixels a tile.")] = 128,
    seed: Annotated[int, typer.Option(min=0)] = 0,
    colours: Annotated[
        Colours,
        typer.Option(help="Paint without light, or as photos show it."),
    ] = Colours.PAINT,
    fov: Annotated[
        float | None,
        typer.Option(
            min=11,
            max=149,
            help="Field of view of the photos along their longer side, degrees, where known.",
        ),
    ] = None,
    walls: Annotated[
        Walls, typer.Option(help="All of a room alike, or accent walls in their own paint.")
    ] = Walls.WALL,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress.")] = False,
    verbose: Annotated[
        bool, typer.Option("--verbose", "-v", help="All that Snakemake says.")
    ] = False,
) -> None:
    """Make a textured house from a plan and photos; with --homes, many."""
    from plan2scene_app.packed_photos import is_packed
    from plan2scene_app.run import SingleHouse, run

    printed = "quiet" if quiet else "verbose" if verbose else "lines"
    if bool(plan) == bool(homes):
        raise InputError("--plan, or --homes", "both" if plan else "neither")
    if homes and (photos or photos_dir or house or metres_per_pixel):
        expected = "--homes without --photos, --photos-dir, --house and --metres-per-pixel"
        raise InputError(expected, "one of these")
    folder = photos is not None and (photos.is_dir() or is_packed(photos))
    if folder and photos_dir is not None:
        raise InputError("a photo table with --photos-dir", "photos themselves", file=photos)
    first, *storeys = plan or [Path("plan")]
    request = SingleHouse(
        plan=first,
        storeys=tuple(storeys),
        photo_table=None if folder else photos,
        photos_dir=photos if folder else photos_dir,
        house=_house_id(first, house),
        name=house or _house_name(first, out),
        method=method,
        metres_per_pixel=metres_per_pixel,
        seed=seed,
        texture_size=texture_size,
        colours=colours.value,
        walls=walls.value,
        dxf_layers=_layers(dxf_layer),
        fov_deg=fov,
    )
    if homes:
        raise typer.Exit(_run_homes(homes, out, request, cores, printed))
    made = run(request, out, cores=cores, printed=printed)
    for name, path in made.items():
        print(f"{name}: {path}")
    pages = [str(made[name]) for name in ("viewer.html", "doubts.html") if name in made]
    if pages:
        print(f"open in a browser: {', '.join(pages)}")


def _run_homes(folder: Path, out: Path, request: SingleHouse, cores: int, printed: str) -> int:
    """Make all homes of a folder; list at the end which failed and why. Return the exit code."""
    from plan2scene_app.homes import failure_of_home, homes_in

    homes = homes_in(folder, out)
    failed = []
    for number, (name, home) in enumerate(homes.items(), 1):
        print(f"home {number} of {len(homes)}: {name}", flush=True)
        if why := failure_of_home(home, out / name, request, cores=cores, printed=printed):
            failed.append(f"{name} failed: {why}")
            print(failed[-1], flush=True)
    print(f"{len(homes) - len(failed)} of {len(homes)} homes are made in {out}", *failed, sep="\n")
    return 1 if failed else 0


@app.command("check")
def check(
    target: Annotated[
        Path, typer.Argument(help="A data set's folder, a plan, or what `plan2scene run` made.")
    ],
    metres_per_pixel: _Scale = None,
    dxf_layer: _Layers = None,
) -> None:
    """Report the problems of a data set, a plan or a home; nothing is run."""
    from plan2scene_app.check import check_dataset, check_plan
    from plan2scene_app.out_folder import DATASET_FOLDER, WORK, is_out_folder

    layers = _layers(dxf_layer)

    if not target.exists():
        raise InputError("a data set's folder or a plan", "no such file or folder", file=target)
    if is_out_folder(target):
        target = target / WORK / DATASET_FOLDER
    if target.is_dir():
        problems = check_dataset(target, metres_per_pixel=metres_per_pixel, dxf_layers=layers)
    else:
        house, problems = check_plan(target, _house_id(target, None), metres_per_pixel, layers)
        if house is not None:
            levels = f"{len(house.levels)} levels, " if house.levels else ""
            counts = f"{len(house.rooms)} rooms, {len(house.walls)} walls, {len(house.doors)} doors"
            print(f"{levels}{counts}")
    for problem in problems:
        print(problem)
    print(f"{len(problems) or 'no'} problem{'s' * (len(problems) != 1)}")
    if any(problem.level == "error" for problem in problems):
        raise typer.Exit(1)


@app.command("import")
def import_plan_file(
    plan: Path,
    out: Annotated[Path, typer.Option(help="The scene.json to write.")],
    metres_per_pixel: _Scale = None,
    dxf_layer: _Layers = None,
    house: _HouseId = None,
) -> None:
    """Convert any supported plan to scene.json."""
    from plan2scene.datasets.import_plan import import_plan

    _new_file(out, [plan])
    import_plan(
        plan,
        out,
        house_id=_house_id(plan, house),
        metres_per_pixel=metres_per_pixel,
        dxf_layers=_layers(dxf_layer),
    )
    print(out)


@app.command("edit")
def edit_plan(
    source: Annotated[
        Path | None, typer.Argument(help="A plan, or a picture of one; default: an empty page.")
    ] = None,
    out: Annotated[Path, typer.Option(help="The page (HTML) to write.")] = Path("editor.html"),
    metres_per_pixel: _Scale = None,
    dxf_layer: _Layers = None,
    house: _HouseId = None,
    trace: Annotated[bool, typer.Option(help="Trace a picture, to mend what is read.")] = True,
) -> None:
    """Write an offline page in which a plan is drawn or edited: open it in a browser."""
    from plan2scene_app.editor.editor_page import write_editor

    _keep_inputs(out, [source] if source else [])
    if out.suffix.lower() not in (".html", ".htm"):  # it may be a plan that was mended by hand
        raise InputError("a page to write, such as editor.html", out.name, file=out)
    name = _house_id(source or Path("my_home"), house)
    write_editor(
        source,
        out,
        house_id=name,
        metres_per_pixel=metres_per_pixel,
        dxf_layers=_layers(dxf_layer),
        trace=trace,
    )
    print(out)


@app.command("trace")
def trace_plan(
    picture: Annotated[Path, typer.Argument(help="Picture of a plan.")],
    out: Annotated[Path, typer.Option(help="The plan JSON to write.")],
    metres_per_pixel: Annotated[
        float | None, typer.Option(min=1e-6, help="Scale of the picture, where known.")
    ] = None,
    model: Annotated[Path | None, typer.Option(help="Other weights of the plan network.")] = None,
) -> None:
    """Read a plan from a picture; list what is uncertain, to be corrected in the editor."""
    from plan2scene_app.tracing.trace import traced_files, write_trace

    for path in traced_files(out):
        _new_file(path, [picture, *([model] if model else [])])
    plan, lines = write_trace(picture, out, metres_per_pixel=metres_per_pixel, model=model)
    for line in lines:
        print(f"doubt: {line}")
    print(
        f"{len(plan.rooms)} rooms, {len(plan.openings)} openings; "
        f"{100 * plan.file_metres:.3g} cm a pixel "
        f"({plan.scale.source}, {plan.scale.confidence:.0%} sure); {len(lines)} doubts"
    )
    for path in traced_files(out):
        print(path)
    if lines:
        print(f"to mend it: plan2scene edit {shlex.quote(str(picture))} --out editor.html")


@app.command("studio")
def open_studio(
    folder: Annotated[Path, typer.Argument(help="Where the homes are kept.")] = Path("homes"),
    port: Annotated[int, typer.Option(min=0, max=65535, help="0: any free one.")] = 8642,
    cores: Annotated[int, typer.Option(min=1)] = 2,
    browser: Annotated[bool, typer.Option(help="Open it in the browser.")] = True,
) -> None:
    """Draw, add photos, make houses and look at them in the browser, on this machine alone."""
    from plan2scene_app.studio.server import serve

    serve(folder, port=port, cores=cores, browser=browser)


@app.command("export")
def export(
    house: Annotated[Path, typer.Argument(help="What `plan2scene run` made: the folder OUT.")],
    to: Annotated[str, typer.Option(metavar=f"[{'|'.join(exports())}]", help="The form to write.")],
    out: Annotated[Path | None, typer.Option(help="Folder; default: HOUSE/FORM.")] = None,
) -> None:
    """Write a house in a form that other programs read."""
    scene, textures = house / "house.scene.json", house / "textures"
    for path in (scene, textures):
        if not path.exists():
            raise InputError("a folder made by `plan2scene run`", f"no {path.name}", file=house)
    folder = out or house / to
    for path in export_house(scene, textures, folder, to, house_id=house.resolve().name):
        print(path)


def _holds_labels(path: Path) -> bool:
    """Return whether a file is a grey image of labels 0 to 5, as ``plan2scene masks`` writes it."""
    import numpy as np

    from plan2scene.images import decode_image

    try:
        pixels = decode_image(path, lambda i: np.asarray(i) if i.mode == "L" else None)
        return pixels is not None and int(pixels.max()) <= 5
    except InputError:
        return False


@app.command("masks")
def label_photos(
    photos: Annotated[list[Path], typer.Argument(help="Photos.")],
    out: Annotated[Path, typer.Option(help="Folder for the label images.")],
    model: Annotated[Path | None, typer.Option(help="Other segmentation weights.")] = None,
    openings: Annotated[
        bool, typer.Option("--openings", help="Doors as 4 and windows as 5, not as other.")
    ] = False,
) -> None:
    """Write label images (0 other, 1 floor, 2 wall, 3 ceiling) at the photos' size."""
    from plan2scene.images import read_image, write_png
    from plan2scene.photos.camera.exif import read_exif_focal
    from plan2scene.photos.labels.labeller import labeller
    from plan2scene.weights import MODELS

    targets = [out / f"{photo.stem}.png" for photo in photos]
    for i, target in enumerate(targets):
        if target in targets[:i]:
            raise InputError("photos of different names", f"{photos[i].stem} twice", file=photos[i])
        _keep_inputs(target, photos)
        if target.exists() and not _holds_labels(target):
            raise InputError("a folder without other pictures", target.name, file=out)
    weights = model or MODELS / "segmentation.safetensors"
    label = labeller("embedded", model=weights, openings=openings)
    failed = 0
    for photo, target in zip(photos, targets, strict=True):
        try:
            image = read_image(photo)
            exif = read_exif_focal(photo, (image.shape[0], image.shape[1]))
            write_png(target, label.labelled(photo.name, image, exif=exif).labels)
            print(target)
        except InputError as error:
            print(f"ERROR {error}", file=sys.stderr)
            failed += 1
    if failed:
        raise typer.Exit(1)


@app.command("views")
def cut_views(
    photos: Annotated[list[Path], typer.Argument(help="360-degree photos (equirectangular).")],
    out: Annotated[Path, typer.Option(help="Folder for the views.")],
) -> None:
    """Cut 360-degree photos into flat views, which a photo table can name."""
    from plan2scene_app.panoramas import VIEWS, cut_panoramas, panorama_of

    for photo in photos:
        if panorama_of(photo) is None:
            raise InputError("a 360-degree photo", "a flat one", file=photo)
        for name in (f"{photo.stem}_{number}.jpg" for number in range(1, VIEWS + 1)):
            if (out / name).exists():
                raise InputError(f"a folder without {name}", "such a file", file=out)
    out.mkdir(parents=True, exist_ok=True)
    for views in cut_panoramas({photo.name: photo for photo in photos}, out).values():
        print(*views.values(), sep="\n")


@app.command("texture")
def make_texture(
    crops: Annotated[list[Path], typer.Argument(help="Crops of one surface.")],
    out: Annotated[Path, typer.Option(help="The tile (PNG).")],
    method: _Method = "exemplar",
    size: Annotated[int, typer.Option(min=64, max=1024, help="Pixels of the tile.")] = 128,
    seed: Annotated[int, typer.Option(min=0)] = 0,
) -> None:
    """Make one seamless tile from crops of one surface."""
    from plan2scene.images import read_image, write_png
    from plan2scene_app.single_tile import tile_from_crops

    _new_file(out, crops)
    images = [read_image(path) for path in crops]
    write_png(out, tile_from_crops(images, method, size_px=size, seed=seed))
    print(out)


@app.command("methods")
def list_methods() -> None:
    """List the texture methods as a Markdown table."""
    head = ("method", "observed surface", "other surface", "needs", "seams", "FID seeds")
    rows: list[tuple[str, ...]] = [head, ("---",) * len(head)]
    for method in texture_methods().values():
        needs = [f"{method.weights} weights"] * bool(method.weights)
        needs += ["tile library"] * method.library + ["crop pool"] * method.crop_pool
        needs += [method.needs] * bool(method.needs)
        seams = "corrected" if method.seam_correction else "left"
        more = "more" if method.noise else "one"
        text = (method.summary, method.unobserved, ", ".join(needs) or "crops", seams, more)
        rows.append((f"`{method.name}`", *text))
    for row in rows:
        print(f"| {' | '.join(row)} |")


@app.command("metrics")
def compare(prediction: Path, reference: Path) -> None:
    """Print COLOR, FREQ, TILE (of the prediction) and SUBS of a texture against a reference."""
    from plan2scene.evaluation.measure import image_metrics
    from plan2scene.images import metric_image, read_image
    from plan2scene.metrics.networks import substances_of
    from plan2scene.weights import MODELS

    pair = [metric_image(read_image(path)) for path in (prediction, reference)]
    first, second = substances_of(MODELS / "features.safetensors", pair)
    print(json.dumps({**image_metrics(*pair), "subs": int(first != second)}))


@app.command("convert-checkpoint")
def convert(
    network: Annotated[
        str, typer.Argument(help="One of texture, naivesynth, propagation, vgg16, inception.")
    ],
    checkpoint: Annotated[Path, typer.Argument(help="A file the paper's authors released.")],
    out: Annotated[Path, typer.Option(help="The safetensors file to write.")],
    substances: Annotated[
        str, typer.Option(help="Order of its substance classes.")
    ] = "wood,plaster,carpet,tile",
    means: Annotated[
        Path | None, typer.Option(help="Weights of a propagation network to take the means of.")
    ] = None,
) -> None:
    """Convert released weights; a file that carries code is refused."""
    from plan2scene.checkpoints.convert import convert_checkpoint
    from plan2scene.propagation.graph_networks import load_propagation

    _new_file(out, [checkpoint, *([means] if means else [])])
    convert_checkpoint(
        network,
        checkpoint,
        out,
        substances=[name.strip() for name in substances.split(",")],
        means=load_propagation(means)[1] if means else None,
    )
    print(out)


def _keep_inputs(output: Path, inputs: Iterable[Path]) -> None:
    """Raise InputError if an output is a folder or would overwrite one of the inputs."""
    if output.is_dir():
        raise InputError("a file to write", "a folder", file=output)
    for path in inputs:
        if output.resolve() == path.resolve() or (output.exists() and output.samefile(path)):
            raise InputError("an output that is no input", "the same file", file=output)


def _new_file(output: Path, inputs: Iterable[Path] = ()) -> None:
    """Raise InputError if an output exists already, is a folder, or is one of the inputs."""
    _keep_inputs(output, inputs)
    if output.exists():
        found = "one that is there: remove it, or name another"
        raise InputError("a new file to write", found, file=output)


def main() -> None:
    """Run the command line; print an input or workflow error as one line and exit with code 1."""
    logging.basicConfig(level=logging.WARNING, format="%(levelname)s %(message)s")
    try:
        with one_line_errors():
            app()
    except (InputError, WorkflowError) as error:
        print(f"ERROR {error}", file=sys.stderr)
        raise SystemExit(1) from None
