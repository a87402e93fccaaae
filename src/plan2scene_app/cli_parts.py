"""Commands for parts of the work alone: labels, tiles, metrics, released weights."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Annotated

import typer

from plan2scene.errors import InputError
from plan2scene.textures.methods import methods_table, texture_methods

parts = typer.Typer()


def known_method(name: str) -> str:
    """Return the name of a registered texture method; refuse another one."""
    if name not in texture_methods():
        raise typer.BadParameter(f"{name!r} is not one of {', '.join(texture_methods())}")
    return name


def method_names() -> str:
    """Return the names of the texture methods as help shows them, those added since included."""
    return f"[{'|'.join(texture_methods())}]"


@parts.command("masks")
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
            write_png(target, label.labelled(photo.name, image, exif=exif).labels)
            print(target)
        except InputError as error:
            print(f"ERROR {error}", file=sys.stderr)
            failed += 1
    if failed:
        raise typer.Exit(1)


@parts.command("texture")
def make_texture(
    crops: Annotated[list[Path], typer.Argument(help="Crops of one surface.")],
    out: Annotated[Path, typer.Option(help="The tile (PNG).")],
    method: Annotated[
        str, typer.Option(parser=known_method, metavar=method_names(), help="How the tile is made.")
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


@parts.command("methods")
def list_methods() -> None:
    """List the texture methods as a Markdown table."""
    print(methods_table(), end="")


@parts.command("metrics")
def compare(prediction: Path, reference: Path) -> None:
    """Print COLOR, FREQ, TILE (of the prediction) and SUBS of a texture against a reference."""
    from plan2scene.evaluation.measure import pair_metrics
    from plan2scene.images import read_image

    print(json.dumps(pair_metrics(read_image(prediction), read_image(reference))))


@parts.command("convert-checkpoint")
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
    from plan2scene.propagation.networks import load_propagation

    keep_inputs(out, [checkpoint, *([means] if means else [])])
    convert_checkpoint(
        network,
        checkpoint,
        out,
        substances=[name.strip() for name in substances.split(",")],
        means=load_propagation(means)[1] if means else None,
    )
    print(out)
