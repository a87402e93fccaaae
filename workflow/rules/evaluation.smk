# Unobserved and All of the paper's table: 60 % of photos hidden where the config has it.
TABLE_DROP = "0.6" if "0.6" in DROPS else max(DROPS)


# The networks behind FID and KID, and behind SUBS: converted ones where they are given.
FEATURES = metric_model("inception")
SUBSTANCES = metric_model("vgg16")
METRIC_MEMORY = 3000 if FEATURES != SUBSTANCES else 1000


# Methods whose noise is drawn again for FID and KID; none where there is one image of each surface.
REDRAWN = (
    [method for method in METHODS if method in ("synth", "naivesynth")]
    if config["metrics"]["fid_seeds"] > 1
    else []
)


rule metrics:
    # COLOR, FREQ, TILE, SUBS and features of each surface that any crop shows, by every method:
    # one job, for jobs of their own would mostly start.
    input:
        textures=[
            f"{RESULTS}/drop_{{drop}}/{method}/{{house}}/textures"
            for method in METHODS
        ],
        crops=f"{RESULTS}/houses/{{house}}/crops.parquet",
        model=FEATURES,
        substance_model=SUBSTANCES,
        propagated=propagated_of if REDRAWN else [],
        decoders=[model_of(DECODERS[method]) for method in REDRAWN],
    output:
        [
            f"{RESULTS}/drop_{{drop}}/{method}/{{house}}/metrics.parquet"
            for method in METHODS
        ],
    log:
        f"logs/{DATASET}/metrics/{{drop}}/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/metrics/{{drop}}/{{house}}.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=METRIC_MEMORY,
    params:
        methods=METHODS,
        redrawn=REDRAWN,
        hidden=hidden_photos,
        dataset=DATASET,
        images=config["metrics"]["fid_seeds"],
        seed=config["seed"],
        size_px=config["textures"]["size_px"],
        seam_correction={
            method: config["textures"]["seam_correction"][method] for method in REDRAWN
        },
        code=code_hash("metrics.stage"),
    script:
        "../scripts/metrics.py"


rule reference_features:
    # Features of every crop: what FID compares the textures with.
    input:
        crops=f"{RESULTS}/houses/{{house}}/crops.parquet",
        model=FEATURES,
    output:
        f"{RESULTS}/houses/{{house}}/reference_features.parquet",
    log:
        f"logs/{DATASET}/reference_features/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/reference_features/{{house}}.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=METRIC_MEMORY,
    params:
        dataset=DATASET,
        code=code_hash("metrics.stage"),
    script:
        "../scripts/reference_features.py"


rule paper_table:
    # The paper's table 1 over all houses: published figures and differences beside ours.
    input:
        metrics=expand(
            f"{RESULTS}/drop_{{drop}}/{{method}}/{{house}}/metrics.parquet",
            drop=sorted({"0.0", TABLE_DROP}),
            method=METHODS,
            house=HOUSES.index,
        ),
        references=house_files("reference_features.parquet"),
    output:
        csv=report(
            f"{RESULTS}/tables/paper_table.csv",
            caption="../report/paper_table.rst",
            category="Evaluation",
        ),
        parquet=f"{RESULTS}/tables/paper_table.parquet",
        latex=f"{RESULTS}/tables/paper_table.tex",
        plot=report(
            f"{RESULTS}/tables/paper_table.png",
            caption="../report/paper_table.rst",
            category="Evaluation",
        ),
    log:
        f"logs/{DATASET}/paper_table.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/paper_table.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        dataset=DATASET,
        houses=list(HOUSES.index),
        methods=METHODS,
        drop=TABLE_DROP,
        seed=config["seed"],
        code=code_hash("metrics.table"),
    script:
        "../scripts/paper_table.py"


onerror:
    # One bad house never stops the others: the table of what there is says who is missing.
    from plan2scene.metrics.table import TableRequest, partial_table

    partial = partial_table(
        RESULTS,
        f"{RESULTS}/tables",
        request=TableRequest(
            dataset=DATASET,
            houses=tuple(HOUSES.index),
            methods=tuple(METHODS),
            drop=TABLE_DROP,
            seed=config["seed"],
        ),
    )
    if partial:
        print(f"Table of the finished houses: {partial}", file=sys.stderr)
