"""Measure the errors of every predictor on unseen surfaces of real houses.

    python benchmarks/real_propagation.py HOUSE_FOLDER... [--work WORK] [--weights FILE ...]

House folders are those of `real_house.py`. A share of a house's rooms, or of its surfaces, is
hidden, by several seeds. Predictions of the hidden surfaces are compared with their true crops:
CIEDE2000 of the median colours, without any gain; mean over surfaces, standard deviation over
seeds. Visible surfaces are described by their true crops. With WORK, the results of
`real_house.py`, they are also described by the houses' own photos: crops, and colours of all
pixels, which only the predictor `house` uses.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from real_house import DATASET, Truth, difference, markdown, read_truth

from plan2scene.colour import median_colour
from plan2scene.house import SURFACES, SurfaceKey
from plan2scene.io import read_parquet
from plan2scene.paint.observations import HouseColours, house_colours
from plan2scene.plans.scene_json import read_scene_json
from plan2scene.propagation.graph import HouseGraph, house_graph
from plan2scene.propagation.graph_networks import load_propagation
from plan2scene.propagation.predictors import PREDICTORS, house_evidence
from plan2scene.seeds import generator
from plan2scene.textures.model.embedding import embed_crops
from plan2scene.textures.model.texture_model import load_texture_model

MODELS = Path(__file__).parents[1] / "resources" / "models"
SEEDS = range(8)


def by_true_crops(truth: Truth) -> HouseGraph:
    """Return the graph of a house in which surfaces with a true crop are observed."""
    model = load_texture_model(MODELS / "texture.safetensors")
    codes = embed_crops(model, np.stack(list(truth.medoids.values())), textureness=False).codes
    plan = read_scene_json(next(truth.folder.glob("scene/*.scene.json")), truth.house)
    return house_graph(plan, {SurfaceKey(*k): c for k, c in zip(truth.medoids, codes, strict=True)})


def by_photos(truth: Truth, results: Path) -> tuple[HouseGraph, HouseColours]:
    """Return the graph observed by the house's photos, and the colours of all surfaces in them."""
    table, _ = read_parquet(results / "drop_0.0" / truth.house / "surfaces.parquet")
    observed = {SurfaceKey(r.room_id, r.surface): r.embedding for r in table.itertuples()}
    plan = read_scene_json(results / "houses" / truth.house / "scene.json", truth.house)
    graph = house_graph(plan, observed)
    colours = results / "houses" / truth.house / "colours.parquet"
    return graph, house_colours(colours, (), graph.room_ids)


def hidings(graph: HouseGraph, share: float, rooms: bool) -> Iterator[np.ndarray]:
    """Yield the hidden surfaces, (n, 3) bool, of each seed: whole rooms or single surfaces."""
    shape = graph.observed.shape
    for seed in SEEDS:
        rng = generator(seed, "hidden", rooms)
        places = np.arange(shape[0] if rooms else graph.observed.size)
        hidden = np.isin(places, rng.permutation(places)[: round(share * len(places))])
        yield np.tile(hidden[:, None], shape[1]) if rooms else hidden.reshape(shape)


def errors(
    truth: Truth,
    graph: HouseGraph,
    shown: HouseColours | None,
    hidden: np.ndarray,
    weights: list[Path],
) -> dict[str, float]:
    """Return the mean CIEDE2000 of the hidden surfaces for each predictor and weights file."""
    kept = graph.observed & ~hidden
    visible = replace(graph, observed=kept, embeddings=graph.embeddings * kept[..., None])
    seen = None if shown is None else replace(shown, photos=shown.photos * ~hidden)
    found = {}
    for path in weights:
        network, means = load_propagation(path)
        told = seen or HouseColours.of_embeddings(visible.embeddings, kept)
        said = {"house's evidence alone": house_evidence(visible, means, told)}
        for name, predictor in PREDICTORS.items():
            said[name] = predictor(visible, network, means, seen).embedding
        for name, embedding in said.items():
            found[f"{name} ({path.stem})"] = np.mean(
                [
                    difference(np.clip(embedding[place][-3:], 0.0, 1.0), median_colour(image))
                    for key, image in truth.medoids.items()
                    if hidden[place := (graph.room_ids.index(key[0]), SURFACES.index(key[1]))]
                ]
            )
    return {name: float(value) for name, value in found.items()}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("houses", type=Path, nargs="+")
    parser.add_argument("--work", type=Path)
    parser.add_argument(
        "--weights", type=Path, nargs="+", default=[MODELS / "propagation.safetensors"]
    )
    parser.add_argument("--share", type=float, default=0.6)
    given = parser.parse_args()
    columns: dict[str, dict[str, str]] = {}
    for truth in map(read_truth, given.houses):
        told: dict[str, tuple[HouseGraph, HouseColours | None]] = {
            "true": (by_true_crops(truth), None)
        }
        if given.work:
            told["own"] = by_photos(truth, given.work / "results" / DATASET)
        for what, (graph, shown) in told.items():
            for rooms in (True, False):
                runs = [
                    errors(truth, graph, shown, hidden, given.weights)
                    for hidden in hidings(graph, given.share, rooms)
                ]
                head = f"{truth.house}, {what} crops, {'rooms' if rooms else 'surfaces'}"
                for name in runs[0]:
                    values = [run[name] for run in runs]
                    cell = f"{np.mean(values):.1f} ± {np.std(values, ddof=1):.1f}"
                    columns.setdefault(name, {})[head] = cell
    print(markdown([{"predictor": name} | cells for name, cells in columns.items()]))
    print(f"\n{given.share:.0%} hidden, {len(SEEDS)} hidings each.")


if __name__ == "__main__":
    main()
