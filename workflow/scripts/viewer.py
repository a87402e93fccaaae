"""Rule viewer: GLB -> one offline HTML file."""

from plan2scene.jobs import job
from plan2scene.viewer import build_viewer

with job(snakemake.log[0]):
    build_viewer(
        snakemake.input.glb,
        snakemake.output[0],
        house_id=snakemake.wildcards.house,
    )
