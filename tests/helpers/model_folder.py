import trimesh

HEADER = "file,class,width,depth,height,mount\n"


def model_folder(folder, count=16):
    rows = []
    for k in range(count):
        box = trimesh.creation.box((0.6, 0.8, 0.5))
        box.apply_translation((0, 0.4, 0))
        colour = trimesh.visual.material.PBRMaterial(baseColorFactor=[200, 40, 40, 255])
        box.visual = trimesh.visual.TextureVisuals(uv=box.vertices[:, :2], material=colour)
        box.export(folder / f"m{k}.glb")
        rows.append(f"m{k}.glb,{'table' if k % 3 == 0 else 'chair'},0.6,0.5,0.8,floor\n")
    (folder / "index.csv").write_text(HEADER + "".join(rows))
    return folder
