"""Where the picture is shared, as it is written on the command line."""

import re
from typing import Final

from live.base.errors import PersonError

_STREAMS: Final = ("udp", "rtp", "tcp", "srt")
_NAME: Final = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,63}")


def parse_shares(texts: list[str] | None) -> tuple[str, ...]:
    """`shm:NAME`, or an address like `udp://127.0.0.1:5000`, each once; PersonError for what is neither."""
    for text in texts or []:
        scheme, colon, rest = text.partition(":")
        if scheme == "shm" and colon:
            if not _NAME.fullmatch(rest):
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
        from live.render.film.network_stream import has_srt

        if not has_srt():
            raise PersonError(
                f"--share {text}: this PyAV was built without SRT",
                "--share udp://127.0.0.1:5000, and let ffmpeg carry it on: "
                f"ffmpeg -i udp://127.0.0.1:5000 -c copy -f mpegts '{text}'",
            )
