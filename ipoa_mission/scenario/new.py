import json
import math
import os
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from pathlib import Path

import numpy as np
import shapely
from numpy.typing import NDArray

from ipoa_mission.autopilot.autopilot import registered
from ipoa_mission.errors import BadInput, NothingThere, TooFar, UnknownName
from ipoa_mission.maps.building_rules import BuildingRules
from ipoa_mission.maps.buildings import search_buildings
from ipoa_mission.maps.feature import Feature
from ipoa_mission.maps.geojson import Take
from ipoa_mission.maps.kinds import key_of_height
from ipoa_mission.maps.map_reader import hand_on_features
from ipoa_mission.scenario.profiles import PROFILES
from ipoa_mission.scenario.scenario_file import parse_scenario
from ipoa_mission.world.frame import REACH, Geodetic, LocalFrame, swap_hint

FREE_RADIUS = 12.0  # [m]
LARGEST_OFFSET = 200.0  # from the map's middle [m]
CANDIDATE_SPACING = 4.0  # [m]


@dataclass(frozen=True)
class Question:
    """A question; `default` None needs an answer. `check` raises BadInput, with `key` first."""

    key: str
    words: str
    form: str
    default: str | None
    check: Callable[[str, str], object]


def _place(key: str, answer: str) -> tuple[float, float]:
    numbers = re.findall(r"[-+]?\d+(?:\.\d+)?", answer)
    if re.fullmatch(r"\s*[-+]?\d+(\.\d+)?\s*[,; ]\s*[-+]?\d+(\.\d+)?\s*", answer):
        latitude, longitude = map(float, numbers)
        if abs(latitude) <= 90 and abs(longitude) <= 180:
            return latitude, longitude
    raise BadInput(f"expected latitude, longitude in degrees, such as 47.3977, 8.5456, not {answer!r}", place=key)


def _number(key: str, answer: str) -> float:
    if not re.fullmatch(r"\s*[-+]?\d+(\.\d+)?\s*", answer):
        raise BadInput(f"expected a number, not {answer!r}", place=key)
    return float(answer)


def _positive(key: str, answer: str) -> float:
    if not _number(key, answer) > 0:
        raise BadInput(f"expected a number greater than 0, not {answer}", place=key)
    return float(answer)


def _speed(key: str, answer: str) -> float:
    speed = _positive(key, answer)
    if why := max((one.book for one in registered()), key=lambda book: book.fastest).why_too_fast(speed, {}):
        raise BadInput(f"{why}", place=key)
    return speed


def _of_points(key: str, answer: str) -> float | None:
    return None if answer.strip() == "kind" else _positive(key, answer)


def _height(key: str, answer: str) -> float | None:
    if key == "line_height" and answer.strip() == "voltage":
        return None
    if not _number(key, answer) >= 0:
        raise BadInput(f"expected a number of at least 0, not {answer}", place=key)
    return float(answer)


def _one_of(*choices: str) -> Callable[[str, str], str]:
    def check(key: str, answer: str) -> str:
        if answer.strip() not in choices:
            raise BadInput(f"expected {', '.join(choices)}, not {answer!r}", place=key)
        return answer.strip()

    return check


AUTOPILOTS = tuple(map(str, registered()))
QUESTIONS = (
    Question("home", "Where does the vehicle take off?", "latitude, longitude", None, _place),
    Question("altitude", "How high is the ground there above mean sea level?", "metres", "0", _number),
    Question("goal", "Where does it fly to?", "latitude, longitude", None, _place),
    Question("height", "How high above the ground are start and goal?", "metres", "20", _positive),
    Question("autopilot", "Which autopilot flies it?", " or ".join(AUTOPILOTS), AUTOPILOTS[0], _one_of(*AUTOPILOTS)),
    Question("cruise_speed", "What is the cruise speed?", "metres per second", "8", _speed),
    Question("safety_distance", "What is the least distance of its hull to anything?", "metres", "2", _positive),
    Question(
        "ending", "How does the flight end?", "rtl (fly home) or land (at the goal)", "rtl", _one_of("rtl", "land")
    ),
    Question(
        "profile",
        "What is the task?",
        f"{', '.join(PROFILES)}, or none (balanced)",
        "none",
        _one_of(*PROFILES, "none"),
    ),
)

HEIGHTS = (
    Question("line_height", "How high are power lines?", "metres, 0: no obstacle, or voltage", "voltage", _height),
    Question("aerialway_height", "How high are cable cars and lifts?", "metres, 0: no obstacle", "40", _height),
    Question("wood_height", "How high are woods?", "metres, 0: no obstacle", "35", _height),
    Question("point_height", "How high are masts, trees and rows of trees?", "metres, or kind", "kind", _of_points),
)
_DEFAULTS_BY_KIND = {"voltage": "by their voltage", "kind": "by their kind"}
_COMMENTS = {
    "line_height": "of power lines; left out, by their voltage; 0: no obstacle [m]",
    "aerialway_height": "of cable cars and lifts; 0: no obstacle [m]",
    "wood_height": "of woods; left out, no flight may be near one; 0: no obstacle [m]",
    "point_height": "of masts, trees and rows of trees; left out, by their kind [m]",
}


def questions_about(buildings: Path | None) -> tuple[Question, ...]:
    """Return the `HEIGHTS` left open. Raises BadInput."""
    if buildings is None:
        return ()
    return tuple(question for question in HEIGHTS if question.key in _content_of(buildings).left_open)


def taken_heights(answers: Mapping[str, str], buildings: Path | None) -> tuple[str, ...]:
    left = (question for question in questions_about(buildings) if question.key not in answers)
    things = {key: words.split(";")[0].removesuffix(" [m]").removeprefix("of ") for key, words in _COMMENTS.items()}
    return tuple(
        f"without a height on the map: {things[question.key]}, "
        f"taken {_DEFAULTS_BY_KIND.get(str(question.default), f'as {question.default} m high')} "
        f"({question.key})"
        for question in left
    )


@dataclass
class _MapContent:
    """Number of features, west, south, east, north [deg], and open heights."""

    features: int
    box: NDArray[np.float64]
    left_open: set[str]

    def add(self, features: Sequence[Feature]) -> None:
        here = shapely.total_bounds([feature.shape for feature in features])
        self.features += len(features)
        self.box = np.concatenate([np.fmin(self.box[:2], here[:2]), np.fmax(self.box[2:], here[2:])])
        self.left_open |= {key for feature in features if (key := key_of_height(feature))}


@lru_cache(maxsize=1)
def _content_of(path: Path) -> _MapContent:
    content = _MapContent(0, np.full(4, np.nan), set())

    def begin() -> Take:
        nonlocal content
        content = _MapContent(0, np.full(4, np.nan), set())
        return content.add

    hand_on_features(path, begin)
    return content


def new_scenario(
    answers: Mapping[str, str], target: Path, buildings: Path | None = None, elevation: Path | None = None
) -> str:
    """Return a scenario file with paths relative to `target`. Raises BadInput.

    `answers`: by the keys of `QUESTIONS` and `questions_about`; an elevation model answers home's altitude.
    """
    of_map = questions_about(buildings)
    questions = {question.key: question for question in (*QUESTIONS, *of_map)}
    for key in answers.keys() - questions.keys():
        raise UnknownName(f"expected one of {', '.join(questions)}", place=key)
    given = {key: answers.get(key, question.default) for key, question in questions.items()}
    for key, answer in given.items():
        if answer is None:
            raise BadInput("expected, but not there", code="missing", place=key)
        questions[key].check(key, answer)
    texts = {key: answer.strip() for key, answer in given.items() if answer is not None}
    home, goal = _place("home", texts["home"]), _place("goal", texts["goal"])
    if "safety_distance" not in answers:
        texts["safety_distance"] = str(
            PROFILES.get(texts["profile"], {}).get("safety_distance", texts["safety_distance"])
        )
    if elevation is not None and "altitude" not in answers:
        texts["altitude"] = suggest_altitude(elevation, texts["home"])
    parts = _parts()
    text = (
        parts["template"]
        .rstrip()
        .format(
            title=f"Flight from {home[0]:g}, {home[1]:g} to {goal[0]:g}, {goal[1]:g}.",
            profile=f'profile = "{texts["profile"]}"' if texts["profile"] != "none" else '# profile = "rescue"',
            home=home,
            goal=goal,
            terrain=parts["flat"] if elevation is None else parts["elevation"].format(_quoted(elevation, target)),
            maps=parts["no_maps"]
            if buildings is None
            else parts["buildings"].format(
                _quoted(buildings, target), "\n".join(_height_line(question.key, texts) for question in of_map)
            ),
            **{
                key: texts[key]
                for key in ("altitude", "height", "autopilot", "cruise_speed", "safety_distance", "ending")
            },
        )
    )
    text = _aligned(text)
    parse_scenario(text, target)
    return text


def _height_line(key: str, texts: Mapping[str, str]) -> str:
    return (
        f"# {key} = 30.0  # {_COMMENTS[key]}"
        if texts[key] in _DEFAULTS_BY_KIND
        else f"{key} = {texts[key]}  # {_COMMENTS[key]}"
    )


def _parts() -> dict[str, str]:
    template = files("ipoa_mission.scenario").joinpath("new.toml.template").read_text(encoding="utf-8")
    return dict(re.findall(r"^%% (\w+)\n(.*?)(?=^%%|\Z)", template, re.MULTILINE | re.DOTALL))


def check_goal(answers: Mapping[str, str]) -> None:
    """Refuse a goal far from home: often degrees are swapped. Raises BadInput."""
    if "home" in answers and "goal" in answers:
        home, goal = _place("home", answers["home"]), _place("goal", answers["goal"])
        east, north, _ = LocalFrame(Geodetic(*home)).local(Geodetic(*goal))
        if not math.hypot(east, north) <= REACH:
            why = swap_hint(Geodetic(*home), Geodetic(*goal), "goal")
            raise TooFar(f"expected a place within {REACH / 1000:g} km of home, {answers['home']}{why}", place="goal")


def suggest_answers(buildings: Path | None = None) -> dict[str, str]:
    """Suggest free places for home and goal. Raises BadInput."""
    if buildings is None:
        return {}
    return {
        key: f"{place[0]:.7f}, {place[1]:.7f}"
        for key, place in zip(("home", "goal"), _free_places(buildings), strict=True)
    }


def suggest_altitude(elevation: Path, home: str) -> str:
    """Raises BadInput."""
    from ipoa_mission.maps.elevation import ground_altitude  # slow import

    return f"{ground_altitude(elevation, *_place('home', home)):.1f}"


def _free_places(path: Path) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return places south-west and north-east [deg]."""
    content = _content_of(path)
    if not content.features:
        raise NothingThere("expected buildings, but it has no features", place=path)
    west, south, east, north = content.box.tolist()
    frame = LocalFrame(Geodetic((south + north) / 2, (west + east) / 2))
    within = np.full(2, -LARGEST_OFFSET - 2 * FREE_RADIUS), np.full(2, LARGEST_OFFSET + 2 * FREE_RADIUS)
    found = search_buildings(path, BuildingRules(), frame, within)
    if not found.standing:
        found = search_buildings(path, BuildingRules(take="all"), frame, within)
    if not found.standing:
        raise NothingThere(f"expected buildings, but none of {found.features} features is an obstacle", place=path)
    shapes = [s.shape.buffer(s.reach) if s.reach else s.shape for s in found.standing]
    reach = np.minimum(np.ptp(found.box.reshape(2, 2), axis=0) / 2 + 2 * FREE_RADIUS, LARGEST_OFFSET)
    sides = [np.arange(-each, each + CANDIDATE_SPACING, CANDIDATE_SPACING) for each in reach]
    places = np.stack(np.meshgrid(*sides), axis=-1).reshape(-1, 2)
    in_doubt = [thing.shape for thing in found.passed_over if thing.may_stand and not shapely.is_empty(thing.shape)]
    near = shapely.STRtree([*shapes, *in_doubt]).query(shapely.points(places), "dwithin", FREE_RADIUS)[0]
    free = np.delete(places, np.unique(near), axis=0)
    if len(free) < 2:
        raise BadInput(f"expected {FREE_RADIUS:g} m of free room for a take-off among the buildings", place=path)
    ends = [free[np.argmin(np.linalg.norm(free - corner, axis=1))] for corner in (-0.8 * reach, 0.8 * reach)]
    latitude, longitude, _ = frame.to_geodetic(np.column_stack([ends, np.zeros(2)]))
    return (float(latitude[0]), float(longitude[0])), (float(latitude[1]), float(longitude[1]))


def _quoted(path: Path, target: Path) -> str:
    return json.dumps(Path(os.path.relpath(path, target.parent)).as_posix(), ensure_ascii=False)


def _aligned(text: str) -> str:
    return re.sub(r"^(\S.*?) {2,}(# .*)$", lambda match: f"{match[1]:<32} {match[2]}", text, flags=re.MULTILINE)
