# On demand: every metric against the share of hidden photos, `snakemake -j2 sweep`.
from plan2scene_app.workflow.drops import SWEEP_DROPS


rule sweep_house:
    # A house at all drop fractions by all methods, in one job: a step takes less time than a start.
    input:
        **given(pool=POOL),
        **made(EVALUATION_MODELS),
        **EVALUATED_HOUSE,
    output:
        f"{RESULTS}/houses/{{house}}/sweep.parquet",
    log:
        f"logs/{DATASET}/sweep_house/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/sweep_house/{{house}}.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=max(2000, METRIC_MEMORY),
    params:
        dataset=DATASET,
        models=EVALUATION_MODELS,
        hashes=hashes(EVALUATION_MODELS),
        hidden=hidden_at_drops(SWEEP_DROPS),
        methods=METHODS,
        seam_correction=seam_correction(*METHODS),
        seed=config["seed"],
        predictor=config["propagation"]["predictor"],
        size_px=config["textures"]["size_px"],
        code=rule_code("sweep_house"),
        method_code=method_code(*METHODS),
    script:
        "../scripts/sweep_house.py"


rule sweep:
    # The table and curves over all houses.
    input:
        sweeps=house_files("sweep.parquet"),
        references=house_files("reference_features.parquet"),
    output:
        csv=report(
            f"{RESULTS}/tables/sweep.csv",
            caption="../report/sweep.rst",
            category="Evaluation",
        ),
        plot=report(
            f"{RESULTS}/tables/sweep.png",
            caption="../report/sweep.rst",
            category="Evaluation",
        ),
    log:
        f"logs/{DATASET}/sweep.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/sweep.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=GATHERED_MEMORY,
    params:
        dataset=DATASET,
        houses=HOUSES,
        methods=METHODS,
        drops=list(SWEEP_DROPS),
        seed=config["seed"],
        code=rule_code("sweep"),
    script:
        "../scripts/sweep.py"
