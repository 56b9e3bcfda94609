"""Draw the pictures of docs/how-to/dance/formations.md into docs/pictures/formations/.

Shapes as in Fig 4.4 of the thesis, the four patterns of Fig 4.5 in one circle, symmetry as in Fig 4.6, letters, and
the ways from one formation into another.
"""

import sys
from pathlib import Path
from typing import Any, Final

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from live.agents.evolutions.paths import straight_paths
from live.agents.evolutions.slot_assignment import assign
from live.agents.formations.formation import formation_of
from live.agents.formations.formation_spec import spec_from_table
from live.app.pictures.formation_picture import draw_formation

ROOT: Final = Path(__file__).resolve().parent.parent

Panel = tuple[str, int, dict[str, Any]]
"""Title, number of dancers, table."""

HEART: Final = "M 0 3 C -5 -1 -2 -4 0 -1.5 C 2 -4 5 -1 0 3 Z"
WAVE: Final = [[x / 10, np.sin(x / 10) * 1.5] for x in range(-45, 46, 3)]
SHAPES: Final[list[Panel]] = [
    ("line", 10, {"shape": "line"}),
    ("arc, facing its middle", 12, {"shape": "arc", "heading": "centre"}),
    ("circle, facing outwards", 16, {"shape": "circle", "heading": "outwards"}),
    ("rectangle", 20, {"shape": "rectangle", "size": [7, 4]}),
    ("star of 5 points", 20, {"shape": "star"}),
    ("spiral, along the line", 20, {"shape": "spiral", "turns": 2, "heading": "along"}),
    ("drawn line", 14, {"shape": "polyline", "points": WAVE}),
    (
        "SVG path, soloist in front",
        21,
        {"shape": "path", "path": HEART, "soloists": 1, "size": [6, 4], "centre": [0, -0.7]},
    ),
    (
        "two circles: a flower",
        25,
        {"shape": "circle", "pattern": "concentric", "soloists": 1, "soloist_place": "centre"},
    ),
]
PATTERNS: Final[list[Panel]] = [
    ("(a) uniform grid", 50, {"shape": "circle", "pattern": "grid", "size": [7, 7]}),
    ("(b) diagonal grid", 50, {"shape": "circle", "pattern": "diagonal", "size": [7, 7]}),
    ("(c) concentric silhouettes", 50, {"shape": "circle", "pattern": "concentric", "size": [7, 7]}),
    ("(d) Poisson disk", 50, {"shape": "circle", "pattern": "poisson", "size": [7, 7]}),
    ("even", 50, {"shape": "circle", "dancers": "inside", "size": [7, 7]}),
    (
        "weighted: a focus",
        50,
        {"shape": "circle", "dancers": "inside", "size": [7, 7], "focus": [0, 3], "focus_strength": 6},
    ),
]
ZIGZAG: Final = [[[-5, -3], [-3.5, 0], [-2, -3], [-1, 1.5]], [[-4.5, 2.5], [-3, 2.5], [-2, 1.5]]]
MIRRORED: Final[list[Panel]] = [
    ("drawn on the left", 13, {"shape": "polyline", "points": ZIGZAG}),
    (
        "reflected over a line from back to front",
        26,
        {"shape": "polyline", "points": ZIGZAG, "mirror": [[0, -4], [0, 4]]},
    ),
    (
        "about a slanted line",
        24,
        {"shape": "polyline", "points": ZIGZAG, "mirror": [[-1.2, 4], [1.2, -4]], "heading": "along"},
    ),
    (
        "scattered, and symmetrical",
        40,
        {"shape": "rectangle", "size": [9, 6], "pattern": "poisson", "mirror": "left-right"},
    ),
]
SECTIONS: Final[list[Panel]] = [
    (
        "sections along an arc",
        19,
        {"shape": "arc", "sections": [6, 6, 6], "soloists": 1, "heading": "centre", "centre": [0, -1]},
    ),
    ("sections in a grid", 40, {"shape": "rectangle", "pattern": "grid", "size": [9, 6], "sections": [10, 20, 10]}),
    ("weights along a line", 15, {"shape": "line", "size": [10, 1], "weights": [1, 5, 1]}),
]


def main() -> None:
    """Write all pictures."""
    folder = ROOT / "docs" / "pictures" / "formations"
    folder.mkdir(parents=True, exist_ok=True)
    _write(folder / "shapes.svg", SHAPES, 3, (10.0, 7.0))
    _write(folder / "patterns.svg", PATTERNS, 3, (8.0, 8.0))
    _write(folder / "symmetry.svg", MIRRORED, 2, (12.0, 8.0))
    _write(folder / "sections.svg", SECTIONS, 3, (11.0, 7.0))
    letters = ["ABCDEFGHI", "JKLMNOPQR", "STUVWXYZ", "0123456789"]
    rows: list[Panel] = [(text, 100, {"shape": "text", "text": text, "size": [30, 4]}) for text in letters]
    _write(folder / "letters.svg", rows, 1, (32.0, 6.0))
    _write_ways(folder / "ways.svg")


def _made(panel: Panel) -> Any:
    title, count, table = panel
    return formation_of(spec_from_table({**table, "name": title[:64]}), count, 1)


def _write(to: Path, panels: list[Panel], columns: int, stage: tuple[float, float]) -> None:
    drawn = [draw_formation(_made(panel), stage, title=f"{panel[0]} ({panel[1]})") for panel in panels]
    _sheet(to, drawn, columns)


def _write_ways(to: Path) -> None:
    first = formation_of(spec_from_table({"shape": "rectangle", "pattern": "grid", "size": [8, 4]}), 24, 1)
    second = formation_of(spec_from_table({"shape": "star", "size": [9, 7], "name": "star"}), 24, 1)
    slot = assign(first.slots, second.slots)
    ways = list(straight_paths(first.slots, second.slots[slot]).astype(np.float64))
    _sheet(to, [draw_formation(second, (12.0, 8.0), paths=ways, title="from a grid into a star (24)")], 1)


def _sheet(to: Path, drawn: list[str], columns: int) -> None:
    """Pictures of one size side by side."""
    head = drawn[0].partition("\n")[0]
    width, height = (int(head.partition(f'{side}="')[2].partition('"')[0]) for side in ("width", "height"))
    rows = -(-len(drawn) // columns)
    scale = min(1.0, 1200 / (columns * width))
    box = f'viewBox="0 0 {columns * width} {rows * height}"'
    size = f'width="{columns * width * scale:.0f}" height="{rows * height * scale:.0f}"'
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" {size} {box}>']
    for n, each in enumerate(drawn):
        parts.append(f'<g transform="translate({n % columns * width},{n // columns * height})">\n{each}</g>')
    text = "\n".join([*parts, "</svg>", ""])
    to.write_text(text, encoding="utf-8")
    print(f"{to.relative_to(ROOT)}: {len(text) // 1000} kB")


if __name__ == "__main__":
    main()
