from plan2scene.seeds import derive_seed


def test_a_seed_depends_on_every_name_and_is_the_same_for_ever():
    names = (0, "house", "room"), (1, "house", "room"), (0, "houser", "oom"), (0, "house")
    seeds = {derive_seed(*name) for name in names}
    assert len(seeds) == 4 and all(0 <= seed < 2**63 for seed in seeds)
    assert derive_seed(7, "house", "room", "floor") == 5481095270670824426
