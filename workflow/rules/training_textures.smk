rule train_texture:
    # Procedural (and, where configured, real) textures -> the model of method synth.
    output:
        model=f"{TRAINED}/texture.safetensors",
        card=f"{TRAINED}/texture.md",
    log:
        "logs/training/train_texture.log",
    benchmark:
        "logs/training/benchmarks/train_texture.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=4000,
    params:
        model="texture",
        data=config.get("training", {}).get("texture_data", {}),
        settings=config.get("training", {}).get("texture", {}),
        cache="results/training/texture_materials.npz",
        checkpoint="results/training/texture_checkpoint.pt",
        seed=config["seed"],
        code=code_hash("training.texture_run"),
    script:
        "../scripts/train_texture.py"


rule train_naivesynth:
    # The same textures -> the model of method naivesynth.
    output:
        model=f"{TRAINED}/naivesynth.safetensors",
        card=f"{TRAINED}/naivesynth.md",
    log:
        "logs/training/train_naivesynth.log",
    benchmark:
        "logs/training/benchmarks/train_naivesynth.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=4000,
    params:
        model="naivesynth",
        data=config.get("training", {}).get("texture_data", {}),
        settings=config.get("training", {}).get("naivesynth", {}),
        cache="results/training/naivesynth_materials.npz",
        checkpoint="results/training/naivesynth_checkpoint.pt",
        seed=config["seed"],
        code=code_hash("training.texture_run"),
    script:
        "../scripts/train_texture.py"
