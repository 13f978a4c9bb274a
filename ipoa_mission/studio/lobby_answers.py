from typing import Literal

from ipoa_mission.studio.vocabulary import PageMessage


class StartFile(PageMessage):
    path: str
    name: str
    folder: str
    of: Literal["scenario", "mission", "log"]


class Beginning(PageMessage):
    kind: Literal["beginning"] = "beginning"
    folder: str
    recent: tuple[StartFile, ...]
    here: tuple[StartFile, ...]
    examples: tuple[StartFile, ...]


class Elsewhere(PageMessage):
    kind: Literal["elsewhere"] = "elsewhere"
    address: str
