"""Write every figure of the built book as PNG and SVG: `build/figures/<the figure's label>.png` and `.svg`.

The figures are those of the executed notebooks that the build leaves beside the pages, not drawn a second time.
"""

import base64
import json
import shutil
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
NOTEBOOKS = ROOT / "book" / "_build" / "html" / "_sources"
FIGURES = ROOT / "build" / "figures"


def figures(notebook: Path) -> dict[str, dict]:
    """The images of one executed notebook by the label that its cell gives them: ``{label: {mime type: content}}``."""
    found = {}
    for cell in json.loads(notebook.read_text(encoding="utf-8"))["cells"]:
        images = [o["data"] for o in cell.get("outputs", []) if "image/png" in o.get("data", {})]
        label = cell["metadata"].get("mystnb", {}).get("figure", {}).get("name")
        if images and not label:
            raise ValueError(f"{notebook.stem}: a figure has no label (cell metadata `mystnb: figure: name: fig-...`)")
        if label and len(images) != 1:
            raise ValueError(f"{notebook.stem}: the cell of `{label}` must draw one figure, it draws {len(images)}")
        if label:
            found[label] = images[0]
    return found


def main() -> int:
    notebooks = sorted(NOTEBOOKS.rglob("*.ipynb"))
    if not notebooks:
        print(f"no executed notebooks in {NOTEBOOKS.relative_to(ROOT)}: build the book first", file=sys.stderr)
        return 1
    shutil.rmtree(FIGURES, ignore_errors=True)
    FIGURES.mkdir(parents=True)
    count = 0
    for notebook in notebooks:
        for label, image in figures(notebook).items():
            (FIGURES / f"{label}.png").write_bytes(base64.b64decode(image["image/png"]))
            (FIGURES / f"{label}.svg").write_text("".join(image["image/svg+xml"]), encoding="utf-8")
            count += 1
    print(f"{count} figures from {len(notebooks)} pages: {FIGURES.relative_to(ROOT)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
