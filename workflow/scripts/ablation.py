"""Rule ablation: all houses' ablations -> the second table."""

from plan2scene_app.study.ablation import ablation_table
from plan2scene_app.workflow.jobs import job

with job(snakemake.log[0]):
    ablation_table(
        snakemake.input.ablations,
        snakemake.input.references,
        snakemake.output.csv,
        snakemake.output.markdown,
        snakemake.output.latex,
        dataset=snakemake.params.dataset,
        houses=snakemake.params.houses,
        drop=snakemake.params.drop,
        seed=snakemake.params.seed,
    )
