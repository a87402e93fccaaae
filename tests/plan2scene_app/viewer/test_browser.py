import math
from dataclasses import replace

import numpy as np
import pytest
from browser import AXE, serious_violations
from index_page import index_page
from PIL import Image
from viewer_page import ViewerPage

from plan2scene.house import IconBox, SurfaceKey
from plan2scene.images import png_bytes
from plan2scene.mesh.glb import write_glb
from plan2scene.mesh.texture_files import TileTexture
from plan2scene_app.viewer.viewer_page import build_viewer

NAME = (
    '"></script><script>document.body.remove()</script><img src=x onerror=document.body.remove()>'
)
CROP = "data:image/gif;base64,R0lGODlhAQABAIAAAAAAAP///yH5BAEAAAAALAAAAAABAAEAAAIBRAA7"
#: In the room's middle at eye level, looks along +x and a little down.
SHOT = {
    "rotation": [[0.0, 0.0, 1.0], [-0.1, -0.995, 0.0], [0.995, -0.1, 0.0]],
    "room_id": "r",
    "width": 640,
    "height": 480,
    "focal_px": 400.0,
    "position": [2.0, 1.5, 1.5],
    "located": 0.75,
    "image": CROP,
}
RESET = """
setTape(false);
stop();
describe(null);
chosen = null;
setMode("orbit");
setLook("day");
frusta.visible = $("shots").checked = false;
fit(parts, 0.92, canvas, 0.42, 0.62);
draw(1);
"""
FACTS = {
    "surfaces": {
        "r/floor": {"photo": NAME, "crop": CROP},
        "r/wall": {"confidence": 0.6, "source": "propagated, like another"},
    },
    "photos": [{"name": "a.jpg", "number": 1}, {"name": NAME, "number": 2, **SHOT}],
}


@pytest.fixture(scope="module")
def browser():
    with ViewerPage() as browser:
        yield browser


@pytest.fixture(scope="module")
def opened(browser):
    """Return what opens the small house, once as long as no other page is opened."""
    return {"page": ""}


@pytest.fixture
def view(browser, opened, small_glb, tmp_path):
    """Show the small house from where it starts; its page asks for nothing, has no complaint."""
    if browser.path != opened["page"]:
        opened["page"] = tmp_path / "viewer.html"
        build_viewer(small_glb, opened["page"], house_id=NAME, facts=FACTS)
        browser.open(opened["page"])
    browser.run(RESET)
    yield browser
    assert browser.requests == [] and browser.complaints == []


def still(browser):
    """Return a picture of the page right of its panel, drawn in the page's own pixels."""
    browser.run(
        "new Promise((done) => requestAnimationFrame(() => {"
        " clearTimeout(resting); draw(1); requestAnimationFrame(done); }))"
    )
    return browser.picture()[:, 290:]


def colours(scene):
    red, green, blue = scene[..., 0], scene[..., 1], scene[..., 2]
    return {
        "red": (red > 120) & (green < 90) & (blue < 90),
        "blue": (blue > 120) & (green < 90) & (red < 90),
        "green": (green > red + 40) & (green > blue + 40),
    }


def info(browser):
    return browser.run('$("info").hidden ? "" : $("info").textContent')


def on_screen(browser, x, y, z):
    place = browser.run(f"onScreen(new THREE.Vector3({x}, {y}, {z}), canvas)")
    return place["x"], place["y"]


def box_of(browser, name):
    return browser.run(
        f"(({{x, y, width, height}}) => [x, y, width, height])($('{name}').getBoundingClientRect())"
    )


def test_textured_pixels_are_in_plain_light_of_their_true_colours(view):
    scene = still(view)
    seen = colours(scene)
    assert all(mask.sum() > 2000 for mask in seen.values())
    # Squares of the floor's checks change many times along a row of the picture.
    floor = seen["red"] | seen["blue"]
    row = max(range(scene.shape[0]), key=lambda y: floor[y].sum())
    assert np.abs(np.diff(seen["red"][row].astype(int))).sum() > 8
    assert len(np.unique(scene.reshape(-1, 3), axis=0)) > 100
    view.run('setLook("plain")')
    scene = still(view)
    for colour in ((220, 20, 20), (20, 20, 220)):  # of the floor's tile
        assert (np.abs(scene - colour).max(axis=2) <= 2).sum() > 500
    assert view.run('$("plain").getAttribute("aria-pressed")') == "true"


def test_ceilings_hide_the_floor_and_rooms_are_listed(view):
    rooms = view.run('[...document.querySelectorAll("#rooms button")].map((b) => b.textContent)')
    assert rooms == ["Bedroom12.0 m²"]
    view.run('$("walk").click(); eye.feet.set(2, 0, 1.5); eye.pitch = 1.3; eye.yaw = 0.3')
    assert view.run('$("ceilings").checked') is True
    above = still(view)[200:500, 100:500]
    assert (above.min(axis=2) > 140).mean() > 0.9  # light, no texture
    assert not any(mask.any() for mask in colours(above).values())
    view.run('$("ceilings").click()')
    assert (still(view)[200:500, 100:500] == view.run("[247, 246, 243]")).all(axis=2).mean() > 0.5


def test_a_click_tells_the_surface_its_photo_and_crop(view):
    view.run('$("plan").click(); draw(1)')
    view.page.mouse.click(*on_screen(view, 2.0, 0.0, 2.0))
    told = info(view)
    assert "Floor" in told and "12.00" in told and "Bedroom" in told
    assert f"seen in photo 2 ({NAME})" in told
    assert view.run('$("info").querySelector("img").src') == CROP
    view.run("Object.assign(eye, {mode: 'walk', yaw: 0, pitch: 0}); enter(rooms[0]); draw(1)")
    view.run("eye.feet.set(2, 0, 1.5); eye.yaw = 0; eye.pitch = 0; draw(1)")
    view.page.mouse.click(*on_screen(view, 2.0, 1.5, 3.0))
    assert "guessed: no photo shows it, may be wrong" in info(view)
    assert view.run('$("info").querySelector("details").open') is False
    assert view.run('$("info").querySelector("img")') is None


def test_the_tape_snaps_to_corners(view):
    view.run('$("plan").click(); $("measure").click(); draw(1)')
    for x, z in ((0.02, 0.02), (3.98, 0.02)):
        view.page.mouse.click(*on_screen(view, x, 0.0, z))
    view.wait('$("label").textContent === "4.00 m"')
    assert "Level4.00 m" in info(view)
    view.run('$("measure").click(); draw(1)')
    assert view.run('$("label").hidden') is True


def test_photos_stand_where_they_were_taken(view):
    view.run('$("plan").click(); draw(1)')
    hidden = still(view)
    view.run('$("shots").click(); draw(1)')
    ink = (np.abs(still(view) - (0x8A, 0x4B, 0x2A)).max(2) < 30) & (hidden != still(view)).any(2)
    assert ink.sum() > 60  # over the floor that is nearer than they are
    view.page.mouse.click(*on_screen(view, *SHOT["position"]))
    assert "Photo 2" in info(view) and "known well" in info(view)
    view.wait("eye.photo !== null")
    view.run("draw(1)")
    assert box_of(view, "photo") == [0, 0, 900, 600]
    assert view.run("$('photo').style.opacity") == "0.5"
    view.run("blend.value = 100; blend.dispatchEvent(new Event('input'))")
    assert view.run("$('photo').style.opacity") == "1"
    x, y, z = view.run("camera.position.toArray()")
    assert (x, y, z) == pytest.approx(SHOT["position"])
    ahead = view.run("camera.getWorldDirection(new THREE.Vector3()).toArray()")
    assert ahead == pytest.approx(SHOT["rotation"][2], abs=5e-3)
    assert view.run("camera.fov") == pytest.approx(2 * math.degrees(math.atan(240 / 400)))
    view.page.keyboard.down("ArrowRight")
    view.wait("$('photo').hidden && eye.photo === null && camera.fov === FIELDS.walk")
    view.page.keyboard.up("ArrowRight")


def test_keys_walk_and_no_wall_is_passed(view):
    view.run('$("walk").click(); eye.feet.set(2, 0, 1); eye.yaw = 0; eye.pitch = 0; draw(1)')
    start = view.run("eye.feet.z")
    for button in ("lit", "day", "shells"):  # which take no key from who walks
        view.page.click(f"#{button}")
    view.page.keyboard.down("w")
    view.wait(f"eye.feet.z > {start} + 0.1")
    view.page.keyboard.up("w")
    inside = view.run(
        """(() => {
          const ends = [];
          for (let k = 0; k < 48; k++) {
            eye.feet.set(2, 0, 1.5);
            walkBy(9 * Math.cos(k * Math.PI / 24), 9 * Math.sin(k * Math.PI / 24));
            ends.push([eye.feet.x, eye.feet.z]);
          }
          return ends;
        })()"""
    )
    x, z = np.array(inside).T
    assert x.min() > 0.2 and x.max() < 3.8
    assert z.min() > 0.2 and z.max() < 2.8
    assert np.ptp(x) > 3.4 and np.ptp(z) > 2.4  # and went there


def test_the_floor_and_the_map_are_clicked_to_go_there(view):
    view.run("history.replaceState(null, '', '#'); location.hash = '#room=r'")
    view.wait("eye.mode === 'walk'")
    assert view.run("placeNow()") == "room=r"
    view.run("location.hash = '#from=9,8,7,2,1,1'")
    view.wait(
        "eye.mode === 'orbit' && placeNow() === 'from=9.00%2C8.00%2C7.00%2C2.00%2C1.00%2C1.00'"
    )
    view.run("location.hash = '#room=r'")
    view.wait("eye.mode === 'walk'")
    # A room is entered where most of it lies ahead: here its longer side.
    assert abs(math.sin(view.run("eye.yaw"))) > 0.85
    view.run("eye.feet.set(0.5, 0, 1.5); eye.yaw = Math.PI / 2; eye.pitch = -0.5; draw(1)")
    view.page.mouse.click(*on_screen(view, 2.5, 0.0, 1.6))
    view.wait("!glide && Math.hypot(eye.feet.x - 2.5, eye.feet.z - 1.6) < 0.05")
    assert info(view) == "" and view.run("marked") == "r"
    x, y, width, height = box_of(view, "map")
    view.page.mouse.click(x + 0.15 * width, y + 0.5 * height)
    view.wait("!glide && eye.feet.x < 1")
    view.page.keyboard.down("Shift")
    view.run("eye.yaw = Math.PI / 2; eye.pitch = -0.5; draw(1)")
    view.page.mouse.click(*on_screen(view, 2.5, 0.0, 1.6))
    view.page.keyboard.up("Shift")
    view.page.select_option("#unit", "feet")
    assert "129 sq ft" in info(view)
    view.page.select_option("#unit", "metres")
    view.page.click("#tour")
    before = view.run("eye.yaw")
    view.wait(f"tour && Math.abs(eye.yaw - {before}) > 0.02")
    view.page.keyboard.press("Escape")
    assert view.run("tour") is None
    with view.page.expect_download() as download:
        view.page.click("#shot")
    assert download.value.path().read_bytes().startswith(b"\x89PNG")


def test_lamps_are_as_bright_as_the_day(view):
    view.run('$("walk").click(); eye.pitch = 0; draw(1)')
    day = still(view).mean()
    view.page.click("#lit")
    assert still(view).mean() > 0.95 * day


def test_on_a_phone_the_panel_folds_and_the_card_is_above_the_pad(view):
    view.page.set_viewport_size({"width": 390, "height": 844})
    view.run('$("walk").click(); $("fold").click(); describe(parts[0])')
    panel, card = (box_of(view, name) for name in ("panel", "info"))
    view.page.get_by_role("button", name="Close").click()
    assert info(view) == "" and view.run("freeWidth(canvas)") == 0  # the house is in the middle
    view.run('$("fold").click()')
    assert box_of(view, "panel")[3] > 300
    view.page.set_viewport_size({"width": 900, "height": 600})
    assert panel[3] < 60 and card[1] + card[3] <= 844 - 14 - 2 * 44 - 6  # the pad's top


def test_touch_walks_by_the_pad(view):
    view.run('$("walk").click(); eye.feet.set(2, 0, 1); eye.yaw = 0; draw(1)')
    start = view.run("eye.feet.z")
    view.run(
        """(() => {
          const ahead = $("pad").children[0];
          ahead.setPointerCapture = () => {};
          ahead.dispatchEvent(new PointerEvent("pointerdown", {pointerId: 9}));
        })()"""
    )
    view.wait(f"eye.feet.z > {start} + 0.1")
    view.run('$("pad").children[0].dispatchEvent(new PointerEvent("pointerup", {pointerId: 9}))')
    assert view.run("keys.size") == 0


def test_nothing_is_drawn_when_nothing_moves(view):
    frames = []
    while len(frames) < 2 or (frames[-1] != frames[-2] and len(frames) < 40):
        view.page.wait_for_timeout(300)
        frames.append(view.run("renderer.info.render.frame"))
    assert frames[-1] == frames[-2]


def test_doors_inside_are_passed_and_stairs_climbed(browser, gap_house, tmp_path):
    gap_house = replace(gap_house, icons=(IconBox("stairs", (5.0, 0.5), (5.9, 3.5)),))
    textures = {
        SurfaceKey(room, "floor"): TileTexture(png_bytes(np.full((4, 4, 3), 90, np.uint8)), 1.0)
        for room in ("a", "b")
    }
    write_glb(gap_house, textures, tmp_path / "house.glb")
    build_viewer(tmp_path / "house.glb", tmp_path / "viewer.html", house_id="gap")
    browser.open(tmp_path / "viewer.html")
    browser.run('paintAs({room: "a", surface: "floor", colour: "#ff0000"})')
    floors = "parts.filter((p) => p.extras.kind === 'floor').map((p) => p.mesh.material)"
    assert browser.run(f"{floors}.map((m) => m.map === null)") == [True, False]
    assert browser.run(f"{floors}[0].color.toArray()") == [1, 0, 0]
    # Who looks at the door sees the next room through it; who turns away draws nothing of it.
    look = """setMode("walk"); eye.feet.set(1.5, 0, 1.4); eye.pitch = 0; eye.yaw = {yaw}; draw(1);
      ["a/floor", "b/floor"].map((name) => parts.find((p) => p.name === name).mesh.visible)"""
    assert browser.run(look.format(yaw="Math.PI / 2")) == [True, True]
    assert browser.run(look.format(yaw="-Math.PI / 2")) == [True, False]
    walk = "eye.feet.set(1.5, 0, {z}); walkBy(3, 0); [eye.feet.x, eye.room]"
    x, room = browser.run(walk.format(z=1.4))
    assert x == pytest.approx(4.5, abs=0.05) and room == "b"
    x, room = browser.run(walk.format(z=3.0))
    assert x < 2.8 and room == "a"
    ends = [
        browser.run(f"eye.feet.set(5.45, 0, {start}); walkBy(0, {way}); [eye.feet.y, eye.feet.z]")
        for start, way in ((0.25, 3.1), (3.75, -3.1))
    ]
    (up, _), (foot, z) = sorted(ends, reverse=True)
    assert up == pytest.approx(2.5, abs=0.2)  # from the foot to the top step
    assert foot == 0.0 and (z < 0.4 or z > 3.6)  # the top's high side stops who stands below


def test_the_index_page_shows_pictures_and_runs_nothing(browser, small_house, tmp_path):
    (tmp_path / "houses" / "small").mkdir(parents=True)
    Image.new("RGB", (400, 300), (255, 0, 0)).save(tmp_path / "houses/small/preview.png")
    page = index_page(tmp_path, small_house, f"method\n{NAME.replace(',', '')}\n", NAME, NAME)
    text = page.read_text(encoding="utf-8")
    blue = "<script>document.body.replaceChildren()</script></body>"
    page.write_text(text.replace("</body>", blue), encoding="utf-8")
    browser.open(page)
    assert (browser.picture() == (255, 0, 0)).all(axis=2).sum() > 2000


HEADSET = """
Object.defineProperty(navigator, "xr", {configurable: true, value: {
  isSessionSupported: async (mode) => mode === "immersive-vr",
  requestSession: async (...asked) => { window.asked = asked; throw new Error("nobody has it"); },
}});
offerHeadset()
"""
#: What looks along -z at the footing's origin stands in the house, and looks along the eye's way.
STANDING = """(() => {
  const { place, turn } = footing(), back = turn.clone().invert();
  const looks = new THREE.Vector3(0, 0, -1).applyQuaternion(back);
  return [...place.negate().applyQuaternion(back).toArray(), looks.dot(forward())];
})()"""


def test_a_headset_is_offered_where_there_is_one_and_stands_where_the_eye_is(view):
    assert view.run('$("headset").hidden')
    view.run(HEADSET)
    view.page.click("#headset")
    assert view.run("asked") == ["immersive-vr", {"requiredFeatures": ["local-floor"]}]
    assert view.run('$("message").textContent') == "No headset: nobody has it"
    view.run('$("message").textContent = ""; eye.feet.set(2, 0.5, 1); eye.yaw = 1; eye.pitch = 0')
    assert np.allclose(view.run(STANDING), [2, 0.5, 1, 1])
    view.run("delete navigator.xr; offerHeadset()")


@pytest.mark.skipif(not AXE.is_file(), reason="no npm package axe-core in GLTF_VALIDATOR_DIR")
def test_no_serious_violation_of_accessibility(view):
    assert serious_violations(view.run) == []
    view.page.click("#walk")
    assert serious_violations(view.run) == []
