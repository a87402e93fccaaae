def label_model_of(wildcards):
    """Return the segmentation model; none where labels are read from a folder."""
    return (
        [] if config["photos"]["masks"] == "precomputed" else model_of("segmentation")
    )


def ready_masks_of(wildcards):
    """Return the label PNGs that the configured folder has for a house's photos."""
    if config["photos"]["masks"] != "precomputed":
        return []
    folder = Path(config["photos"]["masks_folder"] or "")
    paths = (folder / f"{Path(name).stem}.png" for name in photo_names_of(wildcards))
    return [str(path) for path in paths if path.is_file()]


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
    threads: 1
    resources:
        mem_mb=1500,
    params:
        names=photo_names_of,
        photo_folder=str(DATA_ROOT / "photos"),
        source=config["photos"]["masks"],
        masks_folder=config["photos"]["masks_folder"],
        fov_deg=config["photos"]["fov_deg"],
        code=code_hash(
            "photos.stage", "photos.segmentation", "photos.segmentation_pretrained"
        ),
    script:
        "../scripts/masks.py"


def masks_of(wildcards):
    """Return the masks folder of a house; none where crops are ready."""
    if config["crops"]["source"] == "precomputed":
        return []
    return f"{RESULTS}/houses/{wildcards.house}/masks"


@functools.cache
def ready_crops():
    """Return the ready crops of the configured folder by photo stem."""
    found = {}
    folder = config["crops"]["folder"]
    if config["crops"]["source"] == "precomputed" and folder:
        for path in sorted(Path(folder).glob("*/*_crop*.png")):
            found.setdefault(path.name.rsplit("_", 2)[0], []).append(str(path))
    return found


def ready_crops_of(wildcards):
    """Return the ready crops of a house's photos; none where crops are sampled."""
    stems = [Path(name).stem for name in photo_names_of(wildcards)]
    return [path for stem in stems for path in ready_crops().get(stem, [])]


rule crops:
    # Rectified 128x128 crops of each floor, wall and ceiling that a photo shows.
    input:
        scene=f"{RESULTS}/houses/{{house}}/scene.json",
        masks=masks_of,
        assignment=assignment_of,
        photos=photos_of,
        ready=ready_crops_of,
    output:
        f"{RESULTS}/houses/{{house}}/crops.parquet",
    log:
        f"logs/{DATASET}/crops/{{house}}.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/crops/{{house}}.tsv"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        photo_folder=str(DATA_ROOT / "photos"),
        dataset=DATASET,
        source=config["crops"]["source"],
        folder=config["crops"]["folder"],
        metres=config["crops"]["metres"],
        per_mask=config["crops"]["per_mask"],
        tries=config["crops"]["tries"],
        camera_height_m=config["photos"]["camera_height_m"],
        seed=config["seed"],
        code=code_hash("photos.crop_stage", "floorplans.scene_json", "datasets"),
    script:
        "../scripts/crops.py"
