"""Names and frame rates of films on the command line: parsed, and refused with a remedy."""

import difflib
import re
from fractions import Fraction
from pathlib import Path
from typing import Final

from live.base.errors import PersonError
from live.library.motion_formats import stage_suffixes

PICTURES: Final = "%05d.png"
"""Name pattern of the pictures if the film is a folder."""
_NUMBER: Final = re.compile(r"%0?\d{0,2}d")
_FILM_ENDINGS: Final = (".mp4", ".mov", ".mkv")
_WITH_ALPHA: Final = (".mov", ".mkv")
_FRAMES: Final = re.compile(r"([0-9]{1,9})?:([0-9]{1,9})?")
_NTSC_FACTOR: Final = Fraction(1000, 1001)
"""NTSC factor: 59.94 is 60000/1001."""


def parse_film_path(path: Path, option: str, *, alpha: bool = False, inputs: list[str | None]) -> Path:
    """Return the path of a film or of the dancers' motion, with the name pattern of its pictures if it is a folder of
    PNG files.

    Raise PersonError for an unknown format, a format without alpha if `alpha` is set, a missing folder, and for the
    input files in `inputs`.
    """
    if path.is_dir() or (not path.suffix and "%" not in path.name):
        path = path / PICTURES
    if path.suffix.lower() == ".png":
        return _pictures(path, option)
    motion_suffixes = stage_suffixes()
    if path.suffix.lower() not in (*_FILM_ENDINGS, *motion_suffixes):
        raise PersonError(
            f"{option} {path}: a film's name ends in {', '.join(_FILM_ENDINGS)}, or names a folder for PNG pictures; "
            f"the dancers' motion goes into {', '.join(motion_suffixes)}",
            f"{option} {path.with_suffix(next(iter(_near_suffix(path, (*_FILM_ENDINGS, *motion_suffixes))), '.mp4'))}",
        )
    if alpha and path.suffix.lower() in motion_suffixes:
        raise PersonError(f"--alpha: {option} {path} has motion and no pictures", "leave --alpha out")
    if alpha and path.suffix.lower() not in _WITH_ALPHA:
        raise PersonError(
            f"{option} {path}: {path.suffix} has no alpha; {', '.join(_WITH_ALPHA)} and folders of PNG pictures have",
            f"{option} {path.with_suffix('.mov')}",
        )
    if not path.parent.is_dir():
        raise PersonError(f"{option} {path}: there is no folder {path.parent}", f"mkdir -p {path.parent}")
    for other in inputs:
        if other is not None and path.exists() and Path(other).exists() and path.samefile(other):
            raise PersonError(f"{option} {path}: the show reads this file", "give the film another name")
    return path


def _near_suffix(path: Path, known: tuple[str, ...]) -> list[str]:
    return difflib.get_close_matches(path.suffix.lower(), known, n=1)


def _pictures(path: Path, option: str) -> Path:
    if len(_NUMBER.findall(path.name)) != 1 or path.name.count("%") != 1:
        raise PersonError(
            f"{option} {path}: the pictures' name needs one number pattern such as %05d",
            f"{option} {path.parent / (path.stem.replace('%', '') + '-' + PICTURES)}",
        )
    if "%" in str(path.parent):
        raise PersonError(f"{option} {path}: the number pattern belongs in the pictures' name, not in the folder's")
    if path.parent.exists() and not path.parent.is_dir():
        raise PersonError(f"{option} {path}: {path.parent} is not a folder")
    if not path.parent.parent.is_dir():
        raise PersonError(f"{option} {path}: there is no folder {path.parent.parent}", f"mkdir -p {path.parent}")
    return path


def parse_rate(text: str | None, option: str = "--fps") -> float | None:
    """Parse frames per second, 1 to 480: 60, 59.94 (60000/1001) or a fraction such as 24000/1001; None for None."""
    if text is None:
        return None
    try:
        rate = Fraction(text.strip())
    except (ValueError, ZeroDivisionError):
        raise PersonError(f"{option} {text!r}: frames per second expected", f"{option} 60 or {option} 59.94") from None
    if not 1 <= rate <= 480:
        raise PersonError(f"{option} {text}: 1 to 480 expected")
    named = round(rate / _NTSC_FACTOR) * _NTSC_FACTOR
    if "/" not in text and rate.denominator > 1 and abs(rate - named) < Fraction(1, 200):
        rate = named
    return float(rate)


def parse_frames(text: str | None, option: str = "--frames") -> tuple[int, int | None] | None:
    """Parse frames of the whole show, half-open and from 0: `A:B`, `A:` to the end, `:B` from the beginning; None for
    None."""
    if text is None:
        return None
    found = _FRAMES.fullmatch(text.strip())
    if found is None:
        raise PersonError(f"{option} {text!r}: the first frame and the one after the last expected", f"{option} 0:240")
    first, end = int(found[1] or 0), int(found[2]) if found[2] else None
    if end is not None and first >= end:
        raise PersonError(f"{option} {text}: there is no frame between {first} and {end}")
    return first, end
