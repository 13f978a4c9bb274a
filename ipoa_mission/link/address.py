"""Parse connection strings; the default host is the loopback, for safety."""

import re
from dataclasses import dataclass
from enum import StrEnum

from ipoa_mission.errors import BadInput

LOOPBACK = "127.0.0.1"
DEFAULT_BAUD = 57600
_NETWORK = re.compile(r"(?P<kind>\w+):(//)?(?P<host>\[[0-9a-fA-F:.]+\]|[^:/\[\]]*):(?P<port>\d{1,9})/?", re.ASCII)
_SERIAL = re.compile(r"serial:(//)?(?P<device>[^:]+)(:(?P<baud>\d{1,9}))?", re.ASCII)


class Transport(StrEnum):
    UDP_IN = "udpin"
    UDP_OUT = "udpout"
    TCP_OUT = "tcp"
    TCP_IN = "tcpin"
    SERIAL = "serial"


_SPELLINGS = {
    "udp": Transport.UDP_IN,  # as in MAVSDK and mavutil
    "udpin": Transport.UDP_IN,
    "udpout": Transport.UDP_OUT,
    "tcp": Transport.TCP_OUT,
    "tcpout": Transport.TCP_OUT,
    "tcpin": Transport.TCP_IN,
}


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
    if match := _SERIAL.fullmatch(url):
        return Address(Transport.SERIAL, device=match["device"], baud=int(match["baud"] or DEFAULT_BAUD))
    match = _NETWORK.fullmatch(url)
    if match is None or match["kind"] not in _SPELLINGS:
        raise BadInput(
            f"expected udpin:HOST:PORT, udpout:HOST:PORT, tcp:HOST:PORT, tcpin:HOST:PORT or serial:DEVICE:BAUD, "
            f"not {url!r}",
            hint="for instance udpin:127.0.0.1:14550",
            place="link",
        )
    port = int(match["port"])
    if port > 65535:
        raise BadInput(f"expected a port up to 65535, not {port}", place="link")
    return Address(_SPELLINGS[match["kind"]], match["host"].strip("[]") or LOOPBACK, port)
