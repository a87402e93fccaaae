rule segmentation_scenes:
    # Rooms of boxes drawn with labels and cameras; needs no data set.
    output:
        "results/training/segmentation_scenes.parquet",
    log:
        "logs/training/segmentation_scenes.log",
    benchmark:
        "logs/training/benchmarks/segmentation_scenes.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=4000,
    params:
        settings=TRAINING["segmentation"],
        seed=config["seed"],
        code=code_hash("segmentation.scenes", "segmentation.data"),
    script:
        "../scripts/segmentation_scenes.py"


rule train_segmentation:
    # Photos and truth masks of the synthetic train split -> the network, scored on the val split.
    input:
        table=TABLE,
        scenes="results/training/segmentation_scenes.parquet",
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
        code=code_hash("segmentation.run"),
    script:
        "../scripts/train_segmentation.py"
