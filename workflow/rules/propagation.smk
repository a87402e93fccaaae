rule propagate:
    # Embeddings of every surface: observed ones kept, the others predicted over the room graph;
    # at every drop, for it starts longer than it takes.
    input:
        scene=f"{RESULTS}/houses/{{house}}/scene.json",
        surfaces=[f"{RESULTS}/drop_{drop}/{{house}}/surfaces.parquet" for drop in DROPS],
        model=model_of("propagation"),
        texture_model=model_of("texture"),
    output:
        [f"{RESULTS}/drop_{drop}/{{house}}/propagated.parquet" for drop in DROPS],
    log:
        f"logs/{DATASET}/propagate/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/propagate/{{house}}.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        dataset=DATASET,
        code=code_hash("propagation.stage"),
    script:
        "../scripts/propagate.py"
