"""Check a flight in its scenario: clearances, battery, wind, and RTL and LAND at each second."""

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np
import shapely

import ipoa_mission.forecast.contingency.shortfalls as shortfalls
from ipoa_mission.autopilot.failsafe import Contingency, FlightStage
from ipoa_mission.checks.landings import check_ground, check_unread
from ipoa_mission.errors import MissionError, Remedy
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.forecast.contingency.contingencies import lands_by_choice, to_return_instead, who_lands
from ipoa_mission.forecast.contingency.contingency_paths import ContingencyPaths
from ipoa_mission.forecast.contingency.contingency_samples import GROUND, ReturnLeg
from ipoa_mission.forecast.contingency.energy_budget import RETURN_HINT, budget_of
from ipoa_mission.forecast.deviation.clearance_guarantee import ClearanceGuarantee, KeptLimit
from ipoa_mission.forecast.deviation.law import not_measured
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.leg_limits import ROUNDING, broken_limits
from ipoa_mission.geometry import place_words
from ipoa_mission.mission.item_words import name_items
from ipoa_mission.mission.items import Mission, item_of
from ipoa_mission.scenario import Scenario
from ipoa_mission.wind import CALM, Wind


def check_world(forecast: Forecast, is_flown: bool, before: Iterable[Finding]) -> list[Finding]:
    guarantee = forecast.guarantee_if_known if is_flown else None
    findings = [*_check_home(forecast), *check_airspace(forecast)]
    if guarantee is not None:
        judged = {finding.seq: finding.severity for finding in findings if finding.code == "leg-too-near"}
        for finding in check_clearance(forecast.mission, forecast.world, guarantee):
            if judged.get(finding.seq) not in (Severity.ERROR, finding.severity):  # else the leg's finding says it
                findings.append(finding)
    if uneven := forecast.over_uneven_terrain:
        words = f"{name_items(uneven)}: height over uneven terrain is not modeled; the clearance of flights is unknown"
        findings.append(Finding("terrain-clearance", Severity.WARNING, uneven[0], words))
    findings += (*check_unread(forecast.world.unread), *check_passed_over(forecast), *check_ground(forecast))
    if is_flown:
        findings += check_wind(forecast)
    if guarantee is not None:
        findings += check_energy(forecast)
        if not any(finding.severity is Severity.ERROR for finding in (*before, *findings)):
            findings += (*check_failsafe_return(forecast), *check_failsafe_landing(forecast))
    return findings


def remedy(forecast: Forecast) -> tuple[str, tuple[Remedy, ...]]:
    """Return a hint and changes of the scenario: the lowest return altitude, in steps of 5 m, with a clear way home."""
    advice = 'plan the way home too, with the goal over home and this one under via; or land: route.ending = "land"'
    mission = forecast.mission
    scenario = forecast.world
    by = mission.autopilot.parameter_table.by_meaning["return height"]
    is_clear = shortfalls.clear_in(scenario)
    land = Remedy(("route", "ending"), "land")
    for altitude in shortfalls.heights_above(0.0):
        if altitude > scenario.airspace.bounds.upper[2] - forecast.home[2]:
            break
        value = by.spelled(altitude)
        if is_clear(Forecast(mission.with_parameters({by.name: value}), scenario).ways_home):
            hint = f"{by.name} = {value:.0f} makes it clear, in the vehicle and under [vehicle.parameters]; or {advice}"
            return hint, (Remedy(("vehicle", "parameters", by.name), float(round(value))), land)
    return advice, (land,)


def _check_home(forecast: Forecast) -> Iterator[Finding]:
    away = float(np.linalg.norm(forecast.home))
    if away > 1.0:  # [m]
        message = f"home: lies {away:.1f} m from the scenario's home: heights above home count from the mission's"
        yield Finding("home-differs", Severity.WARNING, 0, message)


def check_airspace(forecast: Forecast) -> Iterator[Finding]:
    """Report each broken limit of each leg.

    The planner chooses no climb, way home or landing: there it is a warning, and contact an error.
    """
    scenario = forecast.world
    reported = set[str]()
    for leg in forecast.legs:
        for check in broken_limits(leg, scenario):
            words = check.words()
            begins = np.linalg.norm(np.array(check.nearest.place) - leg.points[0]) < ROUNDING["m"]
            if words in reported and begins:
                continue
            reported |= {words} if leg.stage is FlightStage.ROUTE else set()
            item = item_of(forecast.mission, leg.seq)
            message = f"{leg.name}: {words}"
            contact = scenario.vehicle.radius - ROUNDING["m"] if check.limit in ("obstacles", "ground") else -math.inf
            if leg.stage is not FlightStage.ROUTE and not check.nearest.distance < contact:
                yield item.warning("leg-too-near", message)
            else:
                hint, remedies = remedy(forecast) if leg.stage is FlightStage.RETURN else (None, ())
                yield item.error("leg-too-near", message, hint, remedies)


def check_clearance(mission: Mission, scenario: Scenario, guarantee: ClearanceGuarantee) -> Iterator[Finding]:
    """Report each limit that too few flights keep: a warning off the way or without room; contact is an error."""
    if guarantee.confidence is not None and (why := not_measured(mission.autopilot, scenario.wind.strongest)):
        yield Finding("wind-not-measured", Severity.WARNING, None, why)
    for limit in guarantee.broken:
        item = item_of(mission, limit.item)
        touches = limit.limit == "obstacles" and limit.guaranteed < scenario.vehicle.radius
        report = item.error if limit.forbids or touches else item.warning
        yield report("flights-too-near", f"{_where(limit)}: {limit.words(guarantee.confidence)}")


def _where(limit: KeptLimit) -> str:
    part = f"{limit.part}, " if limit.part else ""
    words = {"obstacles": f"to {limit.to}", "bounds": f"inside {limit.to}"}.get(limit.limit, "above the ground")
    return f"{part}{words} {place_words(limit.place)}"


def check_passed_over(forecast: Forecast) -> Iterator[Finding]:
    things = [each for each in forecast.world.passed_over if each.may_be_obstacle and not shapely.is_empty(each.shape)]
    for code in sorted({thing.code for thing in things}):
        yield from _near(forecast, [thing for thing in things if thing.code == code], code)


def _near(forecast: Forecast, things: Sequence[Any], code: str) -> Iterator[Finding]:
    scenario = forecast.world
    tree = shapely.STRtree([thing.shape for thing in things])
    required = scenario.limits.obstacle_distance + scenario.route.tolerance
    for leg in forecast.legs:
        line = shapely.LineString(leg.points[:, :2])
        near = [things[i] for i in tree.query(line, "dwithin", required + leg.chord_error)]
        if not near:
            continue
        distances = [float(shapely.distance(line, thing.shape)) for thing in near]
        distance = min(distances)
        nearest = near[distances.index(distance)]
        more_such = f" (and {len(near) - 1} more such)" if len(near) > 1 else ""
        where = f"passes {distance:.1f} m from" if distance > 0 else "crosses"
        words = f"{where} {nearest.name} on {nearest.file}, {nearest.reason}{more_such}"
        item = item_of(forecast.mission, leg.seq)
        sections = [n for n, section in enumerate(scenario.maps) if section.file.name == nearest.file]
        heights = tuple(Remedy(("maps", n, key), value) for key, value in nearest.heights for n in sections)
        if code == "not-read":
            yield item.error("not-read", words, nearest.remedy, heights)
        else:
            yield item.error("map-not-understood", words, nearest.remedy, heights)


def check_energy(forecast: Forecast) -> Iterator[Finding]:
    if forecast.world.vehicle.battery is None or not forecast.mission.items:
        return
    budget = budget_of(forecast)
    if budget is None or budget.battery is None:
        return
    battery = budget.battery
    short = budget.shortage
    if short is not None:
        seqs = (item.seq for item in budget.items if item.left is not None and item.left.likely < battery.reserve)
        seq = next(seqs, None)
        words = f"{short}" if seq is None else f"{short}; not enough from item {seq} on"
        yield Finding("battery-short", Severity.ERROR, seq, words, short.hint)
        return
    energy = budget.used.between
    if energy.high > battery.usable_wh:
        needs = f"the flight needs {energy.low:.0f} to {energy.high:.0f} Wh (nine flights in ten)"
        words = f"{needs}; the battery has {battery.usable_wh:.0f} Wh above its reserve"
        learned = forecast.mission.vehicle or forecast.world.vehicle.learned
        is_learned = learned is not None and learned.energy_ratio is not None
        advice = "`learn` narrows it from logs of the vehicle (--vehicle)"
        hint = None if is_learned else f"the energy is estimated from the airframe alone: {advice}"
        yield Finding("battery-unsure", Severity.WARNING, None, words, hint)
    late = budget.no_return
    if late is not None and budget.plans_returns:
        yield Finding("battery-no-return", Severity.ERROR, late.seq, str(late), RETURN_HINT)
    elif late is not None:
        yield Finding("battery-no-return", Severity.WARNING, late.seq, str(late))


def check_wind(forecast: Forecast) -> Iterator[Finding]:
    if not forecast.mission.items or not forecast.wind.strongest > 0:
        return
    for wind in dict.fromkeys((forecast.wind, forecast.wind.as_strong_as_may_be())):
        if (why := _why_not(forecast, wind)) is not None and _why_not(forecast, CALM) is None:
            words = f"in wind up to {wind.strongest:g} m/s: {why}"
            yield Finding("wind-too-strong", Severity.ERROR, None, words, "fly in less wind, slower, or another way")
            return


def _why_not(forecast: Forecast, wind: Wind) -> str | None:
    try:
        Forecast(forecast.mission_as_read, forecast.scenario, wind, forecast.left_out).predicted(noise_free=True)
    except MissionError as error:
        return str(error)
    return None


def check_failsafe_return(forecast: Forecast) -> Iterator[Finding]:
    paths = forecast.cached(ContingencyPaths)
    if not forecast.mission.items or len(paths.stops().times) < 2:
        return
    if (why := paths.why_unknown()) is not None:
        yield Finding("return-too-near", Severity.WARNING, None, f"RTL on the way was not checked: {why}")
        return
    samples = paths.samples(Contingency.RTL)
    begin, end = forecast.guarantee.flight.cruise_span
    checked = ~samples.clear & (samples.times >= begin) & (samples.times <= end)
    short = np.where(samples.possible[..., None] & checked[:, None, None], samples.near - paths.required, 0.0)
    braking = short[:, :, : ReturnLeg.RETURNS].min(axis=2, keepdims=True)
    returning = short[:, :, ReturnLeg.RETURNS :]  # a view
    returning[returning >= braking - 0.02] = 0.0  # [m], rounding: the fault is of the braking

    for legs, verb, order in (  # the descent is a leg of the mission
        (range(ReturnLeg.RETURNS), "brake or climb", "an RTL or pause"),
        (range(ReturnLeg.RETURNS, ReturnLeg.RETURNS + 1), "pass", "an RTL"),
    ):
        shortest = short[:, :, legs.start : legs.stop].min(axis=(1, 2))
        if (shortest < 0.0).any():
            seqs = np.unique(paths.stops().seqs_at(samples.times[shortest < 0.0]))
            worst = shortfalls.nearest_of_legs(paths, samples, int(np.argmin(shortest)), legs)
            words = f"{name_items(seqs.tolist())}: {order} ordered there would {verb} {worst.words()}"
            hint = _return_altitude_hint(paths) if legs.start == ReturnLeg.RETURNS else None
            yield Finding("return-too-near", Severity.WARNING, int(seqs[0]), words, hint)


def _return_altitude_hint(paths: ContingencyPaths) -> str | None:
    by = paths.mission.autopilot.parameter_table.by_meaning["return height"]
    short = list(shortfalls.find_shortfalls(paths, Contingency.RTL))
    higher, left = shortfalls.try_return_altitudes(paths, paths.forecast, short)[0]
    if any(shortfall.part >= ReturnLeg.RETURNS for shortfall in left):
        return None
    value = higher.mission_as_read.parameters[by.name]
    return f"{by.name} = {value:.0f} makes it clear, in the vehicle and under [vehicle.parameters]"


def check_failsafe_landing(forecast: Forecast) -> Iterator[Finding]:
    paths = forecast.cached(ContingencyPaths)
    if not forecast.mission.items or not lands_by_choice(forecast) or len(paths.stops().times) < 2:
        return
    samples = paths.samples(Contingency.LAND)
    unclear = np.flatnonzero(((samples.near < paths.required) & (samples.which != GROUND)).any(axis=(1, 2)))
    if len(unclear):
        seqs = np.unique(paths.stops().seqs_at(samples.times[unclear]))
        worst = unclear[np.argmin(samples.slack[unclear])]
        kept = shortfalls.nearest_of(paths, Contingency.LAND, samples, int(worst))
        words = f"{name_items(seqs.tolist())}: a LAND there, by {who_lands(forecast)}, would descend {kept.words()}"
        yield Finding("land-too-near", Severity.WARNING, int(seqs[0]), words, to_return_instead(forecast))
