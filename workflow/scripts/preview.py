"""Rule preview: plan and textures -> preview.png."""

from plan2scene.jobs import job
from plan2scene.mesh.preview import build_preview

with job(snakemake.log[0]):
    build_preview(
        snakemake.input.scene,
        snakemake.input.textures,
        snakemake.output[0],
        house_id=snakemake.wildcards.house,
    )
