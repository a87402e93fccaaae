import numpy as np
import pytest

from plan2scene.mesh.assembly import assemble
from plan2scene_app.exports.usd import write_usd

pxr = pytest.importorskip("pxr")
from pxr import Usd, UsdGeom, UsdPhysics, UsdShade, UsdValidation  # noqa: E402


def complaints(path):
    registry = UsdValidation.ValidationRegistry()
    context = UsdValidation.ValidationContext(registry.GetOrLoadAllValidators())
    return [(e.GetName(), e.GetMessage()) for e in context.Validate(Usd.Stage.Open(str(path)))]


@pytest.fixture
def folder(gap_house, paint, tmp_path):
    write_usd(gap_house, paint(gap_house), tmp_path)
    return tmp_path


@pytest.mark.parametrize("name", ["house.usdc", "house.usdz"])
def test_valid_and_whole(folder, gap_house, paint, name):
    assert complaints(folder / name) == []
    stage = Usd.Stage.Open(str(folder / name))
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0 and UsdGeom.GetStageUpAxis(stage) == "Y"
    prims = {prim.GetDisplayName(): prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)}
    textures = paint(gap_house)
    for part in assemble(gap_house).parts:
        mesh = UsdGeom.Mesh(prims[part.name])
        assert np.array(mesh.GetPointsAttr().Get()) == pytest.approx(part.mesh.vertices, abs=1e-5)
        material, _ = UsdShade.MaterialBindingAPI(prims[part.name]).ComputeBoundMaterial()
        assert material
        if part.surface in textures:
            st = np.array(UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st").Get())
            expected = textures[part.surface].turns(part.uv) * [1, -1] + [0, 1]
            assert st == pytest.approx(expected, abs=1e-4)
            image = UsdShade.Shader.Get(stage, f"{material.GetPath()}/image")
            assert image.GetInput("file").Get().resolvedPath


def test_collision_and_labels(folder):
    stage = Usd.Stage.Open(str(folder / "house.usdc"))
    hulls = [prim for prim in stage.Traverse() if prim.HasAPI(UsdPhysics.CollisionAPI)]
    assert hulls and not any("door" in prim.GetDisplayName() for prim in hulls)
    for prim in hulls:
        assert UsdPhysics.MeshCollisionAPI(prim).GetApproximationAttr().Get() == "convexHull"
    labels = {
        prim.GetDisplayName(): list(prim.GetAttribute("semantics:labels:category").Get())
        for prim in stage.Traverse()
        if prim.IsA(UsdGeom.Mesh)
    }
    assert labels["a/floor"] == ["floor"] and labels["a/door/ha"] == ["door"]
    assert all(labels.values())
