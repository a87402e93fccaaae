import pytest

from plan2scene.errors import InputError
from plan2scene.plans.formats import read_plan
from plan2scene.plans.plan_json import house_of_plan
from plan2scene.plans.r2v import house_of_r2v


def test_too_much_is_refused_before_it_is_worked_on(tmp_path):
    ring = [[i / 100, (i % 2) / 100] for i in range(999)] + [[10, 5]]
    rooms = [{"id": f"r{i}", "types": ["Closet"], "polygon": ring} for i in range(6)]
    document = {"format": "plan2scene-plan", "version": 1, "rooms": rooms}
    with pytest.raises(InputError, match="at most 5000 corners of all rooms, found 6000"):
        house_of_plan(document, "h1")
    lines = [f"{i} 0 {i} 9000 wall\n0 {i} 9000 {i} wall" for i in range(0, 9000, 8)]
    (tmp_path / "plan.txt").write_text("\n".join(lines))
    with pytest.raises(InputError, match="at most 2000 walls, found 2250"):
        read_plan(tmp_path / "plan.txt", "h1", 0.01)
    lines = [f"{i} 0 {i} 900 wall\n0 {i} 900 {i} wall" for i in range(0, 900, 20)]
    with pytest.raises(InputError, match="close 1 to 1000 rooms, found 1936 rooms"):
        house_of_r2v("\n".join(lines), "h1", 0.01)


def test_half_a_surrogate_pair_is_no_text(tmp_path):
    (tmp_path / "plan.json").write_text('{"format": "plan2scene-plan", "name": "a\\uD83D"}')
    with pytest.raises(InputError, match=r"Unicode text, found \\ud83d, half"):
        read_plan(tmp_path / "plan.json", "h1")
    (tmp_path / "plan.json").write_text('{"format": "plan2scene-plan", "name": "\\uD83D\\uDE00"}')
    with pytest.raises(InputError, match="key 'version'"):
        read_plan(tmp_path / "plan.json", "h1")
