import numpy as np
import pytest
from flat_picture import flat_picture
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure
from PIL import Image

from plan2scene.errors import InputError
from plan2scene_app.tracing import lettering, pages
from plan2scene_app.tracing.lettering import TextLine
from plan2scene_app.tracing.trace import doubts, place_in_picture, trace_picture

FLAT = flat_picture()
MIRRORED = np.ascontiguousarray(FLAT[:, ::-1])
TABLE = np.full_like(FLAT, 255)
TABLE[100:200:20, 100:400] = 0
NOISE = np.random.default_rng(0).integers(0, 255, FLAT.shape, np.uint8)


@pytest.fixture
def pdf(tmp_path, monkeypatch):
    """Return a maker of PDFs; of its pages, flats and mirrored flats have different words."""

    def lines(image):
        height, width = image.shape[:2]
        top = image[: height // 6]
        window_right = top[:, width // 2 :].mean() > top.mean()
        words = ("Living 20 m2", "Kitchen") if window_right else ("Bedroom 9 m2", "Bath")
        return [TextLine(text, (0.3 * width, 0.5 * height), (80.0, 12.0), 0.99) for text in words]

    monkeypatch.setattr(pages, "lines_of", lambda image, told: lines(image))
    monkeypatch.setattr(lettering, "reader_installed", lambda: False)

    def made(*pictures):
        first, *more = (Image.fromarray(picture) for picture in pictures)
        first.save(tmp_path / "plan.pdf", save_all=True, append_images=more, resolution=72)
        return tmp_path / "plan.pdf"

    return made


def test_pages_with_homes_are_storeys_and_each_plan_is_read_once(pdf):
    plan = trace_picture(pdf(NOISE, FLAT, TABLE, MIRRORED, FLAT))
    assert plan.pages == (2, 4) and plan.page_count == 5
    assert len(plan.storeys) == 2 and len(plan.rooms) == 4
    assert place_in_picture(plan, "plan.pdf")["pages"] == [2, 4]
    assert "of 5 pages, pages 2, 4 are read; give other pages as pictures" in doubts(plan)


def test_a_single_page_with_a_home_is_read_as_a_picture_of_it(pdf):
    plan = trace_picture(pdf(TABLE, FLAT))
    assert plan.pages == (2,) and plan.storeys == () and len(plan.rooms) == 2
    alone = trace_picture(pdf(FLAT))
    assert [room.polygon for room in plan.rooms] == [room.polygon for room in alone.rooms]
    assert not any("pages" in line for line in doubts(alone))


def test_a_pdf_without_a_home_is_refused_in_one_line(pdf):
    with pytest.raises(InputError, match=r"plan\.pdf: expected a picture of a floorplan, found"):
        trace_picture(pdf(TABLE, NOISE))
    cut = pdf(FLAT)
    cut.write_bytes(cut.read_bytes()[:99])
    for path, found in ((cut, "a PDF that can be read"), (cut.with_name("no.png"), "no such file")):
        with pytest.raises(InputError, match=rf"{path.name}: expected .*{found}"):
            trace_picture(path)


def test_letters_of_a_pdf_are_read_in_any_script_without_a_reader(tmp_path, monkeypatch):
    monkeypatch.setattr(lettering, "reader_installed", lambda: False)
    figure = Figure(figsize=(10, 7))
    figure.figimage(FLAT, resize=True)
    for x, text in ((0.3, "Κουζίνα\n20,5 m²"), (0.7, "Спальня")):
        figure.text(x, 0.5, text, ha="center", fontsize=9)
    figure.savefig(tmp_path / "plan.pdf")
    plan = trace_picture(tmp_path / "plan.pdf")
    assert [(room.name, room.types) for room in plan.rooms] == [
        ("Κουζίνα", ("Kitchen",)),
        ("Спальня", ("Bedroom",)),
    ]
    assert not any("no text is read" in line for line in doubts(plan))
    assert plan.rooms[0].polygon.area * plan.metres**2 == pytest.approx(20.5, rel=0.05)
    with PdfPages(tmp_path / "two.pdf") as two:
        two.savefig(figure), two.savefig(figure)
    seen = []  # letters are no walls to the network that looks for plans on the pages
    monkeypatch.setattr(pages, "first_looks", lambda page, _: seen.append(page) or ([], None, 0))
    pages.read_plan_pages(tmp_path / "two.pdf", None)
    height, width = seen[0].shape[:2]
    assert seen[0][height // 3 : 2 * height // 3, width // 4 : 2 * width // 5].min() > 200
