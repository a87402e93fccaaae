rule masks:
    # Floor, wall, ceiling and other in each photo, and the photo's camera.
    input:
        photos=photos_of,
        model=label_model_of,
        ready=ready_masks_of,
    output:
        directory(f"{RESULTS}/houses/{{house}}/masks"),
    log:
        f"logs/{DATASET}/masks/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/masks/{{house}}.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        names=photo_names_of,
        photo_folder=str(LAYOUT.photos),
        source=config["photos"]["masks"],
        masks_folder=config["photos"]["masks_folder"],
        pretrained=config["photos"]["pretrained"],
        fov_deg=config["photos"]["fov_deg"],
        code=code_hash(
            "photos.masks", "photos.labels.segmentation", "photos.labels.pretrained"
        ),
    script:
        "../scripts/masks.py"


rule locate:
    # Where in the plan each photo was taken: cameras.json with room, position and heading.
    input:
        scene=f"{RESULTS}/houses/{{house}}/scene.json",
        masks=f"{RESULTS}/houses/{{house}}/masks",
        assignment=assignment_of,
    output:
        f"{RESULTS}/houses/{{house}}/cameras.json",
    log:
        f"logs/{DATASET}/locate/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/locate/{{house}}.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=500,
    params:
        code=code_hash("photos.locate.stage", "floorplans.scene_json", "datasets"),
    script:
        "../scripts/locate.py"


rule crops:
    # Rectified 128x128 crops of each floor, wall and ceiling that a photo shows.
    input:
        scene=f"{RESULTS}/houses/{{house}}/scene.json",
        masks=masks_of,
        cameras=cameras_of,
        assignment=assignment_of,
        photos=photos_of,
        ready=ready_crops_of,
    output:
        crops=f"{RESULTS}/houses/{{house}}/crops.parquet",
        candidates=f"{RESULTS}/houses/{{house}}/candidates.parquet",
        light=f"{RESULTS}/houses/{{house}}/light.json",
    log:
        f"logs/{DATASET}/crops/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/crops/{{house}}.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        photo_folder=str(LAYOUT.photos),
        dataset=DATASET,
        source=config["crops"]["source"],
        folder=config["crops"]["folder"],
        metres=config["crops"]["metres"],
        per_mask=config["crops"]["per_mask"],
        tries=config["crops"]["tries"],
        filter=config["crops"]["filter"],
        colours=config["house"]["colours"],
        camera_height_m=config["photos"]["camera_height_m"],
        seed=config["seed"],
        code=code_hash("photos.crops.stage", "floorplans.scene_json", "datasets"),
    script:
        "../scripts/crops.py"
