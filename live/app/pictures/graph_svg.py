"""SVG drawing of a library's state machine (Fig 5.11).

Steps are circles on a ring, sized by their number of clips. An arrow leads from a step to each step that can follow
it; its width and number show the number of joins. A step that can be repeated has a loop. Dead steps are grey.
"""

import cmath
import colorsys
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from live.app.pictures import svg

LONGEST_NAME: Final = 24
_HEAD: Final = 11.0
"""Length of an arrow head."""
_NUMBERED: Final = 90
"""Maximum number of arrows that get numbers."""


@dataclass(frozen=True, slots=True)
class State:
    """State of the machine: a step."""

    name: str
    words: str
    clips: int
    alive: bool = True


@dataclass(frozen=True, slots=True)
class Arrow:
    """Arrow from a state to another or itself, by index."""

    source: int
    target: int
    joins: int


def state_machine(states: Sequence[State], arrows: Sequence[Arrow], title: str) -> str:
    """Return the drawing as SVG text."""
    layout = _Layout(states)
    numbered = len(arrows) <= _NUMBERED
    parts = [svg.text(20, 30, title, font_size=17, fill="#222")]
    for one in arrows:
        parts += layout.arrow(one, 0.75 if numbered else 0.4)
    for number in range(len(states)):
        parts += layout.circle(number)
    if numbered:
        for one in arrows:
            parts += layout.number(one)
    size = 2 * layout.half, 2 * layout.half + 30
    return svg.drawing(*size, parts, box=(0.0, 0.0, *size))


class _Layout:
    """Layout of circles and arrows; points are complex numbers x + iy."""

    def __init__(self, states: Sequence[State]) -> None:
        self._states = states
        count = len(states)
        most = max((state.clips for state in states), default=1)
        self._radius = [22.0 + 20.0 * math.sqrt(state.clips / max(most, 1)) for state in states]
        ring = 0.0 if count == 1 else max(190.0, 58.0 * count / math.pi + 40.0)
        self.half = ring + 250.0
        middle = complex(self.half, self.half + 30.0)
        self._out = [cmath.exp(1j * (-0.5 * math.pi + 2.0 * math.pi * n / count)) for n in range(count)]
        self._at = [middle + ring * out for out in self._out]

    def colour(self, number: int) -> str:
        """Return the colour of a state and of the arrows that leave it."""
        if not self._states[number].alive:
            return "#9a9a9a"
        rgb = colorsys.hls_to_rgb(number / len(self._states), 0.38, 0.62)
        return "#" + "".join(f"{round(255 * part):02x}" for part in rgb)

    def circle(self, number: int) -> list[str]:
        """Draw a state with its name outside the ring."""
        state, at, radius, out = self._states[number], self._at[number], self._radius[number], self._out[number]
        colour = self.colour(number)
        text = at + out * (radius + 56.0) + (complex(0.0, -18.0) if out.imag < -0.3 else complex(0.0, 6.0))
        anchor = "middle" if abs(out.real) < 0.3 else "start" if out.real > 0 else "end"
        name = state.name if len(state.name) <= LONGEST_NAME else state.name[: LONGEST_NAME - 1] + "…"
        dash = None if state.alive else "5 4"
        beside = {"text_anchor": anchor}
        return [
            svg.circle((at.real, at.imag), radius, fill="white", stroke=colour, stroke_width=3, stroke_dasharray=dash),
            svg.text(at.real, at.imag + 5, str(state.clips), font_size=15, text_anchor="middle", fill=colour),
            svg.text(text.real, text.imag, name, font_size=15, font_weight="bold", **beside, fill="#222"),
            svg.text(text.real, text.imag + 16, state.words, font_size=12, **beside, fill="#666"),
        ]

    def _curve(self, arrow: Arrow) -> tuple[complex, complex, complex, complex]:
        """Start, two control points and tip of an arrow."""
        a, b = self._at[arrow.source], self._at[arrow.target]
        if arrow.source == arrow.target:  # a loop away from the middle, so that no other arrow crosses it
            out, radius = self._out[arrow.source], self._radius[arrow.source]
            left, right = out * cmath.exp(-0.62j), out * cmath.exp(0.62j)
            return (
                a + radius * left,
                a + (radius + 62.0) * left,
                a + (radius + 62.0) * right,
                a + (radius + 3.0) * right,
            )
        way = b - a
        side = way * 1j / abs(way)
        bow = 0.5 * (a + b) + side * (0.13 * abs(way) + 6.0)
        start = a + (bow - a) / abs(bow - a) * self._radius[arrow.source]
        tip = b + (bow - b) / abs(bow - b) * (self._radius[arrow.target] + 3.0)
        return start, start + (bow - start) * 2 / 3, tip + (bow - tip) * 2 / 3, tip

    def arrow(self, arrow: Arrow, opacity: float) -> list[str]:
        """Draw an arrow's line and head."""
        start, one, two, tip = self._curve(arrow)
        alive = self._states[arrow.source].alive and self._states[arrow.target].alive
        colour = self.colour(arrow.source) if alive else "#9a9a9a"
        width = 1.0 + 0.6 * math.log2(1 + arrow.joins) / 2.0
        along = (tip - two) / abs(tip - two)
        foot = tip - along * _HEAD
        wing = along * 1j * _HEAD * 0.42
        corners = svg.point_list((p.real, p.imag) for p in (tip, foot + wing, foot - wing))
        points = svg.point_list((p.real, p.imag) for p in (start, one, two, foot)).split()
        curve = f"M {points[0]} C {' '.join(points[1:])}"
        return [
            svg.element("path", d=curve, fill="none", stroke=colour, stroke_width=width, stroke_opacity=opacity),
            svg.element("polygon", points=corners, fill=colour),
        ]

    def number(self, arrow: Arrow) -> list[str]:
        """Draw the number of joins on the line near its source, as the opposite arrow has its own number."""
        start, one, two, tip = self._curve(arrow)
        t = 0.5 if arrow.source == arrow.target else 0.3
        s = 1.0 - t
        at = s**3 * start + 3 * s * s * t * one + 3 * s * t * t * two + t**3 * tip
        words = str(arrow.joins)
        half = 3.6 * len(words) + 2.0
        box = {"x": at.real - half, "y": at.imag - 7, "width": 2 * half, "height": 14}
        colour = self.colour(arrow.source)
        return [
            svg.element("rect", **box, fill="white", fill_opacity=0.85),
            svg.text(at.real, at.imag + 4, words, font_size=11, text_anchor="middle", fill=colour),
        ]
