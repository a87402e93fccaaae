rule index_page:
    # One page that links every house's files, the table and the plot.
    input:
        scenes=house_files("scene.json"),
        houses=house_files(
            "house.glb",
            "preview.png",
            "rooms.jpg",
            "views.jpg",
            "patterns.jpg",
            "viewer.html",
        ),
        sheets=house_files("contact_sheet.png", "texture_sheet.png"),
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
        code=rule_code("index_page"),
    script:
        "../scripts/index_page.py"
