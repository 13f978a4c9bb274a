"""Parse connection strings; the default host is the loopback, for safety."""

import re
from dataclasses import dataclass
from enum import StrEnum

from ipoa_mission.errors import BadInput

LOOPBACK = "127.0.0.1"
DEFAULT_BAUD = 57600


class Transport(StrEnum):
    UDP_IN = "udpin"
    UDP_OUT = "udpout"
    TCP_OUT = "tcp"
    TCP_IN = "tcpin"
    SERIAL = "serial"


@dataclass(frozen=True)
class Address:
    transport: Transport
    host: str = LOOPBACK
    port: int = 0
    device: str = ""
    baud: int = DEFAULT_BAUD

    def __str__(self) -> str:
        if self.transport is Transport.SERIAL:
            return f"serial:{self.device}:{self.baud}"
        return f"{self.transport}:{self.host}:{self.port}"


def parse_address(url: str) -> Address:
    if match := re.fullmatch(r"serial:(//)?(?P<device>[^:]+)(:(?P<baud>\d{1,9}))?", url, re.ASCII):
        return Address(Transport.SERIAL, device=match["device"], baud=int(match["baud"] or DEFAULT_BAUD))
    host = r"(?P<host>\[[0-9a-fA-F:.]+\]|[^:/\[\]]*)"
    match = re.fullmatch(
        rf"(?P<kind>udp|udpin|udpout|tcp|tcpout|tcpin):(//)?{host}:(?P<port>\d{{1,9}})/?", url, re.ASCII
    )
    if match is None:
        raise BadInput(
            f"expected udpin:HOST:PORT, udpout:HOST:PORT, tcp:HOST:PORT, tcpin:HOST:PORT or serial:DEVICE:BAUD, "
            f"not {url!r}",
            hint="for instance udpin:127.0.0.1:14550",
            place="link",
        )
    port = int(match["port"])
    if port > 65535:
        raise BadInput(f"expected a port up to 65535, not {port}", place="link")
    kind = {"udp": "udpin", "tcpout": "tcp"}.get(match["kind"], match["kind"])  # udp: as in MAVSDK and mavutil
    return Address(Transport(kind), match["host"].strip("[]") or LOOPBACK, port)
