"""Rule textures: propagated embeddings, crops and models -> a tile per surface."""

from plan2scene.jobs import job
from plan2scene.textures.stage import make_textures

with job(snakemake.log[0]):
    make_textures(
        snakemake.wildcards.method,
        snakemake.input.propagated,
        snakemake.input.crops,
        snakemake.input.scene,
        snakemake.output[0],
        house=snakemake.wildcards.house,
        hidden_photos=snakemake.params.hidden,
        library=snakemake.input.library,
        model=snakemake.input.get("model") or None,
        seed=snakemake.params.seed,
        size_px=snakemake.params.size_px,
        seam_correction=snakemake.params.seam_correction,
        crop_pool=snakemake.input.get("pool") or None,
    )
