import math
from functools import lru_cache
from pathlib import Path

import numpy as np

from ipoa_mission.errors import MissionError
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.logs.flight_log import FlightLog, read_flights
from ipoa_mission.report.compare import compare_flight, flown_track
from ipoa_mission.studio.flight_answers import FlownItem, Replay
from ipoa_mission.studio.view import line_of

PLACE_LIMIT = 1000


def replayed(log: Path, forecast: Forecast, revision: int) -> Replay:
    """Compare the log's first flight in mission mode. Raises MissionError."""
    flown = _flights(str(log))
    flight = next((one for one in flown.flights if one.in_mission), None)
    if flight is None:
        raise MissionError("expected a flight in the mission mode", code="log-incomplete", place=log.name)
    forecast = forecast.on(flight.firmware_version)
    record = flight.record(forecast.mission)
    track = flown_track(forecast.mission, record)
    if track is None:
        raise MissionError("expected a flight with positions", code="log-incomplete", place=log.name)
    held = compare_flight(forecast.estimate, record)
    shown = np.unique(np.linspace(0, len(track.times) - 1, min(PLACE_LIMIT, len(track.times))).round().astype(int))
    several = len(flown.flights) > 1
    return Replay(
        revision=revision,
        log=log.name,
        line=line_of(forecast.frame, track.points[shown]),
        times=tuple(track.times[shown].round(2).tolist()),
        items=tuple(
            FlownItem(
                seq=leg.seq,
                estimated_s=round(leg.estimated_s, 1),
                flown_s=round(leg.flown_s, 1),
                done_s=round(leg.flown_done_s, 1),
            )
            for leg in held.legs
        ),
        estimated_s=round(held.estimated_total_s, 1),
        flown_s=round(held.flown_total_s, 1) if math.isfinite(held.flown_total_s) else None,
        remarks=(*flown.remarks, *([f"the first of {len(flown.flights)} flights in it"] if several else [])),
    )


@lru_cache(maxsize=2)
def _flights(log: str) -> FlightLog:
    return read_flights(Path(log))
