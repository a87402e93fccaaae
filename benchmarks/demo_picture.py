"""Put the previews of a results folder on one sheet, for the README.

python benchmarks/demo_picture.py results/demo docs/pictures/demo.jpg
"""

import sys
from pathlib import Path

from PIL import Image

WIDTH = 640  # pixels of one preview on the sheet


def main(results: Path, output: Path) -> None:
    files = sorted(results.glob("houses/*/preview.png"))
    images = [Image.open(file).convert("RGB") for file in files]
    height = round(WIDTH * images[0].height / images[0].width)
    sheet = Image.new("RGB", (2 * WIDTH, height * ((len(images) + 1) // 2)), "white")
    for i, image in enumerate(images):
        sheet.paste(
            image.resize((WIDTH, height), Image.Resampling.LANCZOS),
            (i % 2 * WIDTH, i // 2 * height),
        )
    output.parent.mkdir(parents=True, exist_ok=True)
    sheet.save(output, quality=85)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
