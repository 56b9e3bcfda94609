"""SVG paths as polylines (T090): the `d` of a path, or all paths of an SVG file."""

import re
from typing import Final

import numpy as np

from live.agents.formations.svg_path import Segment, read_path
from live.base.arrays import Float64
from live.base.errors import PersonError

MAX_FILE_CHARACTERS: Final = 2_000_000
"""Largest accepted length of an SVG file in characters."""
MAX_SEGMENTS: Final = 2000
SAMPLES_PER_SEGMENT: Final = 24
"""Points per curved segment."""
_PATH_CHARACTERS: Final = re.compile(r"[MmZzLlHhVvCcSsQqTtAa0-9eE+\-.,\s]*\Z")


def path_lines(d: str, where: str) -> list[Float64]:
    """Return the lines of one path, each (P, 2) in its own units, y down; a closed one repeats its first point at the
    end.

    PersonError, beginning with `where`, if it is not a path.
    """
    if not _PATH_CHARACTERS.match(d):
        raise PersonError(f"{where}: not an SVG path: {d[:40]!r}", "example of a path: M 0 0 L 3 0 C 4 1 4 3 3 4 Z")
    try:
        path = read_path(d)
    except (ValueError, ArithmeticError) as error:
        raise PersonError(f"{where}: not an SVG path: {str(error)[:80]}") from None
    return _lines(path, where)


def svg_file_paths(text: str, where: str) -> tuple[str, ...]:
    """Return the paths of an SVG file (circles, rectangles and lines included, transforms applied) as texts of `d`.

    PersonError, beginning with `where`, if it is not an SVG file or draws nothing.
    """
    from xml.parsers.expat import ExpatError

    import svgpathtools  # takes a second to import, and only files need it

    if len(text) > MAX_FILE_CHARACTERS:
        raise PersonError(f"{where}: larger than {MAX_FILE_CHARACTERS // 1_000_000} MB", "draw it with fewer points")
    if "<!ENTITY" in text:
        raise PersonError(f"{where}: declares entities, which are not read", "save it as plain SVG")
    try:
        paths = svgpathtools.Document.from_svg_string(text).paths()
    except (ExpatError, SyntaxError) as error:
        raise PersonError(f"{where}: not an SVG file: {str(error)[:80]}") from None
    except Exception as error:  # the reader fails on unsupported shapes or transforms
        raise PersonError(f"{where}: cannot be read: {str(error)[:80] or type(error).__name__}") from None
    found = tuple(path.d() for path in paths if len(path))
    if not found:
        raise PersonError(f"{where}: draws no line", "turn texts and pictures into paths in the drawing program")
    return found


def _lines(path: list[Segment], where: str) -> list[Float64]:
    if not path:
        raise PersonError(f"{where}: the path draws no line", "example of a path: M 0 0 L 3 0")
    if len(path) > MAX_SEGMENTS:
        raise PersonError(f"{where}: more than {MAX_SEGMENTS} pieces", "simplify the path in the drawing program")
    lines: list[list[complex]] = []
    with np.errstate(all="ignore"):
        for number, segment in enumerate(path):
            if number == 0 or segment.start != path[number - 1].end:
                lines.append([segment.start])
            if segment.point is None:
                lines[-1].append(segment.end)
            else:
                shares = np.arange(1, SAMPLES_PER_SEGMENT + 1) / SAMPLES_PER_SEGMENT
                lines[-1] += [segment.point(float(share)) for share in shares]
    found = [np.array([(point.real, point.imag) for point in points]) for points in lines]
    if not all(np.isfinite(line).all() and np.abs(line).max() < 1e9 for line in found):
        raise PersonError(f"{where}: the path has no points, or one that is not a finite number")
    return found
