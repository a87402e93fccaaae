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
