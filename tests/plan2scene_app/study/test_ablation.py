from plan2scene.io import read_parquet
from plan2scene_app.study.ablation import VARIANTS, ablate_house


def test_variants_change_only_the_surfaces_they_are_about(house, embeddings, tmp_path_factory):
    path = tmp_path_factory.mktemp("ablation") / "ablation.parquet"
    ablate_house(house, embeddings, path, hidden={"0.0": [], "0.6": ["p1.jpg", "p3.jpg"]})
    frame, _ = read_parquet(path)
    index = ["drop", "room_id", "surface", "observed"]
    colour = frame.pivot_table(index=index, columns="method", values="tile")
    assert set(colour.columns) == {variant.name for variant in VARIANTS}
    observed = colour[colour.index.get_level_values("observed")]
    for name in ("no_graph", "room_type_mean", "house_mean", "nearest_room"):
        assert (observed[name] == observed["synth"]).all()
    # The untrained network of this test hardly tells edges: test_without_the_graph looks closer.
    for name in ("room_type_mean", "house_mean", "nearest_room"):
        assert (colour[name] != colour["synth"]).any(), name
    for name in ("mean_embedding", "rgb"):
        assert (observed[name] != observed["synth"]).any(), name
