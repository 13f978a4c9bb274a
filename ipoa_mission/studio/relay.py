from typing import Any

from ipoa_mission.errors import MissionError
from ipoa_mission.studio.requests import Upload


class Relay:
    def __init__(self) -> None:
        self._link: str | None = None
        self._systems: dict[str, int] = {}
        self._loaded = self._flown = ""

    def hear(self, answer: dict[str, Any]) -> None:
        if self._link is None:
            return
        if answer["kind"] == "loaded":
            self._loaded, self._systems[self._link] = answer["mission"], answer["system"]
        elif answer["kind"] == "state" and answer["phase"] == "flying":
            self._flown = self._loaded

    def expect_charged(self, request: Upload, is_survey: bool) -> Upload:
        """Return the upload for the same vehicle. Raises MissionError until a charged battery is confirmed."""
        if not is_survey or request.link is None:
            self._link = None
            return request
        if self._flown and not request.charged:
            words = f"expected a charged battery, not the one that flew {self._flown}"
            raise MissionError(
                words, hint="confirm that it is in, and that nobody is near the propellers", code="battery-flown"
            )
        self._flown, self._link = "", request.link
        return request.model_copy(update={"system": request.system or self._systems.get(request.link)})
