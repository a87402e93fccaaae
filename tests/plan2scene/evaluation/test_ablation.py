"""Ablations: each variant changes what it says and nothing else."""

import csv

import pytest

from plan2scene.evaluation.ablation import (
    MISSING,
    VARIANTS,
    ablate_house,
    ablation_table,
)
from plan2scene.evaluation.houses import propagated_at
from plan2scene.io import read_parquet

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
