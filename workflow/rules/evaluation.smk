# For columns Unobserved and All of the paper's table, 60 % of the photos are hidden.
TABLE_DROP = "0.6" if "0.6" in DROPS else max(DROPS)


# The networks of FID and KID (features) and of SUBS (substances).
METRIC_MODELS = {
    "features": metric_model("inception"),
    "substances": metric_model("vgg16"),
}
METRIC_MEMORY = 3000 if len(set(METRIC_MODELS.values())) > 1 else 1000
# The models of the rules sweep_house and ablation_house, which run all stages after the embeddings.
EVALUATION_MODELS = {**CROP_MODELS, **PROPAGATION_MODELS, **METRIC_MODELS}
# Files of the house that the sweep and the ablation propagate and measure.
EVALUATED_HOUSE = {
    "scene": f"{RESULTS}/houses/{{house}}/scene.json",
    "crops": f"{RESULTS}/houses/{{house}}/crops.parquet",
    "colours": f"{RESULTS}/houses/{{house}}/colours.parquet",
    "embeddings": f"{RESULTS}/houses/{{house}}/embeddings.parquet",
    "library": f"{RESULTS}/texture_library.parquet",
}


TABLE_DROPS = sorted({"0.0", TABLE_DROP})
TABLE_MODELS = {
    name: path for method in METHODS for name, path in decoder(method).items()
}
# Folder of tiles; its subfolders are {drop}/{method}/.
COMPARED = f"{RESULTS}/houses/{{house}}/comparison"
NEEDS_LIBRARY = any(TEXTURE_METHODS[name].library for name in METHODS)
# Tiles of the 3D house, which are reused in the table if the table has their method.
SHOWN = CHOSEN_TEXTURES if config["house"]["method"] in METHODS else None


rule table_textures:
    # Tiles by every method of the table at both drop fractions; the 3D house's tiles are copied.
    input:
        **given(
            pool=POOL,
            shown=SHOWN,
            library=NEEDS_LIBRARY and f"{RESULTS}/texture_library.parquet",
        ),
        **made(TABLE_MODELS),
        scene=f"{RESULTS}/houses/{{house}}/scene.json",
        crops=f"{RESULTS}/houses/{{house}}/crops.parquet",
        propagated=[
            f"{RESULTS}/drop_{drop}/{{house}}/propagated.parquet"
            for drop in TABLE_DROPS
        ],
    output:
        directory(COMPARED),
    log:
        f"logs/{DATASET}/table_textures/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/table_textures/{{house}}.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=2000,
    params:
        models=TABLE_MODELS,
        hashes=hashes(TABLE_MODELS),
        methods=METHODS,
        shown=("0.0", config["house"]["method"]),
        hidden=hidden_at_drops(TABLE_DROPS),
        images=config["metrics"]["fid_seeds"],
        seed=config["seed"],
        size_px=config["textures"]["size_px"],
        seam_correction=seam_correction(*METHODS),
        code=rule_code("table_textures"),
        method_code=method_code(*METHODS),
    script:
        "../scripts/table_textures.py"


rule metrics:
    # COLOR, FREQ, TILE, SUBS and features of each surface that a crop shows, by every method; and
    # the features of each crop, for FID and KID.
    input:
        **made(METRIC_MODELS),
        crops=f"{RESULTS}/houses/{{house}}/crops.parquet",
        textures=COMPARED,
    output:
        metrics=f"{RESULTS}/houses/{{house}}/metrics.parquet",
        references=f"{RESULTS}/houses/{{house}}/reference_features.parquet",
    log:
        f"logs/{DATASET}/metrics/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/metrics/{{house}}.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=max(2000, METRIC_MEMORY),
    params:
        dataset=DATASET,
        models=METRIC_MODELS,
        hashes=hashes(METRIC_MODELS),
        methods=METHODS,
        hidden=hidden_at_drops(TABLE_DROPS),
        code=rule_code("metrics"),
    script:
        "../scripts/metrics.py"


rule texture_sheet:
    # A picture of reference crops beside the tiles of every method.
    input:
        crops=f"{RESULTS}/houses/{{house}}/crops.parquet",
        textures=COMPARED,
    output:
        report(
            f"{RESULTS}/houses/{{house}}/texture_sheet.png",
            caption="../report/texture_sheet.rst",
            category="Houses",
            subcategory="{house}",
            labels={"file": "textures by method"},
        ),
    log:
        f"logs/{DATASET}/texture_sheet/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/texture_sheet/{{house}}.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=500,
    params:
        methods=METHODS,
        code=rule_code("texture_sheet"),
    script:
        "../scripts/texture_sheet.py"


rule paper_table:
    # The paper's table 1 over all houses: published figures and differences beside ours.
    input:
        metrics=house_files("metrics.parquet"),
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
        mem_mb=GATHERED_MEMORY,
    params:
        dataset=DATASET,
        houses=HOUSES,
        methods=METHODS,
        drop=TABLE_DROP,
        seed=config["seed"],
        code=rule_code("paper_table"),
    script:
        "../scripts/paper_table.py"


# The files from which a house's metrics are made, and the metrics. Snakemake removes the outputs of
# a failed job, so a house that lacks one of these files is not finished.
FINISHED = [
    *given(masks=HAS_MASKS and MASKS, shown=SHOWN).values(),
    PHOTO_ROOMS,
    f"{RESULTS}/houses/{{house}}/scene.json",
    f"{RESULTS}/houses/{{house}}/crops.parquet",
    f"{RESULTS}/houses/{{house}}/embeddings.parquet",
    *(
        f"{RESULTS}/drop_{drop}/{{house}}/{name}.parquet"
        for drop in TABLE_DROPS
        for name in ("surfaces", "materials", "propagated")
    ),
    f"{RESULTS}/houses/{{house}}/metrics.parquet",
    f"{RESULTS}/houses/{{house}}/reference_features.parquet",
]


use rule paper_table as partial_table with:
    # On demand, after a run in which some houses failed: the table of the finished houses, whose
    # metrics are made again if they are out of date. Column `missing` names the other houses.
    input:
        metrics=finished("metrics.parquet"),
        references=finished("reference_features.parquet"),
    output:
        csv=f"{RESULTS}/tables/paper_table_partial.csv",
        parquet=f"{RESULTS}/tables/paper_table_partial.parquet",
        latex=f"{RESULTS}/tables/paper_table_partial.tex",
        plot=f"{RESULTS}/tables/paper_table_partial.png",
    log:
        f"logs/{DATASET}/partial_table.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/partial_table.tsv"


onerror:
    for line in failures(Path("logs", DATASET), HOUSES):
        print(line, file=sys.stderr)
    if finished_houses():
        print(
            "A table of the finished houses: the same command with target partial_table",
            file=sys.stderr,
        )
