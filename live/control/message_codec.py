"""MessagePack codec for packets between this program's processes, with support for registered dataclasses.

Decoded packets are data only: plain values (sequences are tuples), and registered classes with fields of their
annotated types. A packet cannot cause a call or an import by name.
"""

from collections.abc import Callable
from dataclasses import fields
from pathlib import PurePath
from typing import Any, Final, TypeVar

import msgpack

from live.base.field_types import build_dataclass

Kind = TypeVar("Kind")

_OBJECT: Final = 1
"""MessagePack extension type of an object: its name, then its fields in order."""

_names: dict[type, str] = {}
_makers: dict[str, Callable[[tuple[Any, ...]], Any]] = {}


class PacketError(ValueError):
    """Bytes that are no packet, or a value that cannot be encoded; the message states the reason."""


def registered(name: str) -> Callable[[type[Kind]], type[Kind]]:
    """Return a decorator that registers a dataclass for packets under this name."""

    def register(cls: type[Kind]) -> type[Kind]:
        names = [each.name for each in fields(cls)]  # type: ignore[arg-type]

        def make(values: tuple[Any, ...]) -> Any:
            return build_dataclass(cls, dict(zip(names, values, strict=True)))

        register_as(name, cls, make)
        return cls

    return register


def register_as(name: str, cls: type, make: Callable[[tuple[Any, ...]], Any]) -> None:
    """Register `cls` for packets under this name; `make` builds an object from its fields, or raises ValueError."""
    _names[cls] = name
    _makers[name] = make


def encode_packet(value: object) -> bytes:
    """Encode a value; PacketError for one that contains an unregistered type."""
    try:
        found: bytes = msgpack.packb(value, default=_encode_object)
    except (TypeError, ValueError, OverflowError) as error:
        raise PacketError(str(error)) from None
    return found


def decode_packet(data: bytes) -> Any:
    """Decode the bytes of `encode_packet`; PacketError for anything else."""
    try:
        return msgpack.unpackb(data, use_list=False, ext_hook=_decode_object, strict_map_key=False)
    except PacketError:
        raise
    except Exception as error:  # damaged bytes raise many kinds of errors
        raise PacketError(f"{type(error).__name__}: {error}"[:300]) from None


def _encode_object(value: object) -> Any:
    name = _names.get(type(value))
    if name is not None:
        row = [name, *(getattr(value, each.name) for each in fields(value))]  # type: ignore[arg-type]
        return msgpack.ExtType(_OBJECT, encode_packet(row))
    if type(value).__module__ == "numpy":  # a number; the supervisor, which also reads packets, has no arrays
        return value.item()  # type: ignore[attr-defined]
    if isinstance(value, PurePath):
        return str(value)
    if isinstance(value, set | frozenset):
        return list(value)
    raise TypeError(f"{type(value).__name__} cannot be put into a packet")


def _decode_object(code: int, data: bytes) -> Any:
    found = decode_packet(data) if code == _OBJECT else ()
    make = _makers.get(found[0]) if isinstance(found, tuple) and found and isinstance(found[0], str) else None
    if make is None:
        raise PacketError(f"extension {code} is not a registered type")
    return make(found[1:])
