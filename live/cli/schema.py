"""`live schema`: what editors need to help with patches."""

from pathlib import Path
from typing import Annotated

import typer


def schema(
    out: Annotated[
        Path | None, typer.Option(help="Write it here; without it, it is printed.", metavar="FILE.json", dir_okay=False)
    ] = None,
) -> None:
    """The schema of patches, for editors of TOML (taplo, Even Better TOML): keys, meanings, ranges.

    A file of a show names it in its first line: #:schema patch.schema.json
    """
    import json

    from live.base.errors import PersonError
    from live.show.patch.patch_schema import patch_schema

    text = json.dumps(patch_schema(), indent=1, ensure_ascii=False) + "\n"
    if out is None:
        print(text, end="")
        return
    try:
        out.write_text(text, encoding="utf-8")
    except OSError as error:
        raise PersonError(f"cannot write --out {out}: {error.strerror}") from None
