rule train_plans:
    # Drawings of synthetic homes, made on the way -> the network that reads pictures of plans.
    output:
        model=f"{TRAINED}/plans.safetensors",
        card=f"{TRAINED}/plans.md",
    log:
        "logs/training/train_plans.log",
    benchmark:
        "logs/training/benchmarks/train_plans.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 2
    resources:
        mem_mb=8000,
    params:
        settings=TRAINING["plans"],
        checkpoint="results/training/plans.checkpoint",
        seed=config["seed"],
        code=code_hash("plan2scene_workshop.plans.run"),
    script:
        "../scripts/train_plans.py"
