"""SVG drawing of a crowd's paths from above: audience below, hue by direction to the goal."""

import colorsys
import math
from typing import TYPE_CHECKING, Final

from live.app.pictures import svg
from live.base.arrays import Float64

if TYPE_CHECKING:
    from live.agents.scenarios.scenario import Scenario

LONG_SIDE: Final = 1000.0
"""Longer side of the picture [pixels]."""
TICKS_PER_POINT: Final = 8
"""Ticks between two points of a path: an eighth of a second."""


def paths_svg(scenario: "Scenario", time: "Float64", position: "Float64") -> str:
    """Return the SVG of a run: rings are starts, crosses are goals, dots are final positions."""
    left, top, width, height = _frame(scenario, position)
    line = 0.02 * max(1.0, max(width, height) / 20.0)
    scale = LONG_SIDE / max(width, height)
    parts = []
    if scenario.stage is not None:
        x0, z0, x1, z1 = scenario.stage
        parts.append(svg.element("rect", x=x0, y=z0, width=x1 - x0, height=z1 - z0, stroke="#888"))
    parts += [
        svg.element("line", x1=x1, y1=z1, x2=x2, y2=z2, stroke="black", stroke_width=3 * line)
        for x1, z1, x2, z2 in scenario.walls.tolist()
    ]
    for agent, (goal_x, goal_z) in enumerate(scenario.last_goal.tolist()):
        x, z = scenario.start[agent]
        colour = _colour(math.atan2(goal_x - x, goal_z - z))
        way = svg.point_list(position[::TICKS_PER_POINT, agent].tolist())
        parts += [
            svg.element("polyline", points=way, stroke=colour, stroke_opacity=0.6),
            svg.circle((x, z), scenario.radius, stroke=colour),
            svg.element("path", d=f"M{goal_x - 0.1:.3f} {goal_z:.3f}h0.2m-0.1 -0.1v0.2", stroke="#222"),
            svg.circle(position[-1, agent].tolist(), scenario.radius, fill=colour, fill_opacity=0.5),
        ]
    words = f"{scenario.agent_count} agents, {time[-1]:g} s"
    text = 0.025 * width
    parts.append(svg.text(left + text, top + 1.5 * text, words, font_size=text, fill="#222"))
    size, box = (width * scale, height * scale), (left, top, width, height)
    return svg.drawing(*size, parts, box=box, fill="none", stroke_width=line)


def _frame(scenario: "Scenario", position: "Float64") -> tuple[float, float, float, float]:
    """Return left, top, width and height [m] around everything, with a margin."""
    corners = [*scenario.start, *scenario.last_goal, *scenario.walls[:, :2], *scenario.walls[:, 2:]]
    if scenario.stage is not None:
        corners += [scenario.stage[:2], scenario.stage[2:]]
    if position.size:
        corners += [position.min(axis=(0, 1)), position.max(axis=(0, 1))]
    xs, zs = [float(x) for x, _ in corners] or [0.0], [float(z) for _, z in corners] or [0.0]
    margin = 1.0 + scenario.radius
    left, top = min(xs) - margin, min(zs) - margin
    return left, top, max(xs) + margin - left, max(zs) + margin - top


def _colour(angle: float) -> str:
    red, green, blue = colorsys.hls_to_rgb(angle / (2.0 * math.pi) % 1.0, 0.45, 0.7)
    return f"#{round(255 * red):02x}{round(255 * green):02x}{round(255 * blue):02x}"
