"""Rule paint: colours, materials, textures and finishes of a house -> textures in paint."""

from pathlib import Path

from plan2scene.paint.surfaces import write_paint
from plan2scene.plans.room_names import has_bare_floor, is_garage
from plan2scene.plans.scene_json import read_scene_json
from plan2scene.textures.painted import paint_textures
from plan2scene_app.finishes import read_finishes
from plan2scene_app.workflow.jobs import job

inputs, output = snakemake.input, snakemake.output


def set_finishes(folder: Path) -> None:
    """Apply the owner's finishes; the import is here because PyTorch takes seconds to import."""
    from plan2scene_app.set_by_hand import set_by_hand

    openings = [opening.id for wall in plan.walls for opening in wall.openings]
    set_by_hand(folder, finishes, inputs.crops, output.paint, openings=openings)


with job(snakemake.log[0]):
    plan = read_scene_json(inputs.scene, snakemake.wildcards.house)
    finishes = read_finishes(inputs.finishes, plan) if inputs.get("finishes") else {}
    write_paint(
        *(inputs.colours, inputs.materials, output.paint),
        dataset=snakemake.params.dataset,
        house=snakemake.wildcards.house,
        accents=snakemake.params.accents,
    )
    paint_textures(
        *(inputs.textures, output.paint, output.textures),
        open_air={room.id for room in plan.rooms if room.open_air},
        garages={room.id for room in plan.rooms if is_garage(room.name or room.id)},
        bathrooms={room.id for room in plan.rooms if "Bathroom" in room.types},
        uncarpeted={r.id for r in plan.rooms if has_bare_floor(r.types, r.name or r.id)},
        last_word=set_finishes if finishes else None,
    )
