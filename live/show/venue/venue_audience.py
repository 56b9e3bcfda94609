"""`[audience]` of a venue: network of the phones, and the certificate of the audience server."""

import ipaddress
from typing import Annotated, Literal, Self

from pydantic import Field, field_validator, model_validator

from live.show.patch.section_base import InvalidEntry, Section

File = Annotated[str, Field(min_length=1, max_length=400)]


class VenueAudience(Section):
    """`[audience]`: how phones are identified in this hall."""

    network: Literal["own wifi", "behind nat", "proxy"] | None = None
    """`own wifi`: each phone has its own address; `behind nat`: they share one or a few; `proxy`: they connect through
    `proxies`, which forward their addresses. Default: own wifi, or behind nat if only this machine can connect."""
    proxies: Annotated[tuple[str, ...], Field(max_length=16)] = ()
    """Addresses or networks, as in `["192.168.1.2", "10.0.0.0/24"]`, whose X-Forwarded-For or Forwarded is trusted."""
    by_card: bool = True
    """On own wifi, whether phones are identified by MAC address where this machine sees it; false if a repeater
    replaces it with its own."""
    code_s: Annotated[float, Field(ge=10, le=600, allow_inf_nan=False)] = 30.0
    """Interval at which the code on the wall changes [s]."""
    grace_s: Annotated[float, Field(ge=20, le=3600, allow_inf_nan=False)] = 120.0
    """Time for which an old code still admits phones, at a limited rate [s]."""
    joins_per_code: Annotated[int, Field(ge=1, le=200000)] | None = None
    """Maximum number of devices per code; default: twice the patch's number of players, at least 200."""
    certificate: File | None = None
    """A PEM file with the https certificate and its chain; relative to this file, or an absolute path."""
    key: File | None = None
    """The PEM file with its key."""

    @field_validator("proxies")
    @classmethod
    def _networks(cls, proxies: tuple[str, ...]) -> tuple[str, ...]:
        for index, text in enumerate(proxies):
            try:
                network = ipaddress.ip_network(text, strict=False)
            except ValueError:
                raise InvalidEntry(
                    f'an address or a network as in "10.0.0.0/24" expected, found {text[:60]!r}', index
                ) from None
            if network.prefixlen == 0:
                raise InvalidEntry(
                    f"{text!r} matches every address, so phones could forge theirs; name the proxies", index
                )
        return proxies

    @model_validator(mode="after")
    def _whole(self) -> Self:
        if self.network == "proxy" and not self.proxies:
            raise InvalidEntry('network = "proxy" needs proxies: the addresses that requests come from', "network")
        if (self.certificate is None) != (self.key is None):
            given = "certificate" if self.key is None else "key"
            raise InvalidEntry("certificate and key belong together: give both", given)
        return self
