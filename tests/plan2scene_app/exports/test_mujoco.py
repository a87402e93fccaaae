import xml.etree.ElementTree as ET

import pytest

from plan2scene_app.exports.simulator import mjcf_text
from plan2scene_app.exports.solids import house_solids

mujoco = pytest.importorskip("mujoco")


def model_with(house, bodies):
    root = ET.fromstring(mjcf_text(house, house_solids(house)))
    world = root.find("worldbody")
    for body in bodies:
        world.append(ET.fromstring(body))
    keys = root.find("keyframe")
    if keys is not None:  # its qpos has no place for what was added
        root.remove(keys)
    model = mujoco.MjModel.from_xml_string(ET.tostring(root, encoding="unicode"))
    return model, mujoco.MjData(model)


def pusher(x, z):
    return (
        f'<body name="robot" pos="{x} {-z} 0.55"><joint name="rx" type="slide" axis="1 0 0"/>'
        '<joint name="ry" type="slide" axis="0 1 0"/>'
        '<geom type="capsule" size="0.2 0.3" mass="20" friction="0.2"/></body>'
    )


def pushed(house, start, force, *, doors=0.0, seconds=6.0):
    """Return the plan point (x, z) at which a capsule ends that is pushed along (x, z)."""
    model, data = model_with(house, [pusher(*start)])
    for number in range(model.njnt):
        if model.joint(number).name.endswith("/hinge"):
            low, high = model.jnt_range[number]
            data.qpos[model.jnt_qposadr[number]] = doors * (low if abs(low) > high else high)
    robot = model.body("robot").id
    mujoco.mj_forward(model, data)
    for _ in range(int(seconds / model.opt.timestep)):
        data.xfrc_applied[robot, :2] = force[0], -force[1]
        data.xfrc_applied[robot, :2] -= 40.0 * data.cvel[robot, 3:5]
        mujoco.mj_step(model, data)
    x, y, _ = data.xpos[robot]
    return x, -y


def test_an_open_door_lets_pass_and_a_leaf_gives_way_to_the_side_that_it_opens_to(gap_house):
    x, _ = pushed(gap_house, (1.5, 1.4), (100.0, 0.0), doors=0.9)
    assert x > 3.5
    from_behind, _ = pushed(gap_house, (4.5, 1.4), (-100.0, 0.0))
    assert from_behind < 2.8  # it pushes the leaf open into room a
    against, _ = pushed(gap_house, (1.5, 1.4), (100.0, 0.0))
    assert against < 3.0  # the leaf does not open to the other side
