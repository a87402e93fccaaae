from plan2scene_app.exports.registry import exports

# Textures by the configured method, from all photos.
CHOSEN_TEXTURES = f"{RESULTS}/drop_0.0/{config['house']['method']}/{{house}}/textures"
# Textures of the 3D house.
SHOWN_TEXTURES = (
    f"{RESULTS}/houses/{{house}}/textures"
    if config["house"]["colours"] == "paint"
    else CHOSEN_TEXTURES
)


wildcard_constraints:
    export="|".join(exports()),


rule patterns:
    # The planks and tiles of the floors that photos show: kind, size, direction.
    input:
        masks=MASKS,
        cameras=CAMERAS,
        planes=f"{RESULTS}/houses/{{house}}/planes.parquet",
        scene=f"{RESULTS}/houses/{{house}}/scene.json",
        crops=f"{RESULTS}/houses/{{house}}/crops.parquet",
        embeddings=EMBEDDINGS,
        materials=f"{RESULTS}/drop_0.0/{{house}}/materials.parquet",
    output:
        PATTERNS,
    log:
        f"logs/{DATASET}/patterns/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/patterns/{{house}}.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: threads_by_photos
    resources:
        mem_mb=worker_memory(1000, 500),
    params:
        photo_folder=str(LAYOUT.photos),
        dataset=DATASET,
        code=rule_code("patterns"),
    script:
        "../scripts/patterns.py"


rule paint:
    # The paint colours of surfaces and doors, without the photos' light, and the textures of the 3D
    # house in these colours. Finishes that the owner set by hand replace them.
    input:
        unpack(finish_files),
        scene=f"{RESULTS}/houses/{{house}}/scene.json",
        textures=CHOSEN_TEXTURES,
        colours=f"{RESULTS}/houses/{{house}}/colours.parquet",
        materials=f"{RESULTS}/drop_0.0/{{house}}/materials.parquet",
    output:
        paint=f"{RESULTS}/houses/{{house}}/paint.parquet",
        textures=directory(f"{RESULTS}/houses/{{house}}/textures"),
    log:
        f"logs/{DATASET}/paint/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/paint/{{house}}.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        dataset=DATASET,
        accents=config["house"]["walls"] == "wall",
        contents=contents_of(finish_files),
        code=rule_code("paint"),
    script:
        "../scripts/paint.py"


rule house:
    # The 3D house: GLB with embedded textures, and scene.json with textures.
    input:
        scene=f"{RESULTS}/houses/{{house}}/scene.json",
        textures=SHOWN_TEXTURES,
    output:
        glb=f"{RESULTS}/houses/{{house}}/house.glb",
        scene=f"{RESULTS}/houses/{{house}}/house.scene.json",
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
        objects=config["house"]["objects"],
        relief=config["house"]["relief"],
        code=rule_code("house"),
    script:
        "../scripts/house.py"


rule pictures:
    # Pictures: the house from above, each room at eye level, each located photo beside a render.
    input:
        **given(
            cameras=HAS_MASKS and CAMERAS,
            patterns=HAS_MASKS and PATTERNS,
        ),
        scene=f"{RESULTS}/houses/{{house}}/scene.json",
        textures=SHOWN_TEXTURES,
    output:
        preview=report(
            f"{RESULTS}/houses/{{house}}/preview.png",
            caption="../report/preview.rst",
            category="Houses",
            subcategory="{house}",
            labels={"file": "preview"},
        ),
        rooms=report(
            f"{RESULTS}/houses/{{house}}/rooms.jpg",
            caption="../report/rooms.rst",
            category="Houses",
            subcategory="{house}",
            labels={"file": "rooms"},
        ),
        views=report(
            f"{RESULTS}/houses/{{house}}/views.jpg",
            caption="../report/views.rst",
            category="Houses",
            subcategory="{house}",
            labels={"file": "beside photos"},
        ),
        patterns=report(
            f"{RESULTS}/houses/{{house}}/patterns.jpg",
            caption="../report/patterns.rst",
            category="Houses",
            subcategory="{house}",
            labels={"file": "floors"},
        ),
    log:
        f"logs/{DATASET}/pictures/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/pictures/{{house}}.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: threads_by_photos
    resources:
        mem_mb=worker_memory(1500, 300),
    params:
        objects=config["house"]["objects"],
        traced=config["house"]["pictures"] == "traced",
        names=photo_names_of,
        photo_folder=str(LAYOUT.photos),
        code=rule_code("pictures"),
    script:
        "../scripts/pictures.py"


rule viewer:
    # One offline page with the house in 3D, its crops and the places of its photos.
    input:
        **given(cameras=HAS_MASKS and CAMERAS, photos=HAS_MASKS and photos_of),
        propagated=f"{RESULTS}/drop_0.0/{{house}}/propagated.parquet",
        crops=f"{RESULTS}/houses/{{house}}/crops.parquet",
        scene=f"{RESULTS}/houses/{{house}}/scene.json",
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
        mem_mb=1000,
    params:
        photo_folder=str(LAYOUT.photos),
        code=rule_code("viewer"),
    script:
        "../scripts/viewer.py"


rule lit_house:
    # On demand: the house with baked light in unlit textures.
    input:
        scene=f"{RESULTS}/houses/{{house}}/scene.json",
        textures=SHOWN_TEXTURES,
    output:
        f"{RESULTS}/houses/{{house}}/house_lit.glb",
    log:
        f"logs/{DATASET}/lit_house/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/lit_house/{{house}}.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=2000,
    params:
        objects=config["house"]["objects"],
        code=rule_code("lit_house"),
    script:
        "../scripts/lit_house.py"


rule export_house:
    # On demand: the house for other programs, docs/exports.md.
    input:
        scene=f"{RESULTS}/houses/{{house}}/scene.json",
        textures=SHOWN_TEXTURES,
    output:
        directory(f"{RESULTS}/houses/{{house}}/exports/{{export}}"),
    log:
        f"logs/{DATASET}/export_house/{{house}}_{{export}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/export_house/{{house}}_{{export}}.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        objects=config["house"]["objects"],
        code=rule_code("export_house"),
        export=lambda wildcards: export_code(wildcards.export),
    script:
        "../scripts/export_house.py"
