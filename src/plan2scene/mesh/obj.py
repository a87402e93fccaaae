"""Wavefront OBJ with MTL and texture files, for programs that do not read glTF."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from plan2scene.house import House, SurfaceKey
from plan2scene.io import atomic_directory, atomic_path
from plan2scene.mesh.glb import GLASS
from plan2scene.mesh.house_mesh import build_parts
from plan2scene.mesh.parts import MeshPart
from plan2scene.mesh.textures import UNTEXTURED, TileTexture


def write_obj(
    house: House,
    textures: Mapping[SurfaceKey, TileTexture],
    path: str | Path,
    parts: Sequence[MeshPart] | None = None,
) -> None:
    """Write ``{name}.obj`` with ``{name}.mtl`` and ``{name}_textures/*.png`` beside it.

    Metres, y up, one object per part. OBJ's v axis runs up the image, so v is negated. Plain
    parts have one material per vertex colour, as OBJ has no standard for vertex colours.

    Parameters
    ----------
    house : House
    textures : mapping of SurfaceKey to TileTexture
    path : path
        The .obj file; the MTL and textures are named after it.
    parts : sequence of MeshPart, optional
        What :func:`~plan2scene.mesh.build_parts` returned, when at hand.
    """
    target = Path(path)
    parts = build_parts(house) if parts is None else parts
    folder = target.with_name(f"{target.stem}_textures")
    with atomic_directory(folder) as temporary:
        for key, tile in textures.items():
            (temporary / f"{key.filename}.png").write_bytes(tile.png)
    materials: dict[str, list[str]] = {}
    lines = [f"mtllib {target.stem}.mtl"]
    offset = 1
    for part in parts:
        lines += _part_lines(part, textures, offset, folder.name, materials)
        offset += len(part.vertices)
    with atomic_path(target.with_suffix(".mtl")) as temporary:
        entries = (f"newmtl {name}\n" + "\n".join(rows) for name, rows in materials.items())
        temporary.write_text("\n\n".join(entries) + "\n", encoding="utf-8")
    with atomic_path(target) as temporary:
        temporary.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _part_lines(
    part: MeshPart,
    textures: Mapping[SurfaceKey, TileTexture],
    offset: int,
    folder: str,
    materials: dict[str, list[str]],
) -> list[str]:
    """Return a part's OBJ lines; adds the materials it needs."""
    tile = None if part.surface is None else textures.get(part.surface)
    uv = np.zeros((len(part.vertices), 2)) if part.uv is None else part.uv
    uv = uv if tile is None or part.uv is None else tile.turns(uv)
    lines = [f"o {part.name}"]
    lines += [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in part.vertices]
    lines += [f"vt {u:.6f} {-v:.6f}" for u, v in uv]
    lines += [f"vn {x:.5f} {y:.5f} {z:.5f}" for x, y, z in part.normals]
    current = ""
    for face in part.faces:
        name = _material(part, int(face[0]), tile, folder, materials)
        if name != current:
            lines.append(f"usemtl {name}")
            current = name
        lines.append("f " + " ".join(f"{k + offset}/{k + offset}/{k + offset}" for k in face))
    return lines


def _material(
    part: MeshPart,
    vertex: int,
    tile: TileTexture | None,
    folder: str,
    materials: dict[str, list[str]],
) -> str:
    """Return the name of a face's material, made on first use."""
    if part.material == "glass":
        name, rows = "glass", [f"Kd {GLASS[0]} {GLASS[1]} {GLASS[2]}", f"d {GLASS[3]}"]
    elif part.surface is not None and tile is not None:
        name = part.surface.filename
        rows = ["Kd 1 1 1", f"map_Kd {folder}/{name}.png"]
    else:
        colour = (
            UNTEXTURED[part.surface.surface]
            if part.surface is not None
            else tuple(int(c) for c in part.colours[vertex])  # type: ignore[index]
        )
        name = "plain_{:02x}{:02x}{:02x}".format(*colour)
        rows = ["Kd {:.4f} {:.4f} {:.4f}".format(*(c / 255 for c in colour))]
    materials.setdefault(name, ["Ka 0 0 0", *rows, "illum 1"])
    return name
