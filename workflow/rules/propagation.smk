rule propagate:
    # Embeddings of every surface: observed ones kept, the others predicted over the room graph.
    input:
        scene=f"{RESULTS}/houses/{{house}}/scene.json",
        surfaces=f"{RESULTS}/drop_{{drop}}/{{house}}/surfaces.parquet",
        model=model_of("propagation"),
        texture_model=model_of("texture"),
    output:
        f"{RESULTS}/drop_{{drop}}/{{house}}/propagated.parquet",
    log:
        f"logs/{DATASET}/propagate/{{drop}}/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/propagate/{{drop}}/{{house}}.tsv"
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
