import math
import queue
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("pydantic")

from ipoa_mission import Forecast, read_mission
from ipoa_mission.link.messages import Gps, Message, Position, Text, WindEstimate, WindVelocity
from ipoa_mission.studio.flight_answers import Seen
from ipoa_mission.studio.flight_worker import Watch

MISSION = Path(__file__).parents[2] / "missions" / "sitl.plan"


@pytest.mark.parametrize(
    ("wind", "expected"),
    [
        (WindEstimate(-0.3, 3.04), (3.0, 0.0)),
        (WindEstimate(-90.0, 3.04), (3.0, 270.0)),  # ArduPilot says from where it blows, up to 180°
        (WindVelocity((-4.0, 0.0, 0.1)), (4.0, 0.0)),  # PX4: where the air goes
        (WindVelocity((0.0, 2.0, 0.0)), (2.0, 270.0)),
        (WindVelocity((math.nan, 0.0, 0.0)), None),
    ],
)
def test_wind_satellites_and_words_are_told_with_where_it_is(
    wind: Message, expected: tuple[float, float] | None
) -> None:
    forecast, heard = Forecast(read_mission(MISSION)), list[Any]()
    home = forecast.mission.home
    sample = SimpleNamespace(time_s=20.0, speed=1.0)
    record = SimpleNamespace(path=[sample], item_reached_s={0: 9.0})
    state = SimpleNamespace(armed=True, in_air=True, custom_mode=forecast.mission.autopilot.modes.mission)
    state.battery_left, state.current = 0.6, None
    vehicle: Any = SimpleNamespace(
        state=state,
        autopilot=forecast.mission.autopilot,
        order=SimpleNamespace(words="", is_held=False),
        changed="",
        link_loss=SimpleNamespace(seconds=None, words=""),
        mode_change="",
        conformance=SimpleNamespace(why_not="", deviations=(), positions=SimpleNamespace(words="")),
        record=lambda: record,
    )
    watch = Watch(forecast, vehicle, heard.append, None, queue.SimpleQueue())
    at = Position(20.0, home.latitude_deg, home.longitude_deg, home.altitude + 20.0, 20.0)
    for message in (Text(6, "Takeoff detected\t"), Text(4, "GPS glitch"), Gps(0.0, 0.0, 0.0, 0.0, 0.0), wind, at):
        watch.hear(message)
    seen = heard[-1]
    assert isinstance(seen, Seen)
    assert (seen.wind, seen.satellites, seen.said) == (expected, 12, ("GPS glitch", "Takeoff detected"))
    assert (seen.battery_left, seen.reserve) == (0.6, None)
