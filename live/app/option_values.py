"""Options of the command line: their form as fields of a dataclass, and parsers and checks that commands share."""

import os
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from live.base.errors import PersonError

MAX_PICTURE_SIZE = 8192


def parse_size(text: str) -> tuple[int, int]:
    """Parse a picture size such as 1280x720; raise PersonError for anything else."""
    match = re.fullmatch(r"\s*(\d{2,5})\s*[xX×]\s*(\d{2,5})\s*", text)
    if match is None or not all(16 <= int(n) <= MAX_PICTURE_SIZE for n in match.groups()):
        raise PersonError(
            f"--size {text!r}: width and height in pixels expected, 16 to {MAX_PICTURE_SIZE}", "--size 1280x720"
        )
    return int(match[1]), int(match[2])


def parse_stage(text: str) -> tuple[float, float]:
    """Parse a stage's width and depth [m] such as 12x8; raise PersonError for anything else."""
    try:
        width, depth = (float(each) for each in text.lower().replace("×", "x").split("x"))
    except ValueError:
        width = depth = 0.0
    if not (2 <= width <= 200 and 2 <= depth <= 200):
        raise PersonError(f"--stage {text[:80]!r}: width and depth from 2 to 200 m expected", "--stage 12x8")
    return width, depth


def parse_endpoint(text: str, name: str = "--osc") -> tuple[str, int]:
    """Parse HOST:PORT, PORT or [IPV6]:PORT; raise PersonError for anything else."""
    match = re.fullmatch(r"(?:(\[[0-9A-Fa-f:.]+\]|[^:\s]+):)?(\d{1,5})", text.strip())
    if match is None or int(match[2]) > 65535:
        raise PersonError(f"{name} {text!r}: HOST:PORT expected, port 0 to 65535", f"{name} 127.0.0.1:9010")
    return (match[1] or "127.0.0.1").strip("[]"), int(match[2])


AUDIENCE_PORT = 8020
"""Default port for phones."""
GATEWAYS_PORT = 9023
"""Default port where gateways of other machines join a show."""
NODES_PORT = 9022
"""Default port for render nodes."""
_AUDIENCE = re.compile(r"(?:(\[[0-9A-Fa-f:.%]+\]|[^\s:\[\]]+):)?(\d{1,5})")


def parse_audience_address(text: str) -> tuple[str, int]:
    """Parse [HOST:]PORT of the server for phones; raise PersonError for anything else."""
    match = _AUDIENCE.fullmatch(text.strip())
    if match is None or int(match[2]) > 65535:
        raise PersonError(f"--audience {text!r}: [HOST:]PORT expected", f"--audience 0.0.0.0:{AUDIENCE_PORT}")
    return (match[1] or "127.0.0.1").strip("[]"), int(match[2])


def parse_audience_link(text: str | None) -> str | None:
    """Check and return the web address given to phones; raise PersonError if it is invalid."""
    if text is not None and re.fullmatch(r"https?://[A-Za-z0-9.\-\[\]:]{1,200}/?", text) is None:
        raise PersonError(f"--audience-link {text!r}: an address as in http://stage.local:8020 expected")
    return text


def expand_optional_values(words: list[str]) -> list[str]:
    """Return the command line with `--audience` and `--nodes` without a value expanded to their defaults."""
    found = []
    for index, word in enumerate(words):
        found.append(word)
        after = words[index + 1] if index + 1 < len(words) else ""
        if word == "--audience" and _AUDIENCE.fullmatch(after) is None:
            found.append(f"127.0.0.1:{AUDIENCE_PORT}")
        elif word == "--nodes" and _AUDIENCE.fullmatch(after) is None:
            found.append(str(NODES_PORT))
    return found


def add_default_port(text: str, port: int) -> str:
    """Append the default port to a host without one; text that has a port already is returned unchanged."""
    host = text.strip()
    return host if ":" in host or host.isdecimal() or not host else f"{host}:{port}"


def check_range(value: float | None, name: str, low: float, high: float) -> None:
    """Raise PersonError unless `value` is None or a number within [low, high]."""
    if value is not None and not low <= value <= high:  # NaN fails the comparison too
        raise PersonError(f"{name} {value:g}: {low:g} to {high:g} expected")


def check_choice(value: str | None, name: str, *choices: str) -> str | None:
    """Return `value`; raise PersonError unless it is None or one of `choices`."""
    if value is not None and value not in choices:
        raise PersonError(f"{name} {value}: one of {', '.join(choices)} expected", f"{name} {choices[0]}")
    return value


def parse_measures(text: str | None) -> tuple[int, int] | None:
    """Parse a range of measures such as `17-24` or `17`, counted from 1; raise PersonError for anything else."""
    if text is None:
        return None
    match = re.fullmatch(r"\s*(\d{1,6})\s*(?:[-–]\s*(\d{1,6})\s*)?", text)
    first, last = (0, 0) if match is None else (int(match[1]), int(match[2] or match[1]))
    if not 1 <= first <= last:
        raise PersonError(f"--measures {text!r}: two measures of the score expected, from 1", "--measures 17-24")
    return first, last


def check_film_path(path: Path | None, name: str, *, inputs: list[str | None]) -> None:
    """Raise PersonError unless `path` is None or an mp4 file name that is not one of the input files in `inputs`."""
    if path is None:
        return
    if path.suffix.lower() != ".mp4":
        raise PersonError(f"{name} {path}: a film's name ends in .mp4", f"{name} {path.with_suffix('.mp4')}")
    for other in inputs:
        if other is not None and path.exists() and Path(other).exists() and path.samefile(other):
            raise PersonError(f"{name} {path}: the show reads this file", "give the film another name")


def check_writable(path: Path | None, name: str) -> None:
    """Raise PersonError unless `path` is None or could be written: its folder exists and it is not a folder itself."""
    if path is None:
        return
    if path.is_dir():
        raise PersonError(f"{name} {path}: that is a folder; give the name of a file")
    if path.exists() and not os.access(path, os.W_OK):
        raise PersonError(f"{name} {path}: no permission to write it")
    if not path.parent.is_dir():
        raise PersonError(f"{name} {path}: there is no folder {path.parent}", f"mkdir -p {path.parent}")


_STREAMS = ("udp", "rtp", "tcp", "srt")
_SHARE_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,63}")


def parse_shares(texts: list[str] | None) -> tuple[str, ...]:
    """Check `shm:NAME` or addresses such as `udp://127.0.0.1:5000`; return each once. Raise PersonError for others."""
    for text in texts or []:
        scheme, colon, rest = text.partition(":")
        if scheme == "shm" and colon:
            if not _SHARE_NAME.fullmatch(rest):
                raise PersonError(
                    f"--share {text}: a name of letters, digits, dots and dashes expected", "--share shm:choreographics"
                )
        elif scheme in _STREAMS and rest.startswith("//"):
            _check_address(text, rest[2:])
        else:
            raise PersonError(
                f"--share {text}: shm:NAME, or an address with {', '.join(f'{one}://' for one in _STREAMS)} expected",
                "--share udp://127.0.0.1:5000",
            )
    return tuple(dict.fromkeys(texts or []))


def _check_address(text: str, rest: str) -> None:
    match = re.fullmatch(r"(?:\[[0-9A-Fa-f:.]+\]|[^:/?\s]*):(\d{1,5})(?:[/?]\S*)?", rest)
    if match is None or not 1 <= int(match[1]) <= 65535:
        scheme = text.partition(":")[0]
        raise PersonError(f"--share {text}: HOST:PORT expected, port 1 to 65535", f"--share {scheme}://127.0.0.1:5000")
    if text.startswith("srt:"):
        from live.render.film.network_stream import is_srt_supported

        if not is_srt_supported():
            raise PersonError(
                f"--share {text}: this PyAV was built without SRT",
                "--share udp://127.0.0.1:5000, and let ffmpeg forward it: "
                f"ffmpeg -i udp://127.0.0.1:5000 -c copy -f mpegts '{text}'",
            )


OPTION: Final = "option"
"""Key of a field's metadata."""


@dataclass(frozen=True, slots=True)
class Option:
    """How a field is written on the command line."""

    help: str
    panel: str | None = None
    written: Any = None
    """Type of what a person writes; None: the field's own."""
    default: Any = None
    """What stands for the field's default there."""
    parse: Callable[[Any, str], Any] | None = None
    """Makes the field's value of what was written and the option's name; PersonError where that is wrong."""
    flags: tuple[str, ...] = ()
    """The option's names; none: the field's name with dashes."""
    argument: bool = False
    """Whether it is written without a name."""
    details: Mapping[str, Any] = field(default_factory=dict)
    """More for typer: metavar, limits, environment variable."""


def option(default: Any, help: str, panel: str | None = None, *, metavar: str | None = None, **how: Any) -> Any:
    """Return a field of a dataclass that is an option of the command line, too."""
    own = {name: how.pop(name) for name in ("written", "default_text", "parse", "flags", "argument") if name in how}
    shown = own.pop("default_text", None if own.get("written") is not None else default)
    details = {**how, **({} if metavar is None else {"metavar": metavar})}
    return field(default=default, metadata={OPTION: Option(help, panel, default=shown, details=details, **own)})


def within(low: float, high: float) -> Callable[[Any, str], Any]:
    """Return the `parse` of an option that is a number within [low, high]."""

    def parse(value: Any, name: str) -> Any:
        check_range(value, name, low, high)
        return value

    return parse


def writable(path: Path, name: str) -> Path:
    """Return the path of a file that can be written: the `parse` of an option."""
    check_writable(path, name)
    return path


def several(parse: Callable[[str, str], Any] = lambda text, name: text) -> dict[str, Any]:
    """Return what `option` is told of an option that may come several times; `parse` reads one of its values."""
    return {"written": list[str], "parse": lambda texts, name: tuple(parse(text, name) for text in texts)}
