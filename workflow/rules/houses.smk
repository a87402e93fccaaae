def chosen_textures(wildcards):
    """Return the textures folder of the configured method, with all photos."""
    method = config["house"]["method"]
    return f"{RESULTS}/drop_0.0/{method}/{wildcards.house}/textures"


rule house:
    # The 3D house: GLB with embedded textures, and scene.json with textures.
    input:
        scene=f"{RESULTS}/houses/{{house}}/scene.json",
        textures=chosen_textures,
    output:
        glb=f"{RESULTS}/houses/{{house}}/house.glb",
        scene=f"{RESULTS}/houses/{{house}}/house.scene.json",
    log:
        f"logs/{DATASET}/house/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/house/{{house}}.tsv"
    threads: 1
    resources:
        mem_mb=500,
    params:
        code=code_hash("mesh.build"),
    script:
        "../scripts/house.py"


rule house_obj:
    # On demand: the house as OBJ with MTL and textures.
    input:
        scene=f"{RESULTS}/houses/{{house}}/scene.json",
        textures=chosen_textures,
    output:
        obj=f"{RESULTS}/houses/{{house}}/obj/house.obj",
        mtl=f"{RESULTS}/houses/{{house}}/obj/house.mtl",
        textures=directory(f"{RESULTS}/houses/{{house}}/obj/house_textures"),
    log:
        f"logs/{DATASET}/house_obj/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/house_obj/{{house}}.tsv"
    threads: 1
    resources:
        mem_mb=500,
    params:
        code=code_hash("mesh.build"),
    script:
        "../scripts/house_obj.py"
