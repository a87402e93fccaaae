import pandas as pd
from sample_houses import rooms_in_a_row

from plan2scene.house import House
from plan2scene.propagation.substances import jointed_floors


def test_wood_and_tiles_have_joints_and_carpet_none():
    looks = {"den": [0.0, 0.0, 1.0, 0.0], "hall": [0.6, 0.0, 0.0, 0.4]}
    rows = [(f"floor/{r}_0_crop0", r, p) for r, p in looks.items()]
    rows.append(("wall/den_1_crop0", "den", [1.0, 0.0, 0.0, 0.0]))
    table = pd.DataFrame(rows, columns=["crop_id", "room_id", "substance_probabilities"])
    found = jointed_floors(table, House("h", rooms_in_a_row(den="Den", hall="Corridor"), ()))
    assert sum(found["den"]) < 0.05
    assert sum(found["hall"]) > 0.95 and found["hall"][0] > found["hall"][1]
