rule texture_library:
    # Tileable textures from which method retrieve chooses.
    output:
        f"{RESULTS}/texture_library.parquet",
    log:
        f"logs/{DATASET}/texture_library.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/texture_library.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        folder=config["textures"]["library_folder"],
        per_substance=config["textures"]["library_tiles"],
        seed=config["seed"],
        size_px=config["textures"]["size_px"],
        code=rule_code("texture_library"),
    script:
        "../scripts/texture_library.py"


rule crop_pool:
    # On demand: crops of other houses, for surfaces without a crop in their own house.
    input:
        scenes=expand(f"{RESULTS}/houses/{{house}}/scene.json", house=POOL_HOUSES),
        crops=expand(f"{RESULTS}/houses/{{house}}/crops.parquet", house=POOL_HOUSES),
    output:
        f"{RESULTS}/crop_pool.parquet",
    log:
        f"logs/{DATASET}/crop_pool.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/crop_pool.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=2000,
    params:
        houses=POOL_HOUSES,
        dataset=DATASET,
        code=rule_code("crop_pool"),
    script:
        "../scripts/crop_pool.py"


rule textures:
    # A tile for every surface of a house by one method; for the 3D house also maps of surfaces.
    input:
        unpack(texture_inputs),
        scene=f"{RESULTS}/houses/{{house}}/scene.json",
        crops=f"{RESULTS}/houses/{{house}}/crops.parquet",
        propagated=f"{RESULTS}/drop_{{drop}}/{{house}}/propagated.parquet",
    output:
        directory(f"{RESULTS}/drop_{{drop}}/{{method}}/{{house}}/textures"),
    log:
        f"logs/{DATASET}/textures/{{drop}}/{{method}}/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/textures/{{drop}}/{{method}}/{{house}}.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: HOUSE_THREADS
    resources:
        mem_mb=worker_memory(1500, 1500),
    params:
        seed=config["seed"],
        size_px=config["textures"]["size_px"],
        textures=textures_of,
        code=rule_code("textures"),
        method=lambda wildcards: method_code(wildcards.method),
    script:
        "../scripts/textures.py"
