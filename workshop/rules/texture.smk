REAL_TEXTURES = TRAINING["materials"].get("folder")


rule materials:
    # Textures that the texture models and the features network learn from, and others to measure.
    input:
        [f"{REAL_TEXTURES}/index.csv"] if REAL_TEXTURES else [],
    output:
        "results/training/materials.npz",
    log:
        "logs/training/materials.log",
    benchmark:
        "logs/training/benchmarks/materials.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=2000,
    params:
        settings=TRAINING["materials"],
        seed=config["seed"],
        code=code_hash("plan2scene_workshop.texture.data"),
    script:
        "../scripts/materials.py"


rule train_texture:
    # The models of methods synth (texture) and naivesynth, from the same textures.
    input:
        materials="results/training/materials.npz",
    output:
        model=f"{TRAINED}/{{model}}.safetensors",
        card=f"{TRAINED}/{{model}}.md",
    log:
        "logs/training/train_{model}.log",
    benchmark:
        "logs/training/benchmarks/train_{model}.tsv"
    wildcard_constraints:
        model="texture|naivesynth",
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=4000,
    params:
        settings=lambda wildcards: TRAINING[wildcards.model],
        checkpoint="results/training/{model}.checkpoint",
        seed=config["seed"],
        code=code_hash("plan2scene_workshop.texture.run"),
    script:
        "../scripts/train_texture.py"
