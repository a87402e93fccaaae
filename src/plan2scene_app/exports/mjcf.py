"""A house as a MuJoCo model (MJCF): static convex geoms, doors as hinged bodies.

MuJoCo's z is up: (x, y, z) of the house becomes (x, -z, y). Sizes are metres, angles radians.
Source: MuJoCo's XML reference.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from xml.etree import ElementTree as ET

import numpy as np
import trimesh

from plan2scene.house import House
from plan2scene_app.exports.solids import Solid

#: Of a door leaf, kg per cubic metre (hollow-core wood), and the friction of its hinge.
DOOR_DENSITY = 350.0
HINGE_DAMPING, HINGE_FRICTION = 0.6, 0.1
OPEN_RAD = math.radians(100.0)
#: Colours by category, RGBA.
COLOURS = {
    "floor": "0.70 0.64 0.58 1",
    "ceiling": "0.96 0.95 0.94 0.15",
    "wall": "0.91 0.89 0.86 1",
    "door": "0.62 0.45 0.32 1",
    "window": "0.70 0.85 0.95 0.3",
}
OBJECT = "0.80 0.80 0.78 1"


def mjcf_text(house: House, solids: Sequence[Solid]) -> str:
    """Return the MJCF document of a house with these solids.

    Bodies are named by their solids; the keyframe ``open`` has the inner doors open.
    """
    root = ET.Element("mujoco", model=house.id)
    ET.SubElement(root, "compiler", angle="radian", autolimits="true")
    ET.SubElement(root, "option", timestep="0.002", integrator="implicitfast")
    assets, world = ET.SubElement(root, "asset"), ET.SubElement(root, "worldbody")
    contact = ET.SubElement(root, "contact")
    ET.SubElement(world, "light", pos="0 0 20", dir="0 0 -1", directional="true")
    opened = []
    for solid in solids:
        body = world
        if solid.hinge is not None:
            body = _leaf(world, contact, solid)
            opened.append(solid.hinge.opens * 0.9 * OPEN_RAD if len(solid.room_ids) > 1 else 0.0)
        for number, piece in enumerate(solid.pieces):
            _geom(assets, body, solid, f"{solid.name}/{number}", piece)
    if opened:
        keys = ET.SubElement(root, "keyframe")
        ET.SubElement(keys, "key", name="open", qpos=_numbers(opened))
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


def _leaf(world: ET.Element, contact: ET.Element, solid: Solid) -> ET.Element:
    """Add the body of a door leaf, which its frame does not hinder; return it."""
    hinge = solid.hinge
    if hinge is None:
        raise ValueError(f"{solid.name} has no hinge")
    body = ET.SubElement(world, "body", name=solid.name, pos=_numbers([hinge.x, -hinge.z, 0.0]))
    limits = sorted((0.0, hinge.opens * OPEN_RAD))
    ET.SubElement(
        body,
        "joint",
        name=f"{solid.name}/hinge",
        type="hinge",
        axis="0 0 1",
        range=_numbers(limits),
        damping=str(HINGE_DAMPING),
        frictionloss=str(HINGE_FRICTION),
    )
    ET.SubElement(contact, "exclude", body1="world", body2=solid.name)
    return body


def _geom(
    assets: ET.Element, body: ET.Element, solid: Solid, name: str, piece: trimesh.Trimesh
) -> None:
    """Add a convex piece: MuJoCo takes the hull of the asset's vertices."""
    points = z_up(piece.vertices)
    if solid.hinge is not None:
        points = points - [solid.hinge.x, -solid.hinge.z, 0.0]
    ET.SubElement(assets, "mesh", name=name, vertex=_numbers(points.ravel()))
    geom = ET.SubElement(
        body, "geom", name=name, type="mesh", mesh=name, rgba=COLOURS.get(solid.category, OBJECT)
    )
    if solid.hinge is not None:
        geom.set("density", str(DOOR_DENSITY))


def z_up(points: np.ndarray) -> np.ndarray:
    """Return world points (n, 3) with z up: (x, -z, y)."""
    return np.stack([points[:, 0], -points[:, 2], points[:, 1]], axis=1)


def _numbers(values: object) -> str:
    """Return numbers as MJCF writes them."""
    return " ".join(f"{float(v) + 0.0:.6g}" for v in np.asarray(values).ravel())
