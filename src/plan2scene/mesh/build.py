"""The house stage: scene.json and a folder of textures in, a textured 3D house out."""

from __future__ import annotations

import logging
from dataclasses import replace
from pathlib import Path

from plan2scene.mesh.assembly import assemble
from plan2scene.mesh.glb import write_glb
from plan2scene.mesh.texture_files import textured
from plan2scene.plans.scene_json import read_scene_json
from plan2scene.plans.scene_writer import write_scene_json


def build_house(
    scene_json: str | Path,
    textures_dir: str | Path,
    glb: str | Path,
    textured_scene_json: str | Path,
    *,
    house_id: str,
    objects: bool = True,
    relief: bool = True,
) -> None:
    """Write a house as GLB, and as scene.json with textures in the official form.

    `textures_dir` holds a method's tiles with ``textures.json``; surfaces without one get a plain
    colour. With `objects` the GLB shows the plan's fixed objects (:mod:`plan2scene.mesh.fittings`),
    with `relief` its surfaces have normal maps (:mod:`plan2scene.mesh.relief`).
    """
    house, textures = textured(textures_dir, read_scene_json(scene_json, house_id))
    furnished = house if objects else replace(house, icons=())
    parts = assemble(furnished).parts
    write_glb(furnished, textures, glb, parts, relief=relief)
    tiles = {key: (tile.png, tile.size_m) for key, tile in textures.items()}
    evidence = {key: tile.evidence for key, tile in textures.items() if tile.evidence}
    write_scene_json(house, textured_scene_json, tiles, evidence)
    logging.getLogger("plan2scene").info(
        "house %s: %d rooms, %d parts, %d triangles, %d textures",
        house_id,
        len(house.rooms),
        len(parts),
        sum(len(part.mesh.faces) for part in parts),
        len(textures),
    )
