"""The style model: every surface has a material, and homes are coherent."""

from collections import Counter

import numpy as np

from plan2scene.house import House, SurfaceKey
from plan2scene.materials import Material
from plan2scene_workshop.homes import style
from plan2scene_workshop.homes.floorplans import generate_house

HOUSES = [generate_house(f"home_{k}", 11) for k in range(25)]
MATERIALS = [style.assign_materials(house, 2, size_px=64) for house in HOUSES]


def with_type(house: House, name: str) -> list[str]:
    return [room.id for room in house.rooms if room.types[0] == name]


def test_every_surface_has_a_material() -> None:
    for house, materials in zip(HOUSES, MATERIALS, strict=True):
        assert tuple(materials) == house.surface_keys()


def test_correlations_of_homes() -> None:
    """One floor through the main rooms, ceilings alike and light, wet rooms tiled."""
    same_floor, same_ceiling = [], []
    wet: Counter[str] = Counter()
    for house, materials in zip(HOUSES, MATERIALS, strict=True):
        reception = with_type(house, "Reception")[0]
        for corridor in with_type(house, "Corridor"):
            pair = [materials[SurfaceKey(r, "floor")].name for r in (reception, corridor)]
            same_floor.append(pair[0] == pair[1])
        ceilings = [materials[SurfaceKey(r.id, "ceiling")].name for r in house.rooms]
        same_ceiling.append(Counter(ceilings).most_common(1)[0][1] / len(ceilings))
        for bathroom in with_type(house, "Bathroom"):
            wet[materials[SurfaceKey(bathroom, "floor")].substance] += 1
        light = materials[SurfaceKey(reception, "ceiling")]
        assert light.substance == "wood" or light.albedo.mean() > 150
    assert np.mean(same_floor) > 0.6
    assert np.mean(same_ceiling) > 0.8
    assert wet["tile"] / wet.total() > 0.85


def test_same_seed_same_materials() -> None:
    again = style.assign_materials(HOUSES[0], 2, size_px=64)
    other = style.assign_materials(HOUSES[0], 3, size_px=64)
    names = [m.name for m in MATERIALS[0].values()]
    assert [m.name for m in again.values()] == names
    assert [m.name for m in other.values()] != names


def test_given_textures_are_mixed_in() -> None:
    grey = np.full((256, 256, 3), 90, np.uint8)
    scan = Material("scan-x", "wood", "scan", grey, 1.4, 0.4)
    names = [
        m.name
        for house in HOUSES
        for m in style.assign_materials(house, 2, [scan], size_px=64).values()
    ]
    substances = [m.substance for materials in MATERIALS for m in materials.values()]
    assert 0.2 < names.count("scan-x") / substances.count("wood") < 0.8
