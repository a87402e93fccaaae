"""The command line: thin, over the same library and workflow (``plan2scene --help``)."""

from __future__ import annotations

import json
import logging
import re
import sys
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from plan2scene.errors import InputError, WorkflowError, system_fault
from plan2scene.exports.registry import EXPORTS, export_house
from plan2scene.textures.methods import METHODS, methods_table

app = typer.Typer(no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False)


def _method(name: str) -> str:
    """Return the name of a registered texture method; refuse another one."""
    if name not in METHODS:
        raise typer.BadParameter(f"{name!r} is not one of {', '.join(METHODS)}")
    return name


class Colours(StrEnum):
    """Whose colours a house shows."""

    PHOTO = "photo"
    CORRECTED = "corrected"


_HouseId = Annotated[str | None, typer.Option(help="House id; default: the plan's name.")]
_Scale = Annotated[float | None, typer.Option(min=1e-6, help="Metres of a pixel or drawing unit.")]


def _method_names() -> str:
    """Return the names of the texture methods as help shows them, those added since included."""
    return f"[{'|'.join(METHODS)}]"


def _house_id(plan: Path, given: str | None) -> str:
    """Return the house id: the one given, else made of the plan's file name."""
    own = re.sub(r"[^A-Za-z0-9_.-]+", "_", plan.name.split(".")[0]).lstrip(".-")
    # Of a name in other letters nothing that people could read is left.
    name = given or (own if re.search("[A-Za-z0-9]", own) else "house")
    if not re.fullmatch(r"[A-Za-z0-9_][A-Za-z0-9_.-]*", name):
        raise InputError("a house id of letters, digits, '_', '.', '-'", repr(name))
    return name


@app.command("run")
def run_house(
    plan: Annotated[Path, typer.Option(help="Floorplan in any format that is read.")],
    out: Annotated[Path, typer.Option(help="Folder for the results.")],
    photos: Annotated[Path | None, typer.Option(help="CSV table: room_id, photo.")] = None,
    photos_dir: Annotated[
        Path | None, typer.Option(help="Folder of the photos; default: beside the table.")
    ] = None,
    method: Annotated[
        str, typer.Option(parser=_method, metavar=_method_names(), help="How textures are made.")
    ] = "exemplar",
    cores: Annotated[int, typer.Option(min=1)] = 2,
    house: _HouseId = None,
    metres_per_pixel: _Scale = None,
    texture_size: Annotated[int, typer.Option(help="128, 256 or 512 pixels a tile.")] = 128,
    seed: Annotated[int, typer.Option(min=0)] = 0,
    colours: Annotated[
        Colours, typer.Option(help="As the photos show them, or under one light for the house.")
    ] = Colours.PHOTO,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress.")] = False,
    verbose: Annotated[
        bool, typer.Option("--verbose", "-v", help="All that Snakemake says.")
    ] = False,
) -> None:
    """Make one textured house from a plan and photos."""
    from plan2scene.run import SingleHouse, run

    shown = "quiet" if quiet else "verbose" if verbose else "lines"

    request = SingleHouse(
        plan=plan,
        photo_table=photos,
        photos_dir=photos_dir,
        house=_house_id(plan, house),
        method=method,
        metres_per_pixel=metres_per_pixel,
        seed=seed,
        texture_size=texture_size,
        colours=colours.value,
    )
    for name, path in run(request, out, cores=cores, shown=shown).items():
        print(f"{name}: {path}")


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
    from plan2scene.images import is_label_image, read_image, write_png
    from plan2scene.io import keep_inputs
    from plan2scene.photos.camera.exif import read_exif_focal
    from plan2scene.photos.labels.labeller import labeller
    from plan2scene.weights import MODELS

    targets = [out / f"{photo.stem}.png" for photo in photos]
    for i, target in enumerate(targets):
        if target in targets[:i]:
            raise InputError("photos of different names", f"{photos[i].stem} twice", file=photos[i])
        keep_inputs(target, photos)
        if target.exists() and not is_label_image(target):
            raise InputError("a folder without other pictures", target.name, file=out)
    weights = model or MODELS / "segmentation.safetensors"
    label = labeller("embedded", model=weights, openings=openings)
    failed = 0
    for photo, target in zip(photos, targets, strict=True):
        try:
            image = read_image(photo)
            exif = read_exif_focal(photo, (image.shape[0], image.shape[1]))
            write_png(target, label.labels(photo.name, image, exif=exif))
            print(target)
        except InputError as error:
            print(f"ERROR {error}", file=sys.stderr)
            failed += 1
    if failed:
        raise typer.Exit(1)


@app.command("texture")
def make_texture(
    crops: Annotated[list[Path], typer.Argument(help="Crops of one surface.")],
    out: Annotated[Path, typer.Option(help="The tile (PNG).")],
    method: Annotated[
        str, typer.Option(parser=_method, metavar=_method_names(), help="How the tile is made.")
    ] = "exemplar",
    size: Annotated[int, typer.Option(min=64, max=1024, help="Pixels of the tile.")] = 128,
    seed: Annotated[int, typer.Option(min=0)] = 0,
) -> None:
    """Make one seamless tile from crops of one surface."""
    from plan2scene.images import read_image, write_png
    from plan2scene.io import keep_inputs
    from plan2scene.textures.single import tile_from_crops

    keep_inputs(out, crops)
    images = [read_image(path) for path in crops]
    write_png(out, tile_from_crops(images, method, size_px=size, seed=seed))
    print(out)


@app.command("methods")
def list_methods() -> None:
    """List the texture methods as a Markdown table."""
    print(methods_table(), end="")


@app.command("metrics")
def compare(prediction: Path, reference: Path) -> None:
    """Print COLOR, FREQ, TILE (of the prediction) and SUBS of a texture against a reference."""
    from plan2scene.images import read_image
    from plan2scene.metrics.pair import pair_metrics

    print(json.dumps(pair_metrics(read_image(prediction), read_image(reference))))


@app.command("check")
def check(
    target: Annotated[Path, typer.Argument(help="A data set's folder, or a plan.")],
    metres_per_pixel: _Scale = None,
) -> None:
    """Tell what would go wrong, before anything runs."""
    from plan2scene.datasets.check import check_dataset, check_plan

    if not target.exists():
        raise InputError("a data set's folder or a plan", "no such file or folder", file=target)
    if target.is_dir():
        problems = check_dataset(target, metres_per_pixel=metres_per_pixel)
    else:
        house, problems = check_plan(target, _house_id(target, None), metres_per_pixel)
        if house is not None:
            print(f"{len(house.rooms)} rooms, {len(house.walls)} walls, {len(house.doors)} doors")
    for problem in problems:
        print(problem)
    print(f"{len(problems)} problems" if problems else "no problems")
    if any(problem.level == "error" for problem in problems):
        raise typer.Exit(1)


@app.command("import")
def import_plan_file(
    plan: Path,
    out: Annotated[Path, typer.Option(help="The scene.json to write.")],
    metres_per_pixel: _Scale = None,
    house: _HouseId = None,
) -> None:
    """Convert any supported plan to scene.json."""
    from plan2scene.datasets.import_plan import import_plan
    from plan2scene.io import keep_inputs

    keep_inputs(out, [plan])
    import_plan(plan, out, house_id=_house_id(plan, house), metres_per_pixel=metres_per_pixel)
    print(out)


@app.command("edit")
def edit_plan(
    source: Annotated[
        Path | None, typer.Argument(help="A plan, or a picture of one; default: an empty page.")
    ] = None,
    out: Annotated[Path, typer.Option(help="The page (HTML) to write.")] = Path("editor.html"),
    metres_per_pixel: _Scale = None,
    house: _HouseId = None,
) -> None:
    """Write a page that draws a plan, offline: open it in a browser."""
    from plan2scene.editor import write_editor
    from plan2scene.io import keep_inputs

    keep_inputs(out, [source] if source else [])
    name = _house_id(source or Path("my_home"), house)
    write_editor(source, out, house_id=name, metres_per_pixel=metres_per_pixel)
    print(out)


@app.command("export")
def export(
    house: Annotated[Path, typer.Argument(help="What `plan2scene run` made: the folder OUT.")],
    to: Annotated[str, typer.Option(metavar=f"[{'|'.join(EXPORTS)}]", help="The form to write.")],
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
    from plan2scene.io import keep_inputs
    from plan2scene.propagation.model import load_propagation

    keep_inputs(out, [checkpoint, *([means] if means else [])])
    convert_checkpoint(
        network,
        checkpoint,
        out,
        substances=[name.strip() for name in substances.split(",")],
        means=load_propagation(means)[1] if means else None,
    )
    print(out)


def main() -> None:
    """Entry point: a fault of the input is one line on stderr and exit code 1."""
    logging.basicConfig(level=logging.WARNING, format="%(levelname)s %(message)s")
    try:
        app()
    except (InputError, WorkflowError) as error:
        print(f"ERROR {error}", file=sys.stderr)
        raise SystemExit(1) from None
    except OSError as error:
        fault = system_fault(error)
        if fault is None:
            raise
        print(f"ERROR {fault}", file=sys.stderr)
        raise SystemExit(1) from None
