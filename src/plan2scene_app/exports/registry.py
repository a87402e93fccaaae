"""The exports by name, and the function that writes one.

An export is an entry point of the group :data:`GROUP` that names an :class:`Export`. Its writer
imports the packages that it needs only when it runs.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from plan2scene.errors import InputError
from plan2scene.io import read_json, write_json
from plan2scene.plugins import installed, plugins

if TYPE_CHECKING:
    from plan2scene.house import House, SurfaceKey
    from plan2scene.mesh.texture_files import TileTexture

    Textures = dict[SurfaceKey, TileTexture]
    Write = Callable[[House, Textures, Path], None]

#: File in an export's folder that lists the files that exports wrote there.
RECORD = ".export.json"
#: Entry points of this group name an :class:`Export`.
GROUP = "plan2scene.exports"


@dataclass(frozen=True)
class Export:
    """A format of houses that other programs read.

    Attributes
    ----------
    name : str
        Name of the format on the command line and in the workflow.
    write : callable
        Writes the files of a house and its textures into an existing folder.
    files : tuple of str
        Names of the files that it writes; folders as ``name/``.
    purpose : str
        What the format is for, in a few words.
    storey_files : tuple of str
        Names of the files for each level above the lowest; ``{level}`` is replaced by its id.
    needs : str
        Requirement that pip must install in addition to the package's dependencies; empty for none.
    """

    name: str
    write: Write
    files: tuple[str, ...]
    purpose: str
    storey_files: tuple[str, ...] = ()
    needs: str = ""


def exports() -> dict[str, Export]:
    """Return the exports of all installed packages by name."""
    return plugins(GROUP, Export)


def _usd(house: House, textures: Textures, folder: Path) -> None:
    from plan2scene_app.exports.usd import write_usd

    write_usd(house, textures, folder)


def _simulator(house: House, textures: Textures, folder: Path) -> None:
    from plan2scene_app.exports.simulator import write_simulator

    write_simulator(house, textures, folder)


def _ifc(house: House, textures: Textures, folder: Path) -> None:
    from plan2scene_app.exports.ifc4 import write_ifc

    write_ifc(house, textures, folder)


def _map(house: House, textures: Textures, folder: Path) -> None:
    from plan2scene_app.exports.occupancy import write_map

    write_map(house, textures, folder)


def _plan(house: House, textures: Textures, folder: Path) -> None:
    from plan2scene_app.exports.plan_sheet import write_plan

    write_plan(house, textures, folder)


def _obj(house: House, textures: Textures, folder: Path) -> None:
    from plan2scene_app.exports.obj import write_obj

    write_obj(house, textures, folder / "house.obj")


def _home_assistant(house: House, textures: Textures, folder: Path) -> None:
    from plan2scene_app.exports.home_assistant import write_home_assistant

    write_home_assistant(house, textures, folder)


HOME_ASSISTANT = Export(
    "homeassistant",
    _home_assistant,
    ("house.obj", "house.mtl", "house_textures/", "card.yaml"),
    "Home Assistant: floor3d-card with a light a room",
)
USD = Export(
    "usd",
    _usd,
    ("house.usdz", "house.usdc", "textures/"),
    "USD with materials, labels, collision",
    needs="plan2scene[exports]",
)
SIM = Export(
    "sim",
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
)
IFC = Export(
    "ifc",
    _ifc,
    ("house.ifc",),
    "IFC4: spaces, slabs, walls, doors, windows",
    needs="plan2scene[exports]",
)
MAP = Export(
    "map",
    _map,
    ("map.pgm", "map.yaml"),
    "occupancy map for ROS, 5 cm",
    ("map_{level}.pgm", "map_{level}.yaml"),
)
PLAN = Export(
    "plan",
    _plan,
    ("plan.pdf", "plan.svg"),
    "dimensioned plan to print, PDF and SVG",
    ("plan_{level}.svg",),
)
OBJ = Export(
    "obj", _obj, ("house.obj", "house.mtl", "house_textures/"), "Wavefront OBJ with textures"
)


def export_house(
    scene_json: str | Path,
    textures_dir: str | Path,
    folder: str | Path,
    name: str,
    *,
    house_id: str,
    objects: bool = True,
) -> list[Path]:
    """Write a house in one format into a folder; return the files and folders written.

    Parameters
    ----------
    scene_json : path
        The normalised plan.
    textures_dir : path
        A method's tiles with ``textures.json``.
    folder : path
        It is made if it does not exist. Files of an earlier export in it are replaced.
    name : str
        One of :func:`exports`.
    house_id : str
    objects : bool
        Whether the export includes the plan's fixed objects.

    Raises InputError for an unknown name, an unreadable plan, a missing package, or a folder that
    has files of the same names that no export wrote.
    """
    from plan2scene.mesh.texture_files import textured
    from plan2scene.plans.scene_json import read_scene_json

    if name not in exports():
        raise InputError(f"one of {', '.join(exports())}", repr(name), house=house_id)
    export = exports()[name]
    house, textures = textured(textures_dir, read_scene_json(scene_json, house_id))
    house = house if objects else replace(house, icons=())
    target = Path(folder)
    level_files = [
        f.format(level=level.id) for level in house.levels[1:] for f in export.storey_files
    ]
    files = [target / file for file in (*export.files, *level_files)]
    record = target / RECORD
    _refuse_users_files(files, record)
    target.mkdir(parents=True, exist_ok=True)
    with installed(export.needs, house_id):
        export.write(house, textures, target)
    written = {path.relative_to(target).as_posix() for path in _contents(files)}
    write_json(record, {"files": sorted(written | _recorded(record))})
    return files


def _contents(paths: Sequence[Path]) -> Iterator[Path]:
    """Yield the existing files and links among some paths, including those inside folders."""
    for path in paths:
        if path.is_dir() and not path.is_symlink():
            yield from _contents(sorted(path.iterdir()))
        elif os.path.lexists(path):
            yield path


def _recorded(record: Path) -> set[str]:
    """Return the names of the files that earlier exports wrote."""
    content = read_json(record) if record.is_file() else {}
    names = content.get("files") if isinstance(content, dict) else None
    return {str(name) for name in names} if isinstance(names, list) else set()


def _refuse_users_files(files: Sequence[Path], record: Path) -> None:
    """Raise InputError if an export would replace a file that no export wrote."""
    known = _recorded(record)
    for path in _contents(files):
        if path.relative_to(record.parent).as_posix() not in known:
            expected = "an --out folder without files of yours"
            raise InputError(expected, path.name, file=record.parent)
