rule train_segmentation:
    # Photos and truth masks of the synthetic train split -> the network, scored on the val split.
    input:
        table=DATA_ROOT / config["dataset"]["table"],
    output:
        model=f"{TRAINED}/segmentation.safetensors",
        card=f"{TRAINED}/segmentation.md",
    log:
        "logs/training/train_segmentation.log",
    benchmark:
        "logs/training/benchmarks/train_segmentation.tsv"
    threads: 2
    resources:
        mem_mb=8000,
    params:
        root=str(DATA_ROOT),
        settings=config.get("training", {}).get("segmentation", {}),
        seed=config["seed"],
        code=code_hash("training.segmentation"),
    script:
        "../scripts/train_segmentation.py"
