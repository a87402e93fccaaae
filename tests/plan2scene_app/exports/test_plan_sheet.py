from places import STOREYS

from plan2scene.plans.formats import read_plan
from plan2scene.plans.geometry import room_polygon
from plan2scene_app.exports.plan_sheet import write_plan


def test_a_sheet_a_level_with_areas_and_dimensions(tmp_path):
    house = read_plan(STOREYS, "two")
    found = []
    for folder in (tmp_path / "a", tmp_path / "b"):
        folder.mkdir()
        write_plan(house, {}, folder)
        found.append({path.name: path.read_bytes() for path in folder.iterdir()})
    assert found[0] == found[1] and set(found[0]) == {"plan.pdf", "plan.svg", "plan_upper.svg"}
    assert found[0]["plan.pdf"].startswith(b"%PDF")
    names = zip(house.levels, ("plan.svg", "plan_upper.svg"), strict=True)
    sheets = {level.id: found[0][name].decode() for level, name in names}
    for room in house.rooms:
        sheet = sheets[room.level]
        assert room.id in sheet and f">{room_polygon(room).area:.2f} m\u00b2<" in sheet
    upper = sheets[house.levels[1].id]
    assert ">8.24<" in upper and ">6.24<" in upper  # 8 x 6 m of rooms and the outer walls
    assert ">90<" in upper and "1:50 on A4" in upper and "48.00 m\u00b2 net" in upper
