"""The whole way from a plan and photos to a 3D house and a metric, by the library's functions.

    python examples/pipeline.py resources/examples/two_storeys my_house

Each stage writes files that the next one reads; the workflow runs the same functions as jobs.
"""

import sys
from pathlib import Path

from plan2scene.datasets.assignments import rooms_of_photos
from plan2scene.datasets.import_plan import import_plan
from plan2scene.evaluation.measure import Networks, measure_textures
from plan2scene.io import read_json, read_parquet
from plan2scene.mesh.build import build_house
from plan2scene.photos.crops.extract_crops import CropFiles, crops_of_house, write_crops
from plan2scene.photos.labels.labeller import labeller
from plan2scene.photos.locate.locate_photos import locate_photos, write_photo_rooms
from plan2scene.photos.masks import make_masks
from plan2scene.propagation.house_materials import find_materials
from plan2scene.propagation.propagate import propagate_house
from plan2scene.textures.house_textures import make_textures
from plan2scene.textures.inputs import HouseData, HouseFiles, TextureSettings, Visible
from plan2scene.textures.model.embedding import make_embeddings
from plan2scene.textures.observed_surfaces import select_surfaces

NAME, SEED, METHOD = {"house": "home", "dataset": "example"}, 0, "synth"
MODELS = Path(__file__).parents[1] / "resources" / "models"
TEXTURE, NAIVE, PROPAGATION, SEGMENTATION, FEATURES = (
    MODELS / f"{name}.safetensors"
    for name in ("texture", "naivesynth", "propagation", "segmentation", "features")
)


def make_house(home: Path, out: Path) -> float:
    """Make ``house.glb`` in `out` of a folder with plan.json, photos.csv and photos/.

    Returns the mean COLOR (0..1, less is better) of the textures of observed surfaces.
    """
    out.mkdir(parents=True, exist_ok=True)
    scene, masks, cameras = out / "scene.json", out / "masks", out / "cameras.json"
    tables = ("crops", "candidates", "planes", "colours")
    crops = CropFiles(*(out / f"{name}.parquet" for name in tables), out / "light.json")
    embeddings, surfaces = out / "embeddings.parquet", out / "surfaces.parquet"
    materials, propagated = out / "materials.parquet", out / "propagated.parquet"
    textures = out / "textures" / "0.0" / METHOD

    house = import_plan(home / "plan.json", scene, house_id="home")
    assigned = rooms_of_photos(home / "photos.csv", house)
    photos = {name: home / "photos" / name for name in assigned}
    make_masks(photos, lambda: labeller("embedded", model=SEGMENTATION), masks, house_id="home")
    locate_photos(house, assigned, masks, cameras)
    write_photo_rooms(house, assigned, cameras, out / "rooms.json", out / "photos.csv")
    rooms = read_json(out / "rooms.json")
    seen = crops_of_house(house, rooms, photos, masks, seed=SEED, cameras=cameras)
    write_crops(seen, crops, dataset="example", house_id="home")

    make_embeddings(crops.crops, embeddings, TEXTURE, NAIVE, seed=SEED, **NAME)
    select_surfaces(embeddings, crops.crops, [], surfaces, **NAME)
    find_materials(scene, surfaces, embeddings, crops.light, [], materials, **NAME)
    weights = {"propagation_model": PROPAGATION, "texture_model": TEXTURE, "predictor": "house"}
    known = {"materials": materials, "colours": crops.colours}
    propagate_house(scene, surfaces, propagated, **weights, **known, **NAME)

    data = HouseData(HouseFiles("home", scene, crops.crops))
    settings = TextureSettings(SEED, size_px=128)
    make_textures(METHOD, data.at(Visible(propagated), {"texture": TEXTURE}, settings), textures)
    build_house(scene, textures, out / "house.glb", out / "house.scene.json", house_id="home")

    metrics, networks = out / "metrics.parquet", Networks(FEATURES, FEATURES)
    folder, hidden = out / "textures", {"0.0": []}
    measure_textures(folder, crops.crops, hidden, [METHOD], metrics, networks=networks, **NAME)
    table, _ = read_parquet(metrics)
    return float(table.loc[table["observed"], "color"].mean())


if __name__ == "__main__":
    sys.stdout.write(f"COLOR {make_house(Path(sys.argv[1]), Path(sys.argv[2])):.3f}\n")
