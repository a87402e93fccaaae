"""Rule comparison: a house's crops and embeddings -> textures and metrics of all methods."""

from pathlib import Path

from plan2scene.evaluation.comparison import Compared, Settings, Visible, compare_house
from plan2scene.evaluation.houses import HouseFiles, Models
from plan2scene.jobs import job

with job(snakemake.log[0]):
    found, output, params = snakemake.input, snakemake.output, snakemake.params
    made = [(drop, method) for drop, method in params.pairs if [drop, method] != params.chosen]
    written = dict(zip(made, output.textures, strict=True))
    compare_house(
        HouseFiles.of(found, snakemake.wildcards.house, params.dataset),
        Models.of(found),
        {
            drop: Visible(Path(propagated), params.hidden[drop])
            for drop, propagated in zip(params.hidden, found.propagated, strict=True)
        },
        [
            Compared(
                method,
                drop,
                Path(written.get((drop, method)) or found.chosen),
                Path(metrics),
                (drop, method) not in written,
            )
            for (drop, method), metrics in zip(params.pairs, output.metrics, strict=True)
        ],
        Settings(params.seed, params.size_px, params.seam_correction, params.images),
    )
