# Config `weights: official`: the authors' released checkpoints as weight files of this program;
# config `metrics`: the networks of SUBS, FID and KID.
wildcard_constraints:
    network="texture|naivesynth|vgg16|inception",


rule convert_checkpoint:
    # Only tensors are read: a file that contains code, or is of another network, is refused.
    input:
        lambda wildcards: (config["official"] | config["metrics"])[wildcards.network],
    output:
        f"{RESULTS}/weights/{{network}}.safetensors",
    log:
        f"logs/{DATASET}/convert_checkpoint/{{network}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/convert_checkpoint/{{network}}.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=2500,
    params:
        substances=config["official"]["substances"],
        code=rule_code("convert_checkpoint"),
    script:
        "../scripts/convert_checkpoint.py"


rule convert_propagation:
    # The network, and the means over training surfaces, which its checkpoint does not contain.
    input:
        checkpoint=lambda wildcards: config["official"]["propagation"],
        scenes=expand(f"{RESULTS}/houses/{{house}}/scene.json", house=MEANS_HOUSES),
        crops=expand(f"{RESULTS}/houses/{{house}}/crops.parquet", house=MEANS_HOUSES),
        texture_model=model_of("texture"),
        naive_model=model_of("naivesynth"),
    output:
        f"{RESULTS}/weights/propagation.safetensors",
    log:
        f"logs/{DATASET}/convert_propagation.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/convert_propagation.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=2000,
    params:
        houses=MEANS_HOUSES,
        seed=config["seed"],
        code=rule_code("convert_propagation"),
    script:
        "../scripts/convert_propagation.py"
