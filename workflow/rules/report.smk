rule index_page:
    # One page that links every house's files, the table and the plot.
    input:
        scenes=house_files("scene.json"),
        glbs=house_files("house.glb"),
        previews=house_files("preview.png"),
        viewers=house_files("viewer.html"),
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
        code=code_hash("report"),
        page=[
            file_hash(PACKAGE / "viewer" / name)
            for name in ("index.html", "index.css")
        ],
    script:
        "../scripts/index_page.py"
