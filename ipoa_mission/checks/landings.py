"""Check the ground at home, landings, and content of files that was not read."""

from collections.abc import Iterable, Iterator

from ipoa_mission.autopilot.parameters import name_values
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.leg_limits import above_or_below, landings
from ipoa_mission.mission.items import item_of
from ipoa_mission.unread import Unread


def check_ground(forecast: Forecast) -> Iterator[Finding]:
    at_home = forecast.ground_at_home
    if abs(at_home) > 0.5:  # [m]
        whose = "the altitude of the mission's home" if forecast.home.any() else "home.altitude_amsl"
        yield Finding(
            "home-not-on-ground",
            Severity.WARNING,
            0,
            f"home: the ground there is {above_or_below(at_home)} home's altitude: a vehicle measures heights from "
            f"its take-off, and flies {abs(at_home):.1f} m {'higher' if at_home > 0 else 'lower'} than planned",
            f"set {whose} = {forecast.mission.home.altitude + at_home:.1f}",
        )
    yield from check_landings(forecast)


def check_landings(forecast: Forecast) -> Iterator[Finding]:
    mission = forecast.mission
    stretch = mission.autopilot.slow_stretch(mission.parameters)
    if stretch is None:
        return
    for landing in landings(forecast):
        if stretch.is_fast(landing.assumed_height):
            wanted = name_values(mission.autopilot.slowed(mission.parameters, landing.assumed_height))
            hint = f"{wanted} in the vehicle and under [vehicle.parameters] would slow it down in time"
            message = f"{landing.where}: {landing.touches_down(stretch)}"
            yield item_of(mission, landing.seq).warning("fast-touchdown", message, hint)
        elif landing.height < -5.0:  # [m]
            descent = stretch.ends - landing.height
            slowly = f"flown at {stretch.landing:.1f} m/s and take {descent / stretch.landing:.0f} s"
            message = f"{landing.where}: without a rangefinder the last {descent:.0f} m are {slowly}"
            hint = "a rangefinder, or a waypoint low over that place with its altitude above terrain, shortens it"
            yield item_of(mission, landing.seq).warning("slow-landing", message, hint)


def check_unread(things: Iterable[Unread]) -> Iterator[Finding]:
    ignored = 'if it limits no flight: --ignore not-read, or [safety] ignore = ["not-read"]'
    for thing in things:
        if thing.may_limit:
            hint = "; ".join(filter(None, (thing.remedy, ignored)))
            yield Finding("not-read", Severity.ERROR, None, thing.words, hint)
