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


rule train_fixtures:
    # Drawings of synthetic rooms, made on the way -> the network that finds baths, toilets, stoves.
    output:
        model=f"{TRAINED}/fixtures.safetensors",
        card=f"{TRAINED}/fixtures.md",
    log:
        "logs/training/train_fixtures.log",
    benchmark:
        "logs/training/benchmarks/train_fixtures.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 2
    resources:
        mem_mb=8000,
    params:
        settings=TRAINING["fixtures"],
        checkpoint="results/training/fixtures.checkpoint",
        seed=config["seed"],
        code=code_hash("plan2scene_workshop.plans.fixture_training"),
    script:
        "../scripts/train_fixtures.py"
