"""A house as USD: ``house.usdc`` with textures beside it, and ``house.usdz`` with all in one.

Metres, y up. Every part of the house is a mesh with a UsdPreviewSurface material and a semantic
label. ``/house/collision`` holds convex bodies with the collision API of UsdPhysics. Source: the
specifications at openusd.org; the writer is usd-core (the extra `exports`).
"""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from plan2scene.colour import srgb_to_linear
from plan2scene.house import House, SurfaceKey
from plan2scene.io import atomic_directory, atomic_path
from plan2scene.mesh.assembly import assemble
from plan2scene.mesh.glb import roughness
from plan2scene.mesh.parts import GLASS, MeshPart
from plan2scene.mesh.texture_files import UNTEXTURED, TileTexture
from plan2scene_app.exports.simulator import category_of
from plan2scene_app.exports.solids import Solid, house_solids

#: Date of all files in a package, 1 January 2000: with it a house always gives the same bytes.
_DATE = 946_728_000


def write_usd(house: House, textures: Mapping[SurfaceKey, TileTexture], folder: Path) -> None:
    """Write ``house.usdc``, ``textures/*`` and ``house.usdz`` of a house into a folder."""
    with tempfile.TemporaryDirectory(dir=folder) as name:
        work = Path(name)
        (work / "textures").mkdir()
        for key, tile in textures.items():
            (work / "textures" / f"{key.filename}{tile.suffix}").write_bytes(tile.image)
        layer = work / "house.usdc"
        _Stage(house, textures).write(layer)
        package = work / "house.usdz"
        _pack(work, package)
        with atomic_directory(folder / "textures") as images:
            for image in sorted((work / "textures").iterdir()):
                image.rename(images / image.name)
        for made in (layer, package):
            with atomic_path(folder / made.name) as temporary:
                made.replace(temporary)


def _pack(folder: Path, package: Path) -> None:
    """Write the layer of a folder, and then its images, into one package.

    All files get one fixed date there, because the package stores it.
    """
    from pxr import Sdf

    writer = Sdf.ZipFileWriter.CreateNew(str(package))
    for file in (folder / "house.usdc", *sorted((folder / "textures").iterdir())):
        os.utime(file, (_DATE, _DATE))
        writer.AddFile(str(file), file.relative_to(folder).as_posix())
        os.utime(file)  # now: rsync would not copy a file of the same size and date again
    writer.Save()


def prim_name(name: str) -> str:
    """Return a name changed to what USD allows: letters, digits and '_', no digit first."""
    safe = re.sub(r"[^A-Za-z0-9_]", "_", name)
    return safe if re.match(r"[A-Za-z_]", safe) else f"_{safe}"


class _Stage:
    """Builds the USD stage of a house."""

    def __init__(self, house: House, textures: Mapping[SurfaceKey, TileTexture]) -> None:
        self.house, self.textures = house, textures
        self._names = {room.id: room.name for room in house.rooms}
        self._paths: set[str] = set()
        self._materials: dict[str, Any] = {}

    def write(self, path: Path) -> None:
        """Write the stage as one layer."""
        from pxr import Kind, Usd, UsdGeom

        self.stage = stage = Usd.Stage.CreateNew(str(path))
        UsdGeom.SetStageMetersPerUnit(stage, 1.0)
        UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
        root = UsdGeom.Xform.Define(stage, "/house")
        stage.SetDefaultPrim(root.GetPrim())
        Usd.ModelAPI(root.GetPrim()).SetKind(Kind.Tokens.component)
        UsdGeom.Scope.Define(stage, "/house/materials")
        assembly = assemble(self.house)
        for part in assembly.parts:
            self._part(part)
        self._collision(house_solids(self.house, assembly))
        stage.GetRootLayer().Save()

    def _define(self, parent: str, name: str) -> str:
        """Return a unique path below `parent` for a prim of this name."""
        base = path = f"{parent}/{prim_name(name)}"
        number = 2
        while path in self._paths:
            path, number = f"{base}_{number}", number + 1
        self._paths.add(path)
        return path

    def _mesh(self, path: str, name: str, vertices: np.ndarray, faces: np.ndarray) -> Any:
        from pxr import Gf, UsdGeom, Vt

        mesh = UsdGeom.Mesh.Define(self.stage, path)
        mesh.GetPrim().SetDisplayName(name)
        mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(vertices, np.float32)))
        mesh.CreateFaceVertexCountsAttr(Vt.IntArray(len(faces), 3))
        mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(faces.astype(np.int32).ravel()))
        mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
        corners = [vertices.min(0), vertices.max(0)]
        mesh.CreateExtentAttr([Gf.Vec3f(*map(float, corner)) for corner in corners])
        return mesh

    def _part(self, part: MeshPart) -> None:
        """Add a visible part: normals, texture coordinates or colours, material, label."""
        from pxr import Sdf, UsdGeom, UsdShade, Vt

        room = part.extras.get("room_id")
        parent = f"/house/{prim_name('room_' + str(room) if room is not None else 'structure')}"
        group = UsdGeom.Xform.Define(self.stage, parent)
        if name := self._names.get(str(room)):
            group.GetPrim().SetDisplayName(name)
        vertices = part.mesh.vertices
        mesh = self._mesh(self._define(parent, part.name), part.name, vertices, part.mesh.faces)
        mesh.CreateNormalsAttr(
            Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(part.mesh.vertex_normals, np.float32))
        )
        mesh.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
        tile = None if part.surface is None else self.textures.get(part.surface)
        primvars = UsdGeom.PrimvarsAPI(mesh)
        if part.uv is not None and tile is not None:
            st = tile.turns(part.uv) * [1, -1] + [0, 1]  # USD's v runs up the image
            primvars.CreatePrimvar(
                "st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.vertex
            ).Set(Vt.Vec2fArray.FromNumpy(st.astype(np.float32)))
        if part.colours is not None:
            linear = srgb_to_linear(part.colours).astype(np.float32)
            colours = mesh.CreateDisplayColorPrimvar(UsdGeom.Tokens.vertex)
            colours.Set(Vt.Vec3fArray.FromNumpy(linear))
        mesh.CreateDoubleSidedAttr(part.material == "glass")
        UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(self._material(part, tile))
        _label(mesh.GetPrim(), category_of(part))

    def _material(self, part: MeshPart, tile: TileTexture | None) -> Any:
        """Return the material of a part; parts that look alike share one."""
        from pxr import Gf, Sdf, UsdShade

        name = part.material if part.surface is None else part.surface.filename
        if name in self._materials:
            return self._materials[name]
        path = self._define("/house/materials", name)
        self._materials[name] = material = UsdShade.Material.Define(self.stage, path)
        shader = UsdShade.Shader.Define(self.stage, f"{path}/surface")
        shader.CreateIdAttr("UsdPreviewSurface")
        shader.CreateInput("metallic", Sdf.ValueTypeNames.Float).Set(0.0)
        shader.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(roughness(part, tile))
        material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
        colour = shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f)
        if part.material == "glass":
            colour.Set(Gf.Vec3f(*GLASS[:3]))
            shader.CreateInput("opacity", Sdf.ValueTypeNames.Float).Set(GLASS[3])
        elif tile is not None:
            colour.ConnectToSource(self._texture(path, f"./textures/{name}{tile.suffix}"), "rgb")
        elif part.surface is not None:
            flat = srgb_to_linear(np.array(UNTEXTURED[part.surface.kind], np.uint8))
            colour.Set(Gf.Vec3f(*map(float, flat)))
        else:
            reader = self._reader(f"{path}/colour", "UsdPrimvarReader_float3", "displayColor")
            colour.ConnectToSource(reader, "result")
        return material

    def _texture(self, path: str, file: str) -> Any:
        """Return a shader that samples a repeating image at the primvar ``st``."""
        from pxr import Sdf, UsdShade

        shader = UsdShade.Shader.Define(self.stage, f"{path}/image")
        shader.CreateIdAttr("UsdUVTexture")
        shader.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(file)
        shader.CreateInput("sourceColorSpace", Sdf.ValueTypeNames.Token).Set("sRGB")
        for axis in ("wrapS", "wrapT"):
            shader.CreateInput(axis, Sdf.ValueTypeNames.Token).Set("repeat")
        reader = self._reader(f"{path}/st", "UsdPrimvarReader_float2", "st")
        shader.CreateInput("st", Sdf.ValueTypeNames.Float2).ConnectToSource(reader, "result")
        shader.CreateOutput("rgb", Sdf.ValueTypeNames.Float3)
        return shader.ConnectableAPI()

    def _reader(self, path: str, kind: str, primvar: str) -> Any:
        """Return a shader that reads a primvar in a material."""
        from pxr import Sdf, UsdShade

        types = {"UsdPrimvarReader_float2": "Float2", "UsdPrimvarReader_float3": "Float3"}
        shader = UsdShade.Shader.Define(self.stage, path)
        shader.CreateIdAttr(kind)
        shader.CreateInput("varname", Sdf.ValueTypeNames.String).Set(primvar)
        shader.CreateOutput("result", getattr(Sdf.ValueTypeNames, types[kind]))
        return shader.ConnectableAPI()

    def _collision(self, solids: Sequence[Solid]) -> None:
        """Add the convex bodies of what stands still; they are not rendered (purpose `guide`)."""
        from pxr import UsdGeom, UsdPhysics

        UsdGeom.Scope.Define(self.stage, "/house/collision")
        for solid in (solid for solid in solids if not solid.ajar):
            for number, piece in enumerate(solid.pieces):
                name = f"{solid.name}/{number}"
                path = self._define("/house/collision", name)
                mesh = self._mesh(path, name, piece.vertices, piece.faces)
                mesh.CreatePurposeAttr(UsdGeom.Tokens.guide)
                prim = mesh.GetPrim()
                UsdPhysics.CollisionAPI.Apply(prim)
                hull = UsdPhysics.MeshCollisionAPI.Apply(prim)
                hull.CreateApproximationAttr(UsdPhysics.Tokens.convexHull)
                _label(prim, solid.category)


def _label(prim: Any, category: str) -> None:
    """Give a prim its semantic label."""
    from pxr import UsdSemantics, Vt

    labels = UsdSemantics.LabelsAPI.Apply(prim, "category")
    labels.CreateLabelsAttr(Vt.TokenArray([category]))
