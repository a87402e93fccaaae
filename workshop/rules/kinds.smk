rule train_kinds:
    # Photos of the synthetic train split -> the classifier of rooms, on the shipped segmentation.
    input:
        table=TABLE,
    output:
        model=f"{TRAINED}/kinds.safetensors",
        card=f"{TRAINED}/kinds.md",
    log:
        "logs/training/train_kinds.log",
    benchmark:
        "logs/training/benchmarks/train_kinds.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=3000,
    params:
        settings=TRAINING.get("kinds", {}),
        checkpoint="results/training/kinds.checkpoint",
        seed=config["seed"],
        segmentation=str(MODELS / "segmentation.safetensors"),
        code=code_hash("plan2scene_workshop.kinds.training"),
    script:
        "../scripts/train_kinds.py"
