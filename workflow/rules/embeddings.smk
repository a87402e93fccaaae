# Embeddings of crops; then, at each drop fraction, the crop that represents each surface, surfaces
# that share a material, and predictions for surfaces that no photo shows.
CROP_MODELS = {name: model_of(name) for name in ("texture", "naivesynth")}
PROPAGATION_MODELS = {name: model_of(name) for name in ("texture", "propagation")}
EMBEDDINGS = f"{RESULTS}/houses/{{house}}/embeddings.parquet"
SURFACES = f"{RESULTS}/drop_{{drop}}/{{house}}/surfaces.parquet"
MATERIALS = f"{RESULTS}/drop_{{drop}}/{{house}}/materials.parquet"
PROPAGATED = f"{RESULTS}/drop_{{drop}}/{{house}}/propagated.parquet"


rule embeddings:
    # For each crop: code, median colour, substance and textureness.
    input:
        **made(CROP_MODELS),
        crops=f"{RESULTS}/houses/{{house}}/crops.parquet",
    output:
        EMBEDDINGS,
    log:
        f"logs/{DATASET}/embeddings/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/embeddings/{{house}}.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: HOUSE_THREADS
    resources:
        mem_mb=2000,
    params:
        models=CROP_MODELS,
        hashes=hashes(CROP_MODELS),
        dataset=DATASET,
        seed=config["seed"],
        code=rule_code("embeddings"),
    script:
        "../scripts/embeddings.py"


rule materials:
    # At each drop fraction: the crop and embedding that represent each surface that a visible photo
    # shows, and which surfaces of different rooms share a material.
    input:
        scene=f"{RESULTS}/houses/{{house}}/scene.json",
        light=f"{RESULTS}/houses/{{house}}/light.json",
        crops=f"{RESULTS}/houses/{{house}}/crops.parquet",
        embeddings=EMBEDDINGS,
    output:
        surfaces=at_drops(SURFACES),
        materials=at_drops(MATERIALS),
    log:
        f"logs/{DATASET}/materials/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/materials/{{house}}.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: HOUSE_THREADS
    resources:
        mem_mb=worker_memory(500, 300),
    params:
        hidden=hidden_at_drops(DROPS),
        dataset=DATASET,
        code=rule_code("materials"),
    script:
        "../scripts/materials.py"


rule propagated:
    # At each drop fraction: an embedding, a colour and a substance for every surface.
    input:
        **made(PROPAGATION_MODELS),
        scene=f"{RESULTS}/houses/{{house}}/scene.json",
        colours=f"{RESULTS}/houses/{{house}}/colours.parquet",
        surfaces=at_drops(SURFACES),
        materials=at_drops(MATERIALS),
    output:
        at_drops(PROPAGATED),
    log:
        f"logs/{DATASET}/propagated/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/propagated/{{house}}.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=2000,
    params:
        models=PROPAGATION_MODELS,
        hashes=hashes(PROPAGATION_MODELS),
        hidden=hidden_at_drops(DROPS),
        dataset=DATASET,
        predictor=config["propagation"]["predictor"],
        code=rule_code("propagated"),
    script:
        "../scripts/propagated.py"
