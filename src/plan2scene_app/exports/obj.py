"""Wavefront OBJ with MTL and texture files, for programs that do not read glTF; by trimesh.

This module writes the materials: those of trimesh would encode the PNG files again and have no
opacity.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
import trimesh
from trimesh.exchange.obj import export_obj
from trimesh.visual import TextureVisuals
from trimesh.visual.material import Material

from plan2scene.house import House, SurfaceKey
from plan2scene.io import atomic_directory, atomic_path
from plan2scene.mesh.assembly import assemble
from plan2scene.mesh.parts import GLASS, MeshPart
from plan2scene.mesh.texture_files import UNTEXTURED, TileTexture


def write_obj(
    house: House,
    textures: Mapping[SurfaceKey, TileTexture],
    path: str | Path,
    parts: Sequence[MeshPart] | None = None,
) -> None:
    """Write ``{name}.obj`` with ``{name}.mtl`` and ``{name}_textures/*`` beside it.

    Metres, y up, one object per part and material. OBJ's v axis runs up the image, so v is negated.
    Parts without a texture have one material per vertex colour, because vertex colours are not
    standard in OBJ.

    Parameters
    ----------
    house : House
    textures : mapping of SurfaceKey to TileTexture
    path : path
        The .obj file; the MTL and textures are named after it.
    parts : sequence of MeshPart, optional
        The parts to write; by default all parts of the house.
    """
    target = Path(path)
    folder = target.with_name(f"{target.stem}_textures")
    with atomic_directory(folder) as temporary:
        for key, tile in textures.items():
            (temporary / f"{key.filename}{tile.suffix}").write_bytes(tile.image)
    scene = _Scene()
    for part in assemble(house).parts if parts is None else parts:
        painted = None if part.surface is None else textures.get(part.surface)
        for mesh in _pieces(part, painted, folder.name):
            scene.geometry[str(len(scene.geometry))] = mesh
    mtl = f"{target.stem}.mtl"
    text, files = export_obj(
        scene, include_normals=True, return_texture=True, digits=6, mtl_name=mtl, header=None
    )
    with atomic_path(target.with_name(mtl)) as temporary:
        temporary.write_bytes(files[mtl] + b"\n")
    with atomic_path(target) as temporary:
        temporary.write_text(text, encoding="utf-8")


class _Scene(trimesh.Scene):
    """A scene that exports its meshes unchanged: trimesh's own dump copies them without normals."""

    def dump(self, concatenate: bool = False) -> list[trimesh.Trimesh]:
        return list(self.geometry.values())


class _Material(Material):
    """A material, given by its lines in an MTL file."""

    def __init__(self, name: str, rows: Sequence[str]) -> None:
        self.name, self.rows = name, ("Ka 0 0 0", *rows, "illum 1")

    def __hash__(self) -> int:
        return hash((self.name, self.rows))

    @property
    def main_color(self) -> None:
        """None: the exporter does not use it."""

    def to_obj(self, name: str) -> tuple[dict[str, bytes], str]:
        """Return ({file name: contents}, material name)."""
        return {f"{name}.mtl": "\n".join((f"newmtl {name}", *self.rows)).encode()}, name


def _pieces(part: MeshPart, tile: TileTexture | None, folder: str) -> Iterator[trimesh.Trimesh]:
    """Yield a part's meshes, one per material; the first has the part's name."""
    # Every mesh gets normals and texture coordinates: trimesh numbers them as the vertices.
    uv = np.zeros((len(part.mesh.vertices), 2)) if part.uv is None else part.uv
    uv = (uv if tile is None or part.uv is None else tile.turns(uv)) * [1, -1]
    faces = part.mesh.faces
    if part.colours is None:
        looks = [(_surface_material(part, tile, folder), np.full(len(faces), True))]
    else:
        colours, which = np.unique(part.colours[faces[:, 0]], axis=0, return_inverse=True)
        looks = [(_plain(colour), which == k) for k, colour in enumerate(colours.tolist())]
    for number, (material, face_mask) in enumerate(looks):
        used, index = np.unique(faces[face_mask], return_inverse=True)
        yield trimesh.Trimesh(
            part.mesh.vertices[used],
            index.reshape(-1, 3),
            vertex_normals=part.mesh.vertex_normals[used],
            visual=TextureVisuals(uv=uv[used], material=material),
            metadata={} if number else {"name": part.name},
            process=False,
        )


def _surface_material(part: MeshPart, tile: TileTexture | None, folder: str) -> _Material:
    """Return the material of a room's surface or of glass."""
    if part.surface is None:
        return _Material("glass", [f"Kd {GLASS[0]} {GLASS[1]} {GLASS[2]}", f"d {GLASS[3]}"])
    if tile is None:
        return _plain(UNTEXTURED[part.surface.kind])
    name = part.surface.filename
    return _Material(name, ["Kd 1 1 1", f"map_Kd {folder}/{name}{tile.suffix}"])


def _plain(colour: Sequence[int]) -> _Material:
    """Return the material of an sRGB colour."""
    rows = ["Kd {:.4f} {:.4f} {:.4f}".format(*(c / 255 for c in colour))]
    return _Material("plain_{:02x}{:02x}{:02x}".format(*colour), rows)
