rule propagation_houses:
    # Synthetic houses as graphs with lit crops: nothing is rendered.
    output:
        "results/training/propagation_houses.npz",
    log:
        "logs/training/propagation_houses.log",
    benchmark:
        "logs/training/benchmarks/propagation_houses.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=6000,
    params:
        houses=TRAINING["propagation_houses"],
        seed=config["seed"],
        code=code_hash("plan2scene_workshop.propagation.data"),
    script:
        "../scripts/propagation_houses.py"


rule train_propagation:
    input:
        houses="results/training/propagation_houses.npz",
        texture_model=f"{TRAINED}/texture.safetensors",
        naive_model=f"{TRAINED}/naivesynth.safetensors",
    output:
        model=f"{TRAINED}/propagation.safetensors",
        card=f"{TRAINED}/propagation.md",
    log:
        "logs/training/train_propagation.log",
    benchmark:
        "logs/training/benchmarks/train_propagation.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 2
    resources:
        mem_mb=8000,
    params:
        settings=TRAINING["propagation"],
        checkpoint="results/training/propagation.checkpoint",
        seed=config["seed"],
        code=code_hash("plan2scene_workshop.propagation.run"),
    script:
        "../scripts/train_propagation.py"
