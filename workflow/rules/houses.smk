from plan2scene.exports.registry import EXPORTS
from plan2scene.provenance import PACKAGE, file_hash

# Textures of the configured method, with all photos.
CHOSEN_TEXTURES = f"{RESULTS}/drop_0.0/{config['house']['method']}/{{house}}/textures"


wildcard_constraints:
    export="|".join(EXPORTS),


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


rule export_house:
    # On demand: the house for other programs, docs/exports.md.
    input:
        scene=f"{RESULTS}/houses/{{house}}/scene.json",
        textures=CHOSEN_TEXTURES,
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
        code=code_hash("exports.registry"),
    script:
        "../scripts/export_house.py"


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
