"""The flights of a survey one after the other: on a link the next one is the same vehicle's, with a charged battery."""

from typing import Any

from ipoa_mission.errors import MissionError
from ipoa_mission.studio.requests import Upload


class Relay:
    """Remembers which of a survey's flights was flown on a link, and by whom."""

    def __init__(self) -> None:
        self._link: str | None = None  # on which one of them is uploaded or flies
        self._systems: dict[str, int] = {}
        self._loaded = self._flown = ""

    def hear(self, answer: dict[str, Any]) -> None:
        """What the pilot tells."""
        if self._link is None:
            return
        if answer["kind"] == "loaded":
            self._loaded, self._systems[self._link] = answer["mission"], answer["system"]
        elif answer["kind"] == "state" and answer["phase"] == "flying":
            self._flown = self._loaded

    def expect_charged(self, request: Upload, is_survey: bool) -> Upload:
        """The upload, on the same link to the vehicle that has flown before.

        Raises:
            MissionError: it has flown since somebody said that a charged battery is in.
        """
        if not is_survey or request.link is None:
            self._link = None
            return request
        if self._flown and not request.charged:
            words = f"{self._flown} was flown with the battery that is in: expected a charged one"
            raise MissionError(
                words, hint="say that it is in, and that nobody is near the propellers", code="battery-flown"
            )
        self._flown, self._link = "", request.link
        return request.model_copy(update={"system": request.system or self._systems.get(request.link)})
