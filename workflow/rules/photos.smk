rule masks:
    # Floor, wall, ceiling and other in each photo, and the photo's camera.
    input:
        **given(
            pretrained=pretrained_files(),
            ready=config["photos"]["masks"] == "precomputed" and ready_masks_of,
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
        code=code_hash(
            "plan2scene.photos.masks",
            "plan2scene.photos.labels.segmentation",
            "plan2scene.photos.labels.pretrained",
        ),
    script:
        "../scripts/masks.py"


rule crops:
    # Where in the plan each photo was taken, rectified 128x128 crops of each floor, wall and ceiling
    # that it shows, and a sheet of both to look at.
    input:
        # Photos come by way of their masks.
        **(
            {"masks": MASKS}
            if HAS_MASKS
            else {"photos": photos_of, "ready": ready_crops_of}
        ),
        scene=f"{RESULTS}/houses/{{house}}/scene.json",
        assignment=assignment_of,
    output:
        **({"cameras": CAMERAS} if HAS_MASKS else {}),
        crops=f"{RESULTS}/houses/{{house}}/crops.parquet",
        candidates=f"{RESULTS}/houses/{{house}}/candidates.parquet",
        colours=f"{RESULTS}/houses/{{house}}/colours.parquet",
        light=f"{RESULTS}/houses/{{house}}/light.json",
        sheet=report(
            f"{RESULTS}/houses/{{house}}/contact_sheet.png",
            caption="../report/contact_sheet.rst",
            category="Houses",
            subcategory="{house}",
            labels={"file": "photos to crops"},
        ),
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
        names=photo_names_of,
        photo_folder=str(LAYOUT.photos),
        dataset=DATASET,
        source=config["crops"]["source"],
        folder=config["crops"]["folder"],
        settings=dict(
            sizes_m=tuple(config["crops"]["metres"]),
            per_mask=config["crops"]["per_mask"],
            tries=config["crops"]["tries"],
            filter=config["crops"]["filter"],
            colours=config["house"]["colours"],
            camera_height_m=config["photos"]["camera_height_m"],
        ),
        seed=config["seed"],
        code=code_hash(
            "plan2scene.photos.crops.stage",
            "plan2scene.photos.locate.stage",
            "plan2scene.photos.contact_sheet.sheet",
            "plan2scene.plans.scene_json",
            "plan2scene.datasets.assignments",
        ),
    script:
        "../scripts/crops.py"
