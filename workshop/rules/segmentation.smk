rule train_segmentation:
    # Photos and truth masks of the synthetic train split -> the network, scored on the val split.
    input:
        table=TABLE,
    output:
        model=f"{TRAINED}/segmentation.safetensors",
        card=f"{TRAINED}/segmentation.md",
    log:
        "logs/training/train_segmentation.log",
    benchmark:
        "logs/training/benchmarks/train_segmentation.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 2
    resources:
        mem_mb=8000,
    params:
        settings=TRAINING["segmentation"],
        checkpoint="results/training/segmentation.checkpoint",
        seed=config["seed"],
        code=code_hash("plan2scene_workshop.segmentation.run"),
    script:
        "../scripts/train_segmentation.py"
