"""`[audience]` of a venue: what the network is like by which phones come, and the certificate they are met with."""

import ipaddress
from typing import Annotated, Literal, Self

from pydantic import Field, field_validator, model_validator

from live.show.patch.section_base import Amiss, Section

File = Annotated[str, Field(min_length=1, max_length=400)]


class VenueAudience(Section):
    """`[audience]`: how phones are told apart in this hall."""

    network: Literal["own wifi", "behind nat", "proxy"] | None = None
    """`own wifi`: each phone has an address of its own; `behind nat`: they share one, or a few; `proxy`: they come
    through `proxies`, which say whose address each has. Left out: own wifi, or behind nat on this machine alone."""
    proxies: Annotated[tuple[str, ...], Field(max_length=16)] = ()
    """Addresses or networks, as in `["192.168.1.2", "10.0.0.0/24"]`, whose X-Forwarded-For or Forwarded is believed."""
    by_card: bool = True
    """On own wifi, whether phones are told apart by their network cards where this machine sees them; false where a
    repeater hides them behind its own."""
    code_s: Annotated[float, Field(ge=10, le=600, allow_inf_nan=False)] = 30.0
    """The code on the wall is another one after so many seconds ..."""
    grace_s: Annotated[float, Field(ge=20, le=3600, allow_inf_nan=False)] = 120.0
    """... and lets in, a few at a time, for so long after it has gone."""
    joins_per_code: Annotated[int, Field(ge=1, le=8000)] | None = None
    """So many devices come in by one code; twice as many as the patch lets play, and at least 200, if left out."""
    certificate: File | None = None
    """A PEM file with the certificate for https, and those that vouch for it; beside this file, or a whole path."""
    key: File | None = None
    """The PEM file with its key."""

    @field_validator("proxies")
    @classmethod
    def _networks(cls, proxies: tuple[str, ...]) -> tuple[str, ...]:
        for index, text in enumerate(proxies):
            try:
                network = ipaddress.ip_network(text, strict=False)
            except ValueError:
                raise Amiss(
                    f'an address or a network as in "10.0.0.0/24" expected, found {text[:60]!r}', index
                ) from None
            if network.prefixlen == 0:
                raise Amiss(f"{text!r} is everybody: then each phone could name any address; name the proxies", index)
        return proxies

    @model_validator(mode="after")
    def _whole(self) -> Self:
        if self.network == "proxy" and not self.proxies:
            raise Amiss('network = "proxy" needs proxies: the addresses that requests come from', "network")
        if (self.certificate is None) != (self.key is None):
            given = "certificate" if self.key is None else "key"
            raise Amiss("certificate and key belong together: give both", given)
        return self
