"""Rule floorplan: any supported plan -> scene.json."""

from plan2scene.datasets.import_plan import import_plan
from plan2scene_app.workflow.jobs import job

with job(snakemake.log[0], warn=snakemake.params.warn):
    import_plan(
        snakemake.params.named["plan"],
        snakemake.output[0],
        house_id=snakemake.wildcards.house,
        assignment=snakemake.params.named["assignment"],
        photos_dir=snakemake.params.photos,
        object_boxes=snakemake.input.get("object_boxes") or None,
        metres_per_pixel=snakemake.params.metres_per_pixel,
        dxf_layers=snakemake.params.dxf_layers,
        traced=snakemake.params.traced,
        name=snakemake.params.name,
    )
