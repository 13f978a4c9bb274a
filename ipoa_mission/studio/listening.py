"""Listen for vehicles on this machine's usual ports and serial ports."""

from collections.abc import Iterator

from ipoa_mission.errors import MissionError
from ipoa_mission.link.channel import serial_ports
from ipoa_mission.link.connect import open_line
from ipoa_mission.link.discovery import scan
from ipoa_mission.studio.flight_answers import Heard, HeardLink
from ipoa_mission.studio.harness import Answer, Order

LISTEN_S = 1.5  # per link; an autopilot's heartbeat comes once a second
BAUD = 57600
USUAL = ("udpin:127.0.0.1:14550", "udpin:127.0.0.1:14540", "tcp:127.0.0.1:5760")


def listen(order: Order, answer: Answer) -> None:
    """Listen to all links, and to the one that the user wrote."""
    links = dict.fromkeys([order["link"], *USUAL, *(f"serial:{port}:{BAUD}" for port in serial_ports())])
    answer(Heard(links=tuple(row for link in links if link for row in _heard_on(link))))


def _heard_on(link: str) -> Iterator[HeardLink]:
    try:
        with open_line(link) as line:
            found = scan(line, LISTEN_S)
    except MissionError as error:
        yield HeardLink(link=link, system=None, words=str(error).removeprefix(f"{link}: "))
        return
    for one in found:
        other = "" if one.kind.is_flown else ": it is not flown from here"
        words = f"{one.kind}, system {one.system}{', armed' if one.armed else ''}{other}"
        yield HeardLink(link=link, system=one.system, words=words)
    if not found:
        yield HeardLink(link=link, system=None, words="no vehicle heard")
