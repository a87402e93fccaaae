PHOTO_ROOMS = f"{RESULTS}/houses/{{house}}/photo_rooms.json"


rule masks:
    # For each photo: which pixels are floor, wall, ceiling or other, line segments, and the camera.
    input:
        **given(
            pretrained=pretrained_files(),
            precomputed=config["photos"]["masks"] == "precomputed"
            and precomputed_masks_of,
        ),
        photos=photos_of,
    output:
        directory(MASKS),
    log:
        f"logs/{DATASET}/masks/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/masks/{{house}}.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: HOUSE_THREADS
    resources:
        mem_mb=3000,
    params:
        names=photo_names_of,
        models=label_model(),
        hashes=hashes(label_model()),
        photo_folder=str(LAYOUT.photos),
        source=config["photos"]["masks"],
        masks_folder=config["photos"]["masks_folder"],
        pretrained=config["photos"]["pretrained"],
        openings=config["photos"]["openings"],
        fov_deg=config["photos"]["fov_deg"],
        known_fov_deg=config["photos"]["known_fov_deg"],
        find_rooms=finds_rooms,
        contents=contents_of(
            photos_of,
            *(
                [precomputed_masks_of]
                if config["photos"]["masks"] == "precomputed"
                else []
            ),
        ),
        code=rule_code("masks"),
    script:
        "../scripts/masks.py"


rule places:
    # For each photo: where in the plan it was taken, and which rooms it shows.
    input:
        **given(masks=HAS_MASKS and MASKS),
        scene=f"{RESULTS}/houses/{{house}}/scene.json",
        assignment=assignment_of,
    output:
        **given(cameras=HAS_MASKS and CAMERAS),
        rooms=PHOTO_ROOMS,
        table=f"{RESULTS}/houses/{{house}}/photos.csv",
    log:
        f"logs/{DATASET}/places/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/places/{{house}}.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: HOUSE_THREADS
    resources:
        mem_mb=worker_memory(1000, 300),
    params:
        traced=is_traced,
        contents=contents_of(assignment_of),
        name_hints=config["photos"]["name_hints"],
        code=rule_code("places"),
    script:
        "../scripts/places.py"


rule crops:
    # Rectified 128x128 crops of each floor, wall and ceiling that the photos show, the planes that
    # they were cut from, the surfaces' colours and the photos' light.
    input:
        # The masks depend on the photos, so the photos need not be inputs here.
        **(
            {"masks": MASKS, "cameras": CAMERAS}
            if HAS_MASKS
            else {"photos": photos_of, "precomputed": precomputed_crops_of}
        ),
        rooms=PHOTO_ROOMS,
        scene=f"{RESULTS}/houses/{{house}}/scene.json",
    output:
        crops=f"{RESULTS}/houses/{{house}}/crops.parquet",
        candidates=f"{RESULTS}/houses/{{house}}/candidates.parquet",
        planes=f"{RESULTS}/houses/{{house}}/planes.parquet",
        colours=f"{RESULTS}/houses/{{house}}/colours.parquet",
        light=f"{RESULTS}/houses/{{house}}/light.json",
    log:
        f"logs/{DATASET}/crops/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/crops/{{house}}.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: HOUSE_THREADS
    resources:
        mem_mb=worker_memory(1000, 300),
    params:
        photo_folder=str(LAYOUT.photos),
        dataset=DATASET,
        folder=CROPS["folder"],
        settings=dict(
            sizes_m=tuple(CROPS["metres"]),
            per_mask=CROPS["per_mask"],
            tries=CROPS["tries"],
            filter=CROPS["filter"],
            camera_height_m=config["photos"]["camera_height_m"],
        ),
        seed=config["seed"],
        contents=None if HAS_MASKS else contents_of(photos_of, precomputed_crops_of),
        code=rule_code("crops"),
    script:
        "../scripts/crops.py"


rule doubts:
    # A page that shows the plan, each photo in its room, and doubtful results.
    input:
        unpack(trace_files),
        **given(masks=HAS_MASKS and MASKS, cameras=HAS_MASKS and CAMERAS),
        table=f"{RESULTS}/houses/{{house}}/photos.csv",
        scene=f"{RESULTS}/houses/{{house}}/scene.json",
    output:
        f"{RESULTS}/houses/{{house}}/doubts.html",
    log:
        f"logs/{DATASET}/doubts/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/doubts/{{house}}.tsv"
    priority: -1  # after jobs that other jobs wait for
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=800,
    params:
        photo_folder=str(LAYOUT.photos),
        code=rule_code("doubts"),
    script:
        "../scripts/doubts.py"


rule contact_sheet:
    # A picture of what the rules above found in each photo. No other rule reads it.
    input:
        **given(masks=HAS_MASKS and MASKS, cameras=HAS_MASKS and CAMERAS),
        rooms=PHOTO_ROOMS,
        crops=f"{RESULTS}/houses/{{house}}/crops.parquet",
        candidates=f"{RESULTS}/houses/{{house}}/candidates.parquet",
        planes=f"{RESULTS}/houses/{{house}}/planes.parquet",
        scene=f"{RESULTS}/houses/{{house}}/scene.json",
    output:
        report(
            f"{RESULTS}/houses/{{house}}/contact_sheet.png",
            caption="../report/contact_sheet.rst",
            category="Houses",
            subcategory="{house}",
            labels={"file": "photos to crops"},
        ),
    log:
        f"logs/{DATASET}/contact_sheet/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/contact_sheet/{{house}}.tsv"
    priority: -1  # after jobs that other jobs wait for
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1  # other jobs of its house run at the same time
    resources:
        mem_mb=1000,
    params:
        names=photo_names_of,
        photo_folder=str(LAYOUT.photos),
        code=rule_code("contact_sheet"),
    script:
        "../scripts/contact_sheet.py"
