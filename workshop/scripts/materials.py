"""Rule materials: procedural and real textures for training and for measuring."""

from plan2scene_app.workflow.jobs import job
from plan2scene_workshop.texture.data import MaterialSettings, write_materials

with job(snakemake.log[0]):
    write_materials(
        snakemake.output[0], MaterialSettings(**snakemake.params.settings), snakemake.params.seed
    )
