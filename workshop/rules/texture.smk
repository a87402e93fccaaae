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
        data=TRAINING["texture_data"],
        settings=TRAINING["texture"],
        cache="results/training/texture_materials.npz",
        checkpoint="results/training/texture_checkpoint.pt",
        seed=config["seed"],
        code=code_hash("texture.run"),
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
        data=TRAINING["texture_data"],
        settings=TRAINING["naivesynth"],
        cache="results/training/naivesynth_materials.npz",
        checkpoint="results/training/naivesynth_checkpoint.pt",
        seed=config["seed"],
        code=code_hash("texture.run"),
    script:
        "../scripts/train_texture.py"
