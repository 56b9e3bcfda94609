"""Command `live schema`: writes the JSON schema of patches for editors."""

from pathlib import Path
from typing import Annotated

import typer


def schema(
    out: Annotated[
        Path | None, typer.Option(help="Write it here. Default: print it.", metavar="FILE.json", dir_okay=False)
    ] = None,
) -> None:
    """Write the JSON schema of patches (keys, descriptions, ranges) for TOML editors (taplo, Even Better TOML).

    The first line of a patch refers to it: #:schema patch.schema.json
    """
    import json

    from live.app.bridges import installed_bridges
    from live.base.errors import PersonError
    from live.show.patch.patch_schema import patch_schema

    text = json.dumps(patch_schema(installed_bridges().patch_tables()), indent=1, ensure_ascii=False) + "\n"
    if out is None:
        print(text, end="")
        return
    try:
        out.write_text(text, encoding="utf-8")
    except OSError as error:
        raise PersonError(f"cannot write --out {out}: {error.strerror}") from None
