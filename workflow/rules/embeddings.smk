rule embeddings:
    # Every crop as numbers: code and median colour, substance, textureness.
    input:
        crops=f"{RESULTS}/houses/{{house}}/crops.parquet",
        texture_model=model_of("texture"),
        naive_model=model_of("naivesynth"),
    output:
        f"{RESULTS}/houses/{{house}}/embeddings.parquet",
    log:
        f"logs/{DATASET}/embeddings/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/embeddings/{{house}}.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=2000,
    params:
        dataset=DATASET,
        seed=config["seed"],
        code=code_hash("textures.model.embedding"),
    script:
        "../scripts/embeddings.py"


rule surfaces:
    # The crop that stands for each surface, chosen among those of photos not hidden; at every drop.
    input:
        embeddings=f"{RESULTS}/houses/{{house}}/embeddings.parquet",
        crops=f"{RESULTS}/houses/{{house}}/crops.parquet",
    output:
        [f"{RESULTS}/drop_{drop}/{{house}}/surfaces.parquet" for drop in DROPS],
    log:
        f"logs/{DATASET}/surfaces/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/surfaces/{{house}}.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=500,
    params:
        hidden=hidden_at_drops(DROPS),
        dataset=DATASET,
        code=code_hash("textures.selection"),
    script:
        "../scripts/surfaces.py"
