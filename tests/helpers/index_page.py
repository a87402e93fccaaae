from plan2scene.io import write_text
from plan2scene.plans.scene_writer import write_scene_json
from plan2scene_app.viewer.index_page import write_index


def index_page(folder, house, table, dataset, method):
    """Write the index page of one house, `houses/small`, and of a table; return its file."""
    scene = folder / "houses" / "small" / "scene.json"
    write_scene_json(house, scene)
    write_text(folder / "table.csv", table)
    inputs = dict(scenes=[scene], table=folder / "table.csv", plot=folder / "table.png")
    write_index(folder / "index.html", **inputs, dataset=dataset, method=method)
    return folder / "index.html"
