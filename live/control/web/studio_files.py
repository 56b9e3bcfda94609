"""Files of a page of several files, such as the studio: kept in memory, compressed once, with a policy that runs only
them.

They contain no data of the show and no key, so anybody at an accepted address may read them.
"""

import gzip
import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from aiohttp import web

from live.control.web.http_protection import SECURITY_HEADERS

FOLDER: Final = Path(__file__).with_name("studio")
ROOT: Final = "/studio"
TYPES: Final = {".html": "text/html", ".js": "text/javascript", ".css": "text/css"}
"""Content types of the files that are served."""


@dataclass(frozen=True, slots=True)
class _File:
    content_type: str
    plain: bytes
    compressed: bytes
    tag: str
    """Hash for the browser's cache."""


class StudioFiles:
    """The files of a page by path. Thread: the loop's."""

    def __init__(self, folder: Path = FOLDER, root: str = ROOT) -> None:
        """Read the files in `folder`; `root`: path of its page. Without files there is no page."""
        self.root = root
        self._files: dict[str, _File] = {}
        for file in sorted(folder.iterdir()) if folder.is_dir() else ():
            if (kind := TYPES.get(file.suffix)) is not None:
                data = file.read_bytes()
                tag = f'"{hashlib.sha256(data).hexdigest()[:24]}"'
                kept = _File(kind, data, gzip.compress(data, 9, mtime=0), tag)
                self._files[root if file.name == "index.html" else f"{root}/{file.name}"] = kept

    def __contains__(self, path: object) -> bool:
        return path in self._files

    def answer(self, request: web.BaseRequest) -> web.Response:
        """Answer a request for one of the files: with the file, or that the browser has it already."""
        file = self._files[request.path]
        headers = {
            **SECURITY_HEADERS, "Content-Security-Policy": _policy(request.headers["Host"].casefold()),
            "Cache-Control": "no-cache", "ETag": file.tag, "Vary": "Accept-Encoding",
        }  # fmt: skip
        if request.headers.get("If-None-Match") == file.tag:
            return web.Response(status=304, headers=headers)
        body = file.plain
        if "gzip" in request.headers.get("Accept-Encoding", "").casefold():
            body, headers = file.compressed, {**headers, "Content-Encoding": "gzip"}
        return web.Response(body=body, content_type=file.content_type, charset="utf-8", headers=headers)


def _policy(host: str) -> str:
    """Return the content security policy; in some browsers 'self' does not include the server's WebSocket."""
    return (
        f"default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: "
        f"blob:; connect-src 'self' ws://{host} wss://{host}; base-uri 'none'; form-action 'none'; "
        "frame-ancestors 'none'"
    )
