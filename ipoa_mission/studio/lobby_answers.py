"""What the server tells the page of files: those that can be opened, and where one is open."""

from typing import Literal

from ipoa_mission.studio.vocabulary import PageMessage


class StartFile(PageMessage):
    """A file that can be opened."""

    path: str
    name: str
    folder: str
    of: Literal["scenario", "mission", "log"]


class Beginning(PageMessage):
    """What the start page offers; new files go into the folder."""

    kind: Literal["beginning"] = "beginning"
    folder: str
    recent: tuple[StartFile, ...]
    here: tuple[StartFile, ...]
    examples: tuple[StartFile, ...]


class Elsewhere(PageMessage):
    """Another file is open, at this address beside the page's own."""

    kind: Literal["elsewhere"] = "elsewhere"
    address: str
