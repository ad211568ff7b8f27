"""Makes the manual's page about the source paper's figures anew, with its pictures.

    packaging/paper

Needs no display.  A picture has 256 colours of its own choice.
"""

from io import BytesIO
from pathlib import Path

from paper_page import LANGUAGES, page, picture_name
from PIL import Image

from georibbon.export.paper.pictures import picture_of
from georibbon.paper_figures import NUMBERS, figure

ROOT = Path(__file__).resolve().parents[2]
MANUAL = ROOT / "resources" / "help"
COLOURS = 256
WIDTH, LARGEST, LARGEST_TOGETHER = 960, 150_000, 1_500_000  # pixels; bytes


def main() -> None:
    """Compute, draw and write."""
    figures, together = [], 0
    for number in NUMBERS:
        figures.append(figure(number))
        together += _write(picture_of(figures[-1], WIDTH), MANUAL / "pictures", number)
    if together > LARGEST_TOGETHER:
        raise SystemExit(f"the pictures have {together / 1e6:.2f} MB together, too much")
    for language in LANGUAGES:
        target = MANUAL / language / "paper.md"
        target.write_text(page(figures, language), encoding="utf-8")
        print(target.relative_to(ROOT))


def _write(data: bytes, folder: Path, number: int) -> int:
    """A picture with few colours, in its place; returns its size, bytes."""
    target = folder / f"{picture_name(number)}.png"
    picture = Image.open(BytesIO(data)).convert("RGB")
    few = picture.quantize(COLOURS, Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    few.save(target, optimize=True)
    size = target.stat().st_size
    print(f"{target.relative_to(ROOT)}: {size / 1000:.0f} kB", flush=True)
    if size > LARGEST:
        raise SystemExit(f"{target} is larger than {LARGEST / 1000:.0f} kB")
    return size


if __name__ == "__main__":
    main()
