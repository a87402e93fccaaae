"""Drawings that tell no scale: a home of 8 x 4 in units or pixels, two rooms."""

import io


def dxf(scale=1000, layer="W1"):
    import ezdxf

    doc = ezdxf.new("R2010")
    doc.header["$INSUNITS"] = 0
    space = doc.modelspace()
    lines = [((0, 0), (8, 0)), ((8, 0), (8, 4)), ((8, 4), (0, 4)), ((0, 4), (0, 0))]
    for start, end in [*lines, ((5, 0), (5, 4))]:
        ends = [(x * scale, y * scale) for x, y in (start, end)]
        space.add_line(*ends, dxfattribs={"layer": layer})
    space.add_line((0, 0), (90 * scale, 0), dxfattribs={"layer": "F.frame (1)"})
    text = io.StringIO()
    doc.write(text)
    return text.getvalue().encode()


def svg():
    groups = "".join(
        f'<g class="Space {kind}"><polygon points="{a},0 {b},0 {b},400 {a},400"/></g>'
        for kind, a, b in (("Bedroom", 0, 500), ("Kitchen", 500, 800))
    )
    head = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 800 400">'
    return f'{head}<g class="Floor">{groups}</g></svg>'.encode()
