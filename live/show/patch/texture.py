"""What upper bodies are textured with: `[texture]`."""

from typing import Annotated

from pydantic import Field

from live.show.patch.section_base import Section

Place = Annotated[str, Field(min_length=1, max_length=1000)]


class TextureSection(Section):
    """`[texture]`: recordings whose upper bodies dancers take over, as far as `texture` of `[motion]` says."""

    recordings: Annotated[tuple[Place, ...], Field(max_length=64)] = ()
    """Motion files, or folders of them, looked up in the patch's folder, then in the project's patches. What TOML files
    there say of their beats is true; else beats are guessed from the feet."""
    fps: Annotated[float, Field(ge=1, le=10_000)] | None = None
    """True frame rate of those whose headers lie."""
