rule train_features:
    # The embedded substance classifier: SUBS, and the features of FID.
    input:
        materials="results/training/materials.npz",
    output:
        model=f"{TRAINED}/features.safetensors",
        card=f"{TRAINED}/features.md",
    log:
        "logs/training/train_features.log",
    benchmark:
        "logs/training/benchmarks/train_features.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=3000,
    params:
        settings=TRAINING["features"],
        checkpoint="results/training/features.checkpoint",
        seed=config["seed"],
        code=code_hash("plan2scene_workshop.features.training"),
    script:
        "../scripts/train_features.py"
