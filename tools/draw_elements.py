"""Draw the pictures of docs/how-to/dance/elements.md: `python tools/draw_elements.py [FOLDER]`.

The stage from above, the audience below; dots are dancers, thin lines their ways.
"""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Circle, Rectangle

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from bench.spreading import Crowd, places
from live.agents.elements.element import Element, rectangle
from live.base.element_kinds import ATTRACTOR, CROSSING, DRAWN, FLOW, FOLLOW, PATH, RADIAL, REPULSOR, SPREADER, VORTEX

SIZE = (12.0, 8.0)
ON: Any = {"start_beat": -9.0}


def scattered(
    count: int, seed: int, low: tuple[float, float] = (-5.5, -3.5), high: tuple[float, float] = (5.5, 3.5)
) -> Any:
    """`count` places at random, 0.7 m apart."""
    return places(np.random.default_rng(seed), count, np.array(low), np.array(high), 0.7)


def danced(start: Any, elements: list[Element], seconds: float, groups: list[int] | None = None) -> Any:
    """Positions every quarter of a second, shape (T, A, 2)."""
    crowd = Crowd(np.array(start, float), elements, size=SIZE, seed=3)
    if groups is not None:
        crowd._groups[:] = groups
    for _ in range(int(seconds * 64) + 1):
        crowd.tick()
    return np.array(crowd.kept)


def floor(axes: Any, title: str) -> None:
    """An empty stage, seen from above, the audience below."""
    axes.set_xlim(-6.2, 6.2)
    axes.set_ylim(4.2, -4.2)
    axes.set_aspect("equal")
    axes.add_patch(Rectangle((-6, -4), 12, 8, fill=False, color="0.6"))
    axes.axis("off")
    axes.set_title(title, fontsize=9)


def ways(axes: Any, kept: Any, colours: Any = None) -> None:
    """The ways of all dancers, thin, and where they end."""
    for agent in range(kept.shape[1]):
        colour = "tab:blue" if colours is None else colours[agent]
        axes.plot(kept[:, agent, 0], kept[:, agent, 1], color=colour, lw=0.6, alpha=0.6)
        axes.add_patch(Circle(kept[-1, agent], 0.25, color=colour))


def mark(axes: Any, points: Any, *, closed: bool = False, radius: float = 0.0, colour: str = "tab:red") -> None:
    """An element's shape."""
    line = np.array([*points, points[0]] if closed else points)
    axes.plot(line[:, 0], line[:, 1], "x-" if len(points) == 1 else "-", color=colour, lw=1.5)
    if radius > 0.0 and len(points) == 1:
        axes.add_patch(Circle(points[0], radius, fill=False, color=colour))


def sources(axes: Any) -> None:
    """Attractors, repulsors, voices."""
    start = scattered(16, 1)
    shapes = [
        ("attract: a point", Element(ATTRACTOR, ((1.5, 0.5),), **ON)),
        ("attract: a line (T106)", Element(ATTRACTOR, ((-4.0, 2.0), (4.0, -2.0)), **ON)),
        ("attract: a region", Element(ATTRACTOR, rectangle(2.0, 0.0, 4.5, 4.0), closed=True, **ON)),
        ("repel: a point", Element(REPULSOR, ((0.0, 0.0),), **ON)),
    ]
    for place, (title, element) in enumerate(shapes):
        floor(axes[place], title)
        ways(axes[place], danced(start, [element], 7.0))
        mark(axes[place], element.points, closed=element.closed)
    for place, fair in ((4, False), (5, True)):
        chance = np.random.default_rng(5)
        phones = [tuple(p) for p in chance.normal([3.5, 1.5], 0.5, (40, 2))] + [(-4.5, -2.5)]
        floor(axes[place], "41 phones: fair" if fair else "41 phones: each the nearest")
        ways(axes[place], danced(start, [Element(ATTRACTOR, (p,), fair=fair, **ON) for p in phones], 8.0))
        axes[place].plot(*np.array(phones).T, "x", color="tab:red", ms=4)


def groups(axes: Any) -> None:
    """Spreading and crossing."""
    clump = places(np.random.default_rng(2), 48, np.array([-5.7, -3.7]), np.array([-2.0, 3.7]), 0.52)
    kept = danced(clump, [Element(SPREADER, separation=0.7, **ON)], 14.0)
    for place, second in enumerate((0, 5, 14)):
        floor(axes[place], f"spread: after {second} s")
        for x, z in kept[second * 4]:
            axes[place].add_patch(Circle((x, z), 0.25, color="tab:blue"))
    for place, line in (
        (3, ((0.0, -1.0), (0.0, 1.0))),
        (4, ((0.5 - np.sin(0.6), -np.cos(0.6)), (0.5 + np.sin(0.6), np.cos(0.6)))),
        (5, ((-1.0, 1.0), (1.0, 1.0))),
    ):
        start = scattered(24, 4)
        kept = danced(start, [Element(CROSSING, line, **ON)], 14.0)
        (ax, az), (bx, bz) = line
        side = (start[:, 0] - ax) * (bz - az) - (start[:, 1] - az) * (bx - ax)
        floor(axes[place], "cross: colours are the sides they came from")
        ways(axes[place], kept, ["tab:orange" if s > 0 else "tab:blue" for s in side])
        far = np.array(line) + np.outer([-20, 20], [bx - ax, bz - az])
        axes[place].plot(far[:, 0], far[:, 1], color="tab:red", lw=1.5)


def flows(axes: Any) -> None:
    """Flow fields, paths, followers."""
    t = np.linspace(0.0, 2 * np.pi, 60)
    stroke = tuple(zip(np.linspace(-5, 5, 60), 1.8 * np.sin(t), strict=True))
    eight = tuple(map(tuple, np.stack([4 * np.sin(t[:-1]), 2 * np.sin(2 * t[:-1])], 1)))
    start = scattered(14, 6)
    shapes = [
        ("flow: vortex", Element(FLOW, flow_kind=VORTEX, strength=0.7, **ON), 5.0),
        ("flow: radial, inwards (strength -1)", Element(FLOW, flow_kind=RADIAL, strength=-1.0, **ON), 6.0),
        ("flow: drawn", Element(FLOW, stroke, flow_kind=DRAWN, **ON), 5.0),
        ("path: a closed figure of eight", Element(PATH, eight, closed=True, **ON), 12.0),
    ]
    for place, (title, element, seconds) in enumerate(shapes):
        floor(axes[place], title)
        ways(axes[place], danced(start[: 5 if element.kind == PATH else 14], [element], seconds))
        mark(axes[place], element.points, closed=element.closed)
    t = t[:-1]
    around = tuple(map(tuple, np.stack([4.5 * np.cos(t), 2.6 * np.sin(t)], 1)))
    lead = Element(PATH, around, closed=True, groups=1, strength=0.6, **ON)
    for place, wedge in ((4, False), (5, True)):
        follow = Element(FOLLOW, target=0, groups=2, wedge=wedge, separation=0.5, **ON)
        floor(axes[place], "follow: in a wedge" if wedge else "follow: in a line")
        line = [(4.5, 0.0), (-5.5, -1.0), (-4.5, -3.2), (-5.6, 0.5), (-3.5, -3.4), (-5.4, 2.0), (-2.5, -3.5)]
        kept = danced(line, [lead, follow], 19.0, [1] + [2] * 6)
        ways(axes[place], kept[-14:], ["tab:red"] + ["tab:blue"] * 6)


def main() -> None:
    """All pictures."""
    folder = (
        Path(sys.argv[1])
        if len(sys.argv) > 1
        else Path(__file__).resolve().parents[1] / "docs" / "pictures" / "elements"
    )
    folder.mkdir(parents=True, exist_ok=True)
    pictures: dict[str, Callable[[Any], None]] = {"sources": sources, "groups": groups, "flows": flows}
    for name, draw in pictures.items():
        figure, axes = plt.subplots(2, 3, figsize=(9.0, 4.6), dpi=80)
        draw(axes.ravel())
        figure.tight_layout(pad=0.4)
        figure.savefig(folder / f"{name}.png")
        plt.close(figure)


if __name__ == "__main__":
    main()
