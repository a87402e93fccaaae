# On demand: what each part of method synth contributes, `snakemake -j2 ablation`.


rule ablation_house:
    # Metrics of a house by every variant of the method, in one job.
    input:
        **made(EVALUATION_MODELS),
        **EVALUATED_HOUSE,
    output:
        f"{RESULTS}/houses/{{house}}/ablation.parquet",
    log:
        f"logs/{DATASET}/ablation_house/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/ablation_house/{{house}}.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=max(2000, METRIC_MEMORY),
    params:
        dataset=DATASET,
        models=EVALUATION_MODELS,
        hashes=hashes(EVALUATION_MODELS),
        hidden=hidden_at_drops(TABLE_DROPS),
        seed=config["seed"],
        predictor=config["propagation"]["predictor"],
        size_px=config["textures"]["size_px"],
        seam_correction={},  # each variant has its own
        code=rule_code("ablation_house"),
    script:
        "../scripts/ablation_house.py"


rule ablation:
    # The table of the ablations over all houses.
    input:
        ablations=house_files("ablation.parquet"),
        references=house_files("reference_features.parquet"),
    output:
        csv=report(
            f"{RESULTS}/tables/ablation.csv",
            caption="../report/ablation.rst",
            category="Evaluation",
        ),
        markdown=f"{RESULTS}/tables/ablation.md",
        latex=f"{RESULTS}/tables/ablation.tex",
    log:
        f"logs/{DATASET}/ablation.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/ablation.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=GATHERED_MEMORY,
    params:
        dataset=DATASET,
        houses=HOUSES,
        drop=TABLE_DROP,
        seed=config["seed"],
        code=rule_code("ablation"),
    script:
        "../scripts/ablation.py"
