"""Names of films, and their frames a second, as they are written on the command line."""

import re
from fractions import Fraction
from pathlib import Path
from typing import Final

from live.base.errors import PersonError

PICTURES: Final = "%05d.png"
"""Pictures of a film that is a folder."""
_NUMBER: Final = re.compile(r"%0?\d{0,2}d")
_KINDS: Final = (".mp4", ".mov", ".mkv")
_WITH_ALPHA: Final = (".mov", ".mkv")
_SLOWER: Final = Fraction(1000, 1001)
"""Television in America is by so much slower than its name says: 59.94 is 60000/1001."""


def film_name(path: Path, option: str, *, alpha: bool = False, never: list[str | None]) -> Path:
    """The film's name, with the pattern of its pictures if it is a folder of PNG files.

    PersonError for a name of another kind, a kind without alpha if that is wanted, a place that is not there, and a
    name of one of the files in `never`, which the show is made from.
    """
    if path.is_dir() or (not path.suffix and "%" not in path.name):
        path = path / PICTURES
    if path.suffix.lower() == ".png":
        return _pictures(path, option)
    if path.suffix.lower() not in _KINDS:
        raise PersonError(
            f"{option} {path}: a film's name ends in {', '.join(_KINDS)}, or is a folder for PNG pictures",
            f"{option} {path.with_suffix('.mp4')}",
        )
    if alpha and path.suffix.lower() not in _WITH_ALPHA:
        raise PersonError(
            f"{option} {path}: {path.suffix} has no alpha; {', '.join(_WITH_ALPHA)} and folders of PNG pictures have",
            f"{option} {path.with_suffix('.mov')}",
        )
    if not path.parent.is_dir():
        raise PersonError(f"{option} {path}: there is no folder {path.parent}", f"mkdir -p {path.parent}")
    for other in never:
        if other is not None and path.exists() and Path(other).exists() and path.samefile(other):
            raise PersonError(f"{option} {path}: that is a file the show is made from", "give the film another name")
    return path


def _pictures(path: Path, option: str) -> Path:
    if len(_NUMBER.findall(path.name)) != 1 or path.name.count("%") != 1:
        raise PersonError(
            f"{option} {path}: pictures are numbered: their name needs one %05d",
            f"{option} {path.parent / (path.stem.replace('%', '') + '-' + PICTURES)}",
        )
    if "%" in str(path.parent):
        raise PersonError(f"{option} {path}: the number belongs into the name of the pictures, not of their folder")
    if path.parent.exists() and not path.parent.is_dir():
        raise PersonError(f"{option} {path}: {path.parent} is no folder")
    if not path.parent.parent.is_dir():
        raise PersonError(f"{option} {path}: there is no folder {path.parent.parent}", f"mkdir -p {path.parent}")
    return path


def parse_rate(text: str | None, option: str = "--fps") -> float | None:
    """Frames a second, 1 to 480: 60, 59.94 (that is 60000/1001) or a fraction like 24000/1001; None stays None."""
    if text is None:
        return None
    try:
        rate = Fraction(text.strip())
    except (ValueError, ZeroDivisionError):
        raise PersonError(f"{option} {text!r}: frames a second expected", f"{option} 60 or {option} 59.94") from None
    if not 1 <= rate <= 480:
        raise PersonError(f"{option} {text}: 1 to 480 expected")
    named = round(rate / _SLOWER) * _SLOWER
    if "/" not in text and rate.denominator > 1 and abs(rate - named) < Fraction(1, 200):
        rate = named
    return float(rate)
