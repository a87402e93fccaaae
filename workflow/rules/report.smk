rule contact_sheet:
    # What became of each photo of a house on the way to crops, to look at.
    input:
        **({"masks": MASKS, "cameras": CAMERAS} if HAS_MASKS else {"photos": photos_of}),
        scene=f"{RESULTS}/houses/{{house}}/scene.json",
        assignment=assignment_of,
        crops=f"{RESULTS}/houses/{{house}}/crops.parquet",
        candidates=f"{RESULTS}/houses/{{house}}/candidates.parquet",
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
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        names=photo_names_of,
        photo_folder=str(LAYOUT.photos),
        camera_height_m=config["photos"]["camera_height_m"],
        code=code_hash(
            "photos.contact_sheet.sheet",
            "floorplans.scene_json",
            "datasets.assignments",
        ),
    script:
        "../scripts/contact_sheet.py"


rule index_page:
    # One page that links every house's files, the table and the plot. Of the files that a job makes
    # together, one is named.
    input:
        scenes=house_files("scene.json"),
        linked=house_files("viewer.html", "contact_sheet.png", "texture_sheet.png"),
        table=f"{RESULTS}/tables/paper_table.csv",
        plot=f"{RESULTS}/tables/paper_table.png",
    output:
        f"{RESULTS}/index.html",
    log:
        f"logs/{DATASET}/index_page.log",
    benchmark:
        f"logs/{DATASET}/benchmarks/index_page.tsv"
    conda:
        "../../envs/plan2scene.yaml"
    threads: 1
    resources:
        mem_mb=500,
    params:
        dataset=DATASET,
        method=config["house"]["method"],
        code=code_hash("viewer.index_page"),
    script:
        "../scripts/index_page.py"
