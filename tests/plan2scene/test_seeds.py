from plan2scene.seeds import derive_seed


def test_a_seed_depends_on_every_name_and_on_their_borders():
    seeds = {
        derive_seed(0, "house", "room"),
        derive_seed(1, "house", "room"),
        derive_seed(0, "houser", "oom"),
        derive_seed(0, "house"),
    }
    assert len(seeds) == 4
    assert all(0 <= seed < 2**63 for seed in seeds)


def test_a_seed_is_the_same_for_ever():
    assert derive_seed(7, "house", "room", "floor") == 5481095270670824426
