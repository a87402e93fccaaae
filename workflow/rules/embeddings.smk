EMBEDDING_MODELS = {
    name: model_of(name) for name in ("texture", "naivesynth", "propagation")
}


rule embeddings:
    # Every crop as numbers; the crop that stands for each surface, among those of photos not
    # hidden; and what is expected of the surfaces that no photo shows. All drops in one job: its
    # start (torch and torch-geometric) takes longer than its work.
    input:
        **made(EMBEDDING_MODELS),
        scene=f"{RESULTS}/houses/{{house}}/scene.json",
        crops=f"{RESULTS}/houses/{{house}}/crops.parquet",
        colours=f"{RESULTS}/houses/{{house}}/colours.parquet",
        light=f"{RESULTS}/houses/{{house}}/light.json",
    output:
        embeddings=f"{RESULTS}/houses/{{house}}/embeddings.parquet",
        surfaces=[f"{RESULTS}/drop_{drop}/{{house}}/surfaces.parquet" for drop in DROPS],
        materials=[
            f"{RESULTS}/drop_{drop}/{{house}}/materials.parquet" for drop in DROPS
        ],
        propagated=[
            f"{RESULTS}/drop_{drop}/{{house}}/propagated.parquet" for drop in DROPS
        ],
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
        models=EMBEDDING_MODELS,
        hashes=hashes(EMBEDDING_MODELS),
        hidden=hidden_at_drops(DROPS),
        dataset=DATASET,
        seed=config["seed"],
        predictor=config["propagation"]["predictor"],
        code=code_hash(
            "plan2scene.textures.model.embedding",
            "plan2scene.textures.selection",
            "plan2scene.propagation.house_materials",
            "plan2scene.propagation.stage",
        ),
    script:
        "../scripts/embeddings.py"
