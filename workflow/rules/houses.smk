from plan2scene.provenance import PACKAGE, file_hash

# Textures of the configured method, with all photos.
CHOSEN_TEXTURES = f"{RESULTS}/drop_0.0/{config['house']['method']}/{{house}}/textures"


rule house:
    # The 3D house: GLB with embedded textures, scene.json with textures, and its preview (plan view
    # with room names, and oblique view): one start, as all three need the meshes.
    input:
        scene=f"{RESULTS}/houses/{{house}}/scene.json",
        textures=CHOSEN_TEXTURES,
    output:
        glb=f"{RESULTS}/houses/{{house}}/house.glb",
        scene=f"{RESULTS}/houses/{{house}}/house.scene.json",
        preview=report(
            f"{RESULTS}/houses/{{house}}/preview.png",
            caption="../report/preview.rst",
            category="Houses",
            subcategory="{house}",
            labels={"file": "preview"},
        ),
    log:
        f"logs/{DATASET}/house/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/house/{{house}}.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        code=code_hash("mesh.build"),
    script:
        "../scripts/house.py"


rule house_obj:
    # On demand: the house as OBJ with MTL and textures.
    input:
        scene=f"{RESULTS}/houses/{{house}}/scene.json",
        textures=CHOSEN_TEXTURES,
    output:
        obj=f"{RESULTS}/houses/{{house}}/obj/house.obj",
        mtl=f"{RESULTS}/houses/{{house}}/obj/house.mtl",
        textures=directory(f"{RESULTS}/houses/{{house}}/obj/house_textures"),
    log:
        f"logs/{DATASET}/house_obj/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/house_obj/{{house}}.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=500,
    params:
        code=code_hash("mesh.build"),
    script:
        "../scripts/house_obj.py"


rule viewer:
    # One offline HTML file with the house in it.
    input:
        glb=f"{RESULTS}/houses/{{house}}/house.glb",
    output:
        report(
            f"{RESULTS}/houses/{{house}}/viewer.html",
            caption="../report/viewer.rst",
            category="Houses",
            subcategory="{house}",
            labels={"file": "viewer"},
        ),
    log:
        f"logs/{DATASET}/viewer/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/viewer/{{house}}.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=500,
    params:
        code=code_hash("viewer.build"),
        # The page's own files are no Python: the hash above does not see them.
        page=[
            file_hash(path)
            for path in sorted((PACKAGE / "viewer").iterdir())
            if path.suffix in (".html", ".css", ".js")
        ],
    script:
        "../scripts/viewer.py"
