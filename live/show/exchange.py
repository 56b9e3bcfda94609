"""Exchange: the parts of a running show take over what an edited patch says from those of a fresh show of it.

Everything heavy was made with the fresh show, by another thread; here references change hands. Both shows are made of
the same parts under the same names, so each part meets its like: whoever has something of a patch has a method
`take_patch(fresh)`, and whoever keeps the patch itself finds the new one where the old one was.
"""

from typing import Any, Final

from live.show.patch.patch import Patch

_PARTS: Final = "live.show."


def exchange(part: Any, fresh: Any, old: Patch, new: Patch) -> None:
    """Let `part` and all parts below it take over what `fresh` and its parts have of the patch `new`.

    `take_patch` is called while the part still holds the `old` patch, once for every part, outermost first.
    """
    _exchange(part, fresh, old, new, set())


def _exchange(part: Any, fresh: Any, old: Patch, new: Patch, met: set[int]) -> None:
    met.add(id(part))
    take = getattr(part, "take_patch", None)
    if take is not None:
        take(fresh)
    for name, value in list(vars(part).items()):
        if value is old:
            setattr(part, name, new)
        elif type(value).__module__.startswith(_PARTS) and hasattr(value, "__dict__") and id(value) not in met:
            like = getattr(fresh, name, None)
            if type(like) is type(value) and like is not value:
                _exchange(value, like, old, new, met)
