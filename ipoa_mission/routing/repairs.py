"""Repair a mission that would fail a check."""

from collections.abc import Iterator
from dataclasses import replace

from ipoa_mission.autopilot.commands import Command
from ipoa_mission.autopilot.failsafe import FlightStage
from ipoa_mission.autopilot.parameters import name_values
from ipoa_mission.autopilot.returning import HEIGHT_UNCERTAINTY
from ipoa_mission.errors import Unsafe
from ipoa_mission.forecast.contingency.shortfalls import clear_in, heights_above
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.leg_limits import landings
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import Mission, waypoint
from ipoa_mission.planning.proof import prove
from ipoa_mission.scenario import Scenario


def slow_landings(mission: Mission, scenario: Scenario) -> Mission:
    """Return the mission with parameters, if the scenario names none, for slow landings; raise Unsafe if none help."""
    stretch = mission.autopilot.slow_stretch(mission.parameters)
    names = mission.autopilot.slowed_by.names
    named = mission.autopilot.parameter_table.by_old_names(mission.parameters)
    if stretch is None or not named.keys().isdisjoint(names):
        return mission
    highest = max(landings(Forecast(mission, scenario)), key=lambda landing: landing.assumed_height, default=None)
    if highest is None or not stretch.is_fast(highest.assumed_height + HEIGHT_UNCERTAINTY):
        return mission
    parameters = {**mission.parameters, **mission.autopilot.slowed(mission.parameters, highest.assumed_height)}
    most = mission.autopilot.slowed_by.most
    slowed = mission.autopilot.slow_stretch(parameters)
    if slowed is not None and slowed.is_fast(highest.assumed_height):
        raise Unsafe(
            f"{highest.words}, and {' and '.join(names)} count up to {most:.0f} m above home: "
            f"{highest.touches_down(slowed)}",
            hint=f"land elsewhere, descend no faster than {slowed.landing:g} m/s (vehicle.descent_speed), or name "
            f"{' or '.join(filter(None, (mission.autopilot.slowed_by.spared_by, names[0])))} under "
            "[vehicle.parameters], on your own responsibility",
            code="fast-touchdown",
        )
    return replace(mission, parameters=parameters)


def slow_landings_remarks(forecast: Forecast) -> Iterator[str]:
    mission, scenario = forecast.mission, forecast.world
    named = scenario.vehicle.autopilot_parameters()
    slowing = mission.autopilot.slowed_by.names
    wanted = {name: mission.parameters[name] for name in slowing if name in mission.parameters and name not in named}
    if wanted:
        highest = max(landings(forecast), key=lambda landing: landing.assumed_height)
        yield (
            f"{highest.words}: {name_values(wanted)} in the vehicle makes LAND slow down at the usual height "
            f"above that ground ({scenario.name}.params; `fly --set-params` writes it)"
        )


def raise_way_home(mission: Mission, scenario: Scenario) -> Mission:
    """Return the mission with a waypoint high over its last place, if that makes a blocked way home clear.

    A preceding spline waypoint gets a hold of 1 s: without it ArduCopter's curve dips.
    """
    if mission.items[-1].command != Command.NAV_RETURN_TO_LAUNCH:
        return mission
    is_clear = clear_in(scenario)
    if is_clear(Forecast(mission, scenario).ways_home):
        return mission
    last = mission.items[-2]
    stopped = replace(last, params=(1.0, *last.params[1:])) if last.command == Command.NAV_SPLINE_WAYPOINT else last
    above = Geodetic(last.latitude_deg, last.longitude_deg, mission.home.altitude)
    for height in heights_above(mission.altitude_above_home(last)):
        climb = waypoint(above, height, *mission.autopilot.waypoint_defaults(mission.firmware_version))
        raised = replace(mission, items=(*mission.items[:-2], stopped, climb, mission.items[-1]))
        legs = Forecast(raised, scenario).legs
        climb_leg, *returns = (leg for leg in legs if leg.seq == len(mission.items) or leg.stage is FlightStage.RETURN)
        if any(check.slack < 0 for check in prove(climb_leg.points, scenario).checks if check.limit != "climb"):
            return mission
        if is_clear(returns):
            return raised
    return mission


def raise_way_home_remarks(mission: Mission) -> Iterator[str]:
    match mission.items:
        case (*_, before, last, end) if end.command == Command.NAV_RETURN_TO_LAUNCH:
            there = (last.latitude_deg, last.longitude_deg) == (before.latitude_deg, before.longitude_deg)
            if there and last.altitude > before.altitude:
                seq = len(mission.items) - 1
                yield f"item {seq}: climbs to {last.altitude:.0f} m over the goal, for a clear way home"
