"""Which OpenGL this machine has, asked in a process of its own: a broken driver may crash or hang there."""

import json
import subprocess
import sys
from dataclasses import dataclass

_PROBE = """
import json, sys, moderngl
options = {"backend": "egl"} if sys.platform == "linux" else {}
context = moderngl.create_context(standalone=True, **options)
print(json.dumps([context.info["GL_RENDERER"], context.info["GL_VERSION"], context.version_code]))
"""
_SOFTWARE = ("llvmpipe", "softpipe", "swrast", "software rasterizer", "swiftshader")


@dataclass(frozen=True, slots=True)
class OpenGL:
    """What drawing without a window gives: the renderer's name (None = there is none, and `why`) and version."""

    renderer: str | None
    version: str = ""
    code: int = 0
    """Version as moderngl counts it: 450 is OpenGL 4.5."""
    why: str = ""

    @property
    def software(self) -> bool:
        """Whether the CPU draws (Mesa's llvmpipe and its like)."""
        return self.renderer is not None and any(word in self.renderer.lower() for word in _SOFTWARE)


def probe_opengl(timeout: float = 30.0) -> OpenGL:
    """Create an offscreen context as headless shows do and read its names; never raises, waits `timeout` [s]."""
    try:
        done = subprocess.run(
            [sys.executable, "-c", _PROBE], capture_output=True, text=True, timeout=timeout, check=False
        )
        renderer, version, code = json.loads(done.stdout)
    except subprocess.TimeoutExpired:
        return OpenGL(None, why=f"the driver did not answer within {timeout:g} s")
    except ValueError:
        said = done.stderr.strip().splitlines()
        return OpenGL(None, why=said[-1] if said else f"the driver crashed (exit {done.returncode})")
    return OpenGL(renderer, version, code)
