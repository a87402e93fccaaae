# A target for each stage over the whole data set: `snakemake -j2 all_masks`.
rule all_plans:
    input:
        house_files("scene.json"),


rule all_masks:
    input:
        house_files("masks"),


rule all_places:
    input:
        house_files("cameras.json"),


rule all_crops:
    input:
        house_files("crops.parquet"),


rule all_embeddings:
    input:
        house_files("embeddings.parquet"),


rule all_surfaces:
    input:
        at_all_drops("surfaces.parquet"),


rule all_materials:
    input:
        at_all_drops("materials.parquet"),


rule all_propagated:
    input:
        at_all_drops("propagated.parquet"),


rule all_textures:
    # The textures of the 3D houses, and those by every method of the table.
    input:
        expand(CHOSEN_TEXTURES, house=HOUSES),
        expand(COMPARED, house=HOUSES),


rule all_meshes:
    input:
        house_files("house.glb"),


rule all_metrics:
    input:
        house_files("metrics.parquet", "reference_features.parquet"),
