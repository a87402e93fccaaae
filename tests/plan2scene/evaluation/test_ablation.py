"""Ablations: each variant changes what it says and nothing else."""

import csv
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from plan2scene.evaluation.ablation import (
    MISSING,
    VARIANTS,
    Variant,
    ablate_house,
    ablation_table,
    plane_noise_model,
    predicted,
    selected,
)
from plan2scene.evaluation.houses import propagated_at
from plan2scene.house import ROOM_TYPES, SurfaceKey
from plan2scene.io import read_parquet
from plan2scene.propagation.graph_networks import load_propagation
from plan2scene.textures.model.texture_model import load_texture_model

HIDDEN = {"0.0": [], "0.6": ["p1.jpg", "p3.jpg"]}


@pytest.fixture
def at(house, embeddings, tmp_path):
    """Return a function: hidden photos to the tables of the stages."""

    def read(hidden):
        surfaces, propagated = propagated_at(house, embeddings, hidden, tmp_path)
        paths = (surfaces, house.files.crops, embeddings, propagated)
        return tuple(read_parquet(path)[0] for path in paths)

    return read


@pytest.fixture
def tables(at):
    return at(HIDDEN["0.6"])


def _select(tables, hidden, **changes):
    surfaces, crops, embeddings, _ = tables
    variant = Variant("v", "", **changes)
    return selected(surfaces, crops, embeddings, hidden, variant, house="h1", seed=0)


def _codes(embeddings, crops, column="embedding"):
    rows = embeddings["crop_id"].isin(crops)
    return np.stack([np.asarray(code) for code in embeddings[rows][column]])


def test_the_whole_method_selects_as_the_stage_does(tables):
    pd.testing.assert_frame_equal(_select(tables, HIDDEN["0.6"]), tables[0], check_dtype=False)


def test_mean_embedding_is_the_mean_of_visible_crops(at):
    tables = at([])
    row = _select(tables, [], select="mean").set_index(["room_id", "surface"]).loc["bed", "floor"]
    np.testing.assert_allclose(
        row["embedding"], _codes(tables[2], ["a", "b", "c"]).mean(axis=0), rtol=1e-5
    )


def _predict(plan, tables, models, how):
    frame = predicted(plan, tables[3], Variant("v", "", propagate=how), models)
    return {SurfaceKey(r.room_id, r.surface): np.asarray(r.embedding) for r in frame.itertuples()}


@pytest.mark.parametrize("how", ["no_graph", "room_type_mean", "house_mean", "nearest_room"])
def test_observed_surfaces_keep_their_embedding(plan, tables, models, how):
    made = _predict(plan, tables, models, how)
    for row in tables[3][tables[3]["observed"]].itertuples():
        np.testing.assert_array_equal(made[row.room_id, row.surface], row.embedding)


def test_without_the_graph_a_room_does_not_hear_of_others(plan, tables, models):
    with_graph = _predict(plan, tables, models, "network")
    without = _predict(plan, tables, models, "no_graph")
    assert not np.allclose(without["bath", "floor"], with_graph["bath", "floor"])
    # The loft has no door: nothing changes for it.
    np.testing.assert_allclose(without["loft", "floor"], with_graph["loft", "floor"], atol=1e-6)
    alone = predicted(
        replace(plan, doors=()), tables[3], Variant("v", "", propagate="no_graph"), models
    )
    np.testing.assert_allclose(
        np.stack(list(alone["embedding"])), np.stack(list(without.values())), atol=1e-6
    )


def test_means_and_nearest_rooms(plan, tables, models):
    _, means = load_propagation(models.propagation)
    # Visible at that drop: crops c (bed floor), d (hall floor), e (hall wall).
    seen = {
        (r.room_id, r.surface): np.asarray(r.embedding)
        for r in tables[3].itertuples()
        if r.observed
    }
    assert set(seen) == {("bed", "floor"), ("hall", "floor"), ("hall", "wall")}
    of_type = _predict(plan, tables, models, "room_type_mean")
    expected, _ = means.predict(np.array([name == "Bathroom" for name in ROOM_TYPES]))
    np.testing.assert_allclose(of_type["bath", "floor"], expected[0], rtol=1e-6)
    of_house = _predict(plan, tables, models, "house_mean")
    both = (seen["bed", "floor"] + seen["hall", "floor"]) / 2
    np.testing.assert_allclose(of_house["bath", "floor"], both, rtol=1e-6)
    np.testing.assert_allclose(of_house["bath", "ceiling"], expected[2], rtol=1e-6)
    nearest = _predict(plan, tables, models, "nearest_room")
    np.testing.assert_array_equal(nearest["bath", "floor"], seen["hall", "floor"])  # not bed's
    np.testing.assert_array_equal(nearest["bed", "wall"], seen["hall", "wall"])
    np.testing.assert_allclose(nearest["loft", "floor"], both, rtol=1e-6)  # no door leads there


def test_plane_noise_is_another_noise_of_the_same_weights(models, tmp_path):
    made = load_texture_model(plane_noise_model(models.texture, tmp_path / "m.safetensors"))
    whole = load_texture_model(models.texture)
    assert made.architecture == replace(whole.architecture, periodic=False)
    for name, value in whole.state_dict().items():
        assert (made.state_dict()[name] == value).all(), name


@pytest.fixture(scope="module")
def ablated(house, embeddings, tmp_path_factory):
    path = tmp_path_factory.mktemp("ablation") / "ablation.parquet"
    ablate_house(house, embeddings, path, hidden=HIDDEN)
    return path


def test_variants_change_only_the_surfaces_they_are_about(ablated):
    frame, _ = read_parquet(ablated)
    colour = frame.pivot_table(
        index=["drop", "room_id", "surface", "observed"], columns="method", values="tile"
    )
    assert set(colour.columns) == {variant.name for variant in VARIANTS}
    observed = colour[colour.index.get_level_values("observed")]
    for name in ("no_graph", "room_type_mean", "house_mean", "nearest_room"):
        assert (observed[name] == observed["synth"]).all()
    # The untrained network of this test hardly tells edges: test_without_the_graph looks closer.
    for name in ("room_type_mean", "house_mean", "nearest_room"):
        assert (colour[name] != colour["synth"]).any(), name
    for name in ("mean_embedding", "rgb"):
        assert (observed[name] != observed["synth"]).any(), name


def test_the_table_as_csv_markdown_and_latex(ablated, references, tmp_path):
    paths = [tmp_path / f"ablation.{suffix}" for suffix in ("csv", "md", "tex")]
    ablation_table([ablated], [references], *paths, dataset="d", houses=["h1"], drop="0.6", seed=0)
    rows = list(csv.DictReader(paths[0].open()))
    assert [(row["variant"], row["column"]) for row in rows] == [
        (variant.name, column)
        for variant in VARIANTS
        for column in ("observed", "unobserved", "all")
    ]
    assert {(row["column"], row["drop"]) for row in rows} == {
        ("observed", "0.0"),
        ("unobserved", "0.6"),
        ("all", "0.6"),
    }
    assert all(value != "" for row in rows for value in row.values())
    text = paths[1].read_text()
    for name in (*(variant.name for variant in VARIANTS), *MISSING):
        assert f"`{name}`" in text
    first = rows[0]
    assert f"| synth | observed | {first['n']} | {float(first['COLOR']):.3f} |" in text
    latex = paths[2].read_text()
    assert latex.count("no\\_graph & ") == 3
    assert r"\toprule" in latex
    assert "% no_substance_head: not measured" in latex
