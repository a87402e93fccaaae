"""The exporters by name, and the stage that runs one; each is imported when it is used."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from plan2scene.errors import InputError

if TYPE_CHECKING:
    from plan2scene.house import House, SurfaceKey
    from plan2scene.mesh.textures import TileTexture

    Write = Callable[[House, dict[SurfaceKey, TileTexture], Path], None]


@dataclass(frozen=True)
class Export:
    """A form that other programs read.

    Attributes
    ----------
    writer : callable
        Returns the function that, given a house, its textures and an existing folder, writes the
        files into it.
    files : tuple of str
        What it writes, folders as ``name/``.
    purpose : str
        For whom, in a few words.
    storey_files : tuple of str
        What it writes for each level above the lowest, ``{level}`` for its id.
    """

    writer: Callable[[], Write]
    files: tuple[str, ...]
    purpose: str
    storey_files: tuple[str, ...] = ()


def _usd() -> Write:
    from plan2scene_app.exports.usd import write_usd

    return write_usd


def _simulator() -> Write:
    from plan2scene_app.exports.simulator import write_simulator

    return write_simulator


def _ifc() -> Write:
    from plan2scene_app.exports.ifc import write_ifc

    return write_ifc


def _map() -> Write:
    from plan2scene_app.exports.occupancy import write_map

    return write_map


def _obj() -> Write:
    from plan2scene.mesh.obj import write_obj

    return lambda house, textures, folder: write_obj(house, textures, folder / "house.obj")


EXPORTS: Mapping[str, Export] = {
    "usd": Export(
        _usd, ("house.usdz", "house.usdc", "textures/"), "USD with materials, labels, collision"
    ),
    "sim": Export(
        _simulator,
        (
            "house.glb",
            "collision.glb",
            "semantic.glb",
            "semantic.txt",
            "house.stage_config.json",
            "house.xml",
        ),
        "simulators: collision, semantics, Habitat, MuJoCo",
    ),
    "ifc": Export(_ifc, ("house.ifc",), "IFC4: spaces, slabs, walls, doors, windows"),
    "map": Export(
        _map,
        ("map.pgm", "map.yaml"),
        "occupancy map for ROS, 5 cm",
        ("map_{level}.pgm", "map_{level}.yaml"),
    ),
    "obj": Export(
        _obj, ("house.obj", "house.mtl", "house_textures/"), "Wavefront OBJ with textures"
    ),
}


def export_house(
    scene_json: str | Path,
    textures_dir: str | Path,
    folder: str | Path,
    name: str,
    *,
    house_id: str,
    objects: bool = True,
) -> list[Path]:
    """Write a house in one form into a folder; return the files and folders written.

    Parameters
    ----------
    scene_json : path
        The normalised plan.
    textures_dir : path
        A method's tiles with ``textures.json``.
    folder : path
        Made when it is not there; files in it of the same names are replaced.
    name : str
        One of :data:`EXPORTS`.
    house_id : str
    objects : bool
        Whether the plan's fixed objects are in it.

    Raises InputError for an unknown name, an unreadable plan, or a package that is missing.
    """
    from plan2scene.mesh.textures import textured
    from plan2scene.plans import read_scene_json

    if name not in EXPORTS:
        raise InputError(f"one of {', '.join(EXPORTS)}", repr(name), house=house_id)
    house, textures = textured(textures_dir, read_scene_json(scene_json, house_id))
    house = house if objects else replace(house, icons=())
    target = Path(folder)
    target.mkdir(parents=True, exist_ok=True)
    EXPORTS[name].writer()(house, textures, target)
    export = EXPORTS[name]
    own = [f.format(level=level.id) for level in house.levels[1:] for f in export.storey_files]
    return [target / file for file in (*export.files, *own)]
