"""SVG drawing of a crowd's paths from above: audience below, hue by direction to the goal."""

import colorsys
import math
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from live.agents.scenarios.scenario import Float64, Scenario

LONG_SIDE: Final = 1000.0
"""Longer side of the picture [pixels]."""
TICKS_PER_POINT: Final = 8
"""Ticks between two points of a path: an eighth of a second."""


def paths_svg(scenario: "Scenario", time: "Float64", position: "Float64") -> str:
    """Return the SVG of a run: rings are starts, crosses are goals, dots are final positions."""
    left, top, width, height = _frame(scenario, position)
    line = 0.02 * max(1.0, max(width, height) / 20.0)
    scale = LONG_SIDE / max(width, height)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width * scale:.0f}" height="{height * scale:.0f}" '
        f'viewBox="{left:.3f} {top:.3f} {width:.3f} {height:.3f}" fill="none" stroke-width="{line:.3f}">',
        f'<rect x="{left:.3f}" y="{top:.3f}" width="{width:.3f}" height="{height:.3f}" fill="white"/>',
    ]
    if scenario.stage is not None:
        x0, z0, x1, z1 = scenario.stage
        parts.append(f'<rect x="{x0}" y="{z0}" width="{x1 - x0}" height="{z1 - z0}" stroke="#888"/>')
    parts += [
        f'<line x1="{x1}" y1="{z1}" x2="{x2}" y2="{z2}" stroke="black" stroke-width="{3 * line:.3f}"/>'
        for x1, z1, x2, z2 in scenario.walls.tolist()
    ]
    for agent, (goal_x, goal_z) in enumerate(scenario.last_goal.tolist()):
        x, z = scenario.start[agent]
        colour = _colour(math.atan2(goal_x - x, goal_z - z))
        way = position[::TICKS_PER_POINT, agent]
        points = " ".join(f"{x:.2f},{z:.2f}" for x, z in way.tolist())
        end_x, end_z = position[-1, agent].tolist()
        parts += [
            f'<polyline points="{points}" stroke="{colour}" stroke-opacity="0.6"/>',
            f'<circle cx="{x:.3f}" cy="{z:.3f}" r="{scenario.radius}" stroke="{colour}"/>',
            f'<path d="M{goal_x - 0.1:.3f} {goal_z:.3f}h0.2m-0.1 -0.1v0.2" stroke="#222"/>',
            f'<circle cx="{end_x:.3f}" cy="{end_z:.3f}" r="{scenario.radius}" fill="{colour}" fill-opacity="0.5"/>',
        ]
    seconds = f"{scenario.agent_count} agents, {time[-1]:g} s"
    text = 0.025 * width
    parts.append(
        f'<text x="{left + text:.3f}" y="{top + 1.5 * text:.3f}" font-size="{text:.3f}" '
        f'font-family="Helvetica, Arial, sans-serif" fill="#222">{seconds}</text>'
    )
    return "\n".join([*parts, "</svg>", ""])


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
