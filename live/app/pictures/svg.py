"""SVG text: elements from their attributes, and whole drawings."""

from collections.abc import Iterable
from xml.sax.saxutils import escape, quoteattr

Point = tuple[float, float]
Attribute = str | float | None


def element(tag: str, content: str | None = None, /, **attributes: Attribute) -> str:
    """Return an element with this content (SVG text). `_` in names stands for `-`; None leaves an attribute out.

    Numbers have up to three decimals.
    """
    start = tag + "".join(
        f" {name.replace('_', '-')}={quoteattr(_value(value))}"
        for name, value in attributes.items()
        if value is not None
    )
    return f"<{start}/>" if content is None else f"<{start}>{content}</{tag}>"


def text(x: float, y: float, words: str, /, **attributes: Attribute) -> str:
    """Return text on a base line from (x, y)."""
    return element("text", plain(words), x=x, y=y, **attributes)


def circle(centre: Point, radius: float, /, **attributes: Attribute) -> str:
    """Return a circle."""
    return element("circle", cx=float(centre[0]), cy=float(centre[1]), r=radius, **attributes)


def plain(words: str) -> str:
    """Return words as content; control characters, which XML forbids, become `?`."""
    return escape("".join(sign if sign.isprintable() else "?" for sign in words))


def point_list(points: Iterable[Point]) -> str:
    """Return points as the attribute of a polygon or polyline."""
    return " ".join(f"{_value(float(x))},{_value(float(y))}" for x, y in points)


def drawing(
    width: float,
    height: float,
    parts: Iterable[str],
    *,
    box: tuple[float, float, float, float] | None = None,
    **attributes: Attribute,
) -> str:
    """Return a drawing of these elements on white, `width` times `height` pixels.

    `box`: left, top, width and height in the elements' units; None: pixels from the upper left corner.
    """
    left, top, across, down = box if box is not None else (0.0, 0.0, width, height)
    view = None if box is None else " ".join(_value(float(one)) for one in box)
    ground = element("rect", x=left, y=top, width=across, height=down, fill="white", stroke="none")
    content = "\n".join(["", ground, *parts, ""])
    font = "Helvetica, Arial, sans-serif"
    size = {"width": round(width), "height": round(height), "viewBox": view}
    return element("svg", content, xmlns="http://www.w3.org/2000/svg", **size, font_family=font, **attributes) + "\n"


def _value(value: str | float) -> str:
    """Return an attribute's value as text."""
    return (f"{value:.3f}".rstrip("0").rstrip(".") or "0") if isinstance(value, float) else str(value)
