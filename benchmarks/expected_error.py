"""Compare the expected errors of a house's colours with the true ones, with hidden photos.

    python benchmarks/expected_error.py results/demo resources/demo
    python benchmarks/expected_error.py RESULTS FLAT...    # flats: folders as of `real_house.py`

RESULTS is results/{dataset}. In each house 60 % of the photos are hidden, by several seeds, and the
paint of all surfaces is estimated from the others. The true error is CIEDE2000 to the true
material, or to the true crop of a flat. True crops contain the light of their rooms, so the paint
of a flat is first scaled by one gain (three factors, the median) for each seed. The script prints
the area under the ROC curve of "error above 6" by the expected error, and the means of expected and
true error. Limit: embeddings of visible surfaces still use the hidden photos; colours do not.
"""

import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from real_house import markdown, read_truth
from scipy.stats import rankdata

from plan2scene.colour import (
    delta_e_2000,
    linear_to_srgb,
    median_colour,
    rgb_to_lab,
    srgb_to_linear,
)
from plan2scene.house import SurfaceKey
from plan2scene.images import read_image
from plan2scene.io import read_parquet
from plan2scene.paint.estimate import PaintPrior, estimate_paint
from plan2scene.paint.observations import house_colours
from plan2scene.paint.surfaces import (
    MOST_PAINT,
    floor_materials,
    joined,
    observations_of,
    paint_gains,
    plain_whites,
)
from plan2scene.plans.scene_json import read_scene_json
from plan2scene.propagation.graph import house_graph
from plan2scene.propagation.graph_networks import load_propagation
from plan2scene.propagation.predictors import PREDICTORS
from plan2scene.seeds import generator
from plan2scene.textures.painted import expected_error

MODEL = Path(__file__).parents[1] / "resources" / "models" / "propagation.safetensors"
HIDDEN, SEEDS, FAR = 0.6, range(4), 6.0
Colours = Mapping[SurfaceKey, np.ndarray]


def guessed(results: Path, name: str, seed: int) -> tuple[Colours, dict[SurfaceKey, float]]:
    """Return the linear paint (3,) and the expected error of all surfaces of a house."""
    folder, stage = results / "houses" / name, results / "drop_0.0" / name
    colours = folder / "colours.parquet"
    photos = np.array(sorted(set(read_parquet(colours)[0]["photo"])))
    hidden = set(generator(seed, "hidden").permutation(photos)[: round(HIDDEN * len(photos))])
    crops, _ = read_parquet(folder / "crops.parquet")
    shown_crops = crops[~crops["photo"].isin(hidden)]
    visible = set(zip(shown_crops["room_id"], shown_crops["surface"], strict=True))
    table, _ = read_parquet(stage / "surfaces.parquet")
    observed = {
        SurfaceKey(row.room_id, row.surface): row.embedding
        for row in table.itertuples()
        if (row.room_id, row.surface) in visible
    }
    plan = read_scene_json(folder / "scene.json", name)
    graph = house_graph(plan, observed)
    in_photos = house_colours(colours, hidden, graph.room_ids)
    told = PREDICTORS["house"](graph, *load_propagation(MODEL), in_photos)
    usual = np.where(graph.observed[..., None], graph.embeddings, told.embedding)[..., -3:]
    srgb = np.where(in_photos.photos[..., None] > 0, told.seen, usual)
    shown = {
        key: np.maximum(srgb_to_linear(np.clip(srgb[graph.place(key)], 0.0, 1.0)), 1e-3)
        for key in plan.surface_keys()
    }
    seen = [item for item in observations_of(colours) if item.photo not in hidden]
    one, owner = joined(seen, floor_materials(stage / "materials.parquet"))
    estimate = estimate_paint(one)
    paint = {key: estimate.paint[same] for key, same in owner.items()}
    white = frozenset(key for key, same in owner.items() if same in estimate.white)
    unseen = shown.keys() - observed.keys()
    whites = plain_whites(paint, white, unseen)
    gains = paint_gains(shown, paint, whites, np.exp(PaintPrior().white[0]) * np.ones(3), unseen)
    expected = {
        key: expected_error(key, seen=key in paint, coloured=key in paint and key not in white)
        for key in shown
    }
    return {key: np.minimum(gains[key] * shown[key], MOST_PAINT) for key in shown}, expected


def truths(results: Path, folders: list[Path]) -> Iterator[tuple[str, Colours, bool]]:
    """Yield a house, the linear colours of its true materials or crops, and whether from crops."""
    if not (folders[0] / "truth").is_dir():
        for truth in map(read_truth, folders):
            images = {SurfaceKey(*key): image for key, image in truth.medoids.items()}
            yield truth.house, _medians(images), True
        return
    for house in sorted((results / "houses").iterdir()):
        materials = (folders[0] / "truth" / "test" / house.name / "materials").glob("*.png")
        images = {SurfaceKey(*f.stem.rsplit("_", 1)): read_image(f) for f in materials}
        yield house.name, _medians(images), False


def _medians(images: Mapping[SurfaceKey, np.ndarray]) -> Colours:
    return {key: srgb_to_linear(median_colour(image)) for key, image in images.items()}


def main(results: Path, folders: list[Path]) -> None:
    said: dict[str, list[tuple[float, float]]] = {}
    for name, true, lit in truths(results, folders):
        for seed in SEEDS:
            paint, expected = guessed(results, name, seed)
            keys = sorted(paint.keys() & true.keys())
            colours = np.array([[paint[key], true[key]] for key in keys])
            logs = np.log(colours + 1e-4)
            if lit:
                colours[:, 0] *= np.exp(np.median(logs[:, 1] - logs[:, 0], axis=0))
            labs = rgb_to_lab(linear_to_srgb(np.clip(colours, 0.0, 1.0)))
            off = delta_e_2000(labs[:, 0], labs[:, 1])
            pairs = [(expected[key], float(d)) for key, d in zip(keys, off, strict=True)]
            for group in {name if lit else "all", "all"}:
                said.setdefault(group, []).extend(pairs)
    rows = []
    for group, pairs in said.items():
        sure, off = np.array(pairs).T
        far = off > FAR
        above = rankdata(sure)[far].sum() - far.sum() * (far.sum() + 1) / 2
        rows.append(
            {
                "houses": group,
                "surfaces": len(off),
                "area": f"{above / (far.sum() * (~far).sum()):.2f}",
                "expected": f"{sure.mean():.1f}",
                "true": f"{off.mean():.1f}",
            }
        )
    print(markdown(rows))


if __name__ == "__main__":
    main(Path(sys.argv[1]), list(map(Path, sys.argv[2:])))
