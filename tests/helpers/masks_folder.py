from plan2scene.io import write_json
from plan2scene.photos.labels.palette import write_label_png


def write_masks(folder, labels, cameras):
    """Write labels by stem and cameras by photo; nothing tells kinds of rooms or common spots."""
    for stem, image in labels.items():
        write_label_png(folder / f"{stem}.png", image)
    write_json(folder / "cameras.json", cameras)
    write_json(folder / "kinds.json", {"source": "embedded", "photos": {}})
    for name in ("spots", "turns", "likeness"):
        write_json(folder / f"{name}.json", [])
    return folder
