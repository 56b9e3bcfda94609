"""The page that phones load: one file, made once in each language, with headers that let nothing else in."""

import base64
import gzip
import hashlib
import re
from pathlib import Path
from typing import Final

from aiohttp import web

PAGE: Final = Path(__file__).with_name("page.html")
LANGUAGES: Final = ("en", "pt")


class Pages:
    """Thread: one."""

    def __init__(self, link: str) -> None:
        """`link`: the address that phones are given."""
        self.host = link.partition("://")[2].partition("/")[0].rpartition("@")[2]
        text = PAGE.read_text("utf-8")
        self._pages = {}
        for language in LANGUAGES:
            page = text.replace('<html lang="en"', f'<html lang="{language}"', 1).encode()
            self._pages[language] = (page, gzip.compress(page, 9, mtime=0))
        hashes = [_hashed(found) for found in re.findall(r"<script>(.*?)</script>", text, re.S)]
        styles = [_hashed(found) for found in re.findall(r"<style>(.*?)</style>", text, re.S)]
        policy = (
            f"default-src 'none'; script-src {' '.join(hashes)}; style-src {' '.join(styles)}; "
            "connect-src 'self' ws: wss:; img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
        )
        self._headers = {
            "Content-Security-Policy": policy, "X-Content-Type-Options": "nosniff", "Referrer-Policy": "no-referrer",
            "Vary": "Accept-Language, Accept-Encoding", "Cache-Control": "max-age=60",
        }  # fmt: skip

    def answer(self, request: web.Request) -> web.Response:
        """The page in the language that a browser prefers."""
        plain, packed = self._pages[language_of(request.headers.get("Accept-Language", ""))]
        headers = self._headers
        if "gzip" in request.headers.get("Accept-Encoding", ""):
            headers, plain = headers | {"Content-Encoding": "gzip"}, packed
        return web.Response(body=plain, content_type="text/html", charset="utf-8", headers=headers)


def language_of(accepted: str) -> str:
    """The language of the page for a header Accept-Language (RFC 9110, 12.5.4); English where it says none of ours."""
    best, found = 0.0, LANGUAGES[0]
    for index, part in enumerate(accepted[:400].split(",")[:20]):
        tag, _, rest = part.strip().partition(";")
        name = tag.strip().partition("-")[0].casefold()
        match = re.fullmatch(r"\s*q=([01](?:\.\d{0,3})?)\s*", rest) if rest else None
        weight = (float(match[1]) if match else 1.0 if not rest else 0.0) - 1e-4 * index
        if name in LANGUAGES and weight > best:
            best, found = weight, name
    return found


def _hashed(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"
