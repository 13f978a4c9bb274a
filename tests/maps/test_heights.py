import pytest

from ipoa_mission.errors import BadInput
from ipoa_mission.maps.lengths import length_of, meters
from ipoa_mission.maps.tag_heights import foot_of, height_of

#: From the wiki's page on `height`, and exports [m].
LENGTHS = {
    "23": 23.0,
    "23 m": 23.0,
    "23m": 23.0,
    "4.5": 4.5,
    "4,5": 4.5,
    ".5": 0.5,
    "~20": 20.0,
    "75 ft": 22.86,
    "75ft": 22.86,
    "7'": 2.1336,
    "7'4\"": 2.2352,
    "7 ft 4 in": 2.2352,
    "12;15 m": 15.0,
    "23 Metres": 23.0,
    "12-15": 15.0,
    "12 – 15 m": 15.0,
    "3 m-4 m": 4.0,
    "approx 12": 12.0,
    "ca. 12 m": 12.0,
    "1e2": 100.0,
    "1.5e1": 15.0,
    "22.": 22.0,
    "22+": 22.0,
    "60 m (AGL)": 60.0,
    "866 in": 21.9964,
    "1,200": 1200.0,
    "1.200,5": 1200.5,
    "1 234": 1234.0,
    "12 yd": 10.9728,
    "12 km": 12_000.0,
    "0.022 km": 22.0,
    "1800 cm": 18.0,
    "22 meters (roof)": 22.0,
    "22.5m approx": 22.5,
    "+22": 22.0,
    "100 ft (30 m)": 30.48,
    "6'2": 1.8796,
    "30 +/- 2 m": 32.0,
    "12 m + 8 m antenna": 20.0,
    "30 ft plus 10 ft": 12.192,
    "20 m with 5 m mast": 25.0,
    "5 ft and 6 in": 1.6764,
    "12..15": 15.0,
    "> 60": 60.0,
    "5 m 30 cm": 5.3,
    "1'200 m": 1200.0,
    "1\u202f200\u00a0m": 1200.0,
}
HALF_READ = {
    "1/2 m": 2.0, "12.5.3": 12.5, "5 m 30": 30.0, "5m30": 30.0, "5 30": 30.0, "10/12": 12.0, "5'11 1/2\"": 1.8034,
    "1.000.000": 1.0, "12,5,3": 12.5, "10 m2": 10.0, "6'13": 2.159, "30 m 100 ft": 60.48,
}  # fmt: skip
NO_LENGTHS = [*HALF_READ, "tall", "", "-3", "-5-3", "3 storeys", "nan", "inf", "3e400", "12;tall", "²", "1-" * 99]


@pytest.mark.parametrize(("text", "expected"), LENGTHS.items(), ids=LENGTHS)
def test_a_length_is_read_in_meters(text: str, expected: float) -> None:
    assert meters(text, "here") == pytest.approx(expected)


@pytest.mark.parametrize(("text", "greatest"), HALF_READ.items(), ids=HALF_READ)
def test_a_length_read_in_part_is_in_doubt(text: str, greatest: float) -> None:
    length, sure = length_of(text)
    assert (length, sure) == (pytest.approx(greatest), False)


@pytest.mark.parametrize("tags", [{"height": "12.5.3 floors"}, {"building:levels": "10-1/2"}, {"height": "5 m 30"}])
def test_a_height_read_in_part_is_named(tags: dict[str, str]) -> None:
    named: list[tuple[str, str]] = []
    height_of(tags, "height", 3.0, lambda *odd: named.append(odd))
    assert named == [*tags.items()]


@pytest.mark.parametrize(("text", "height"), [("1,2", 1200.0), ("~0.5", 500.0), ("30 m", 30.0)])
def test_a_unit_in_the_key_counts_for_every_number_without_one(text: str, height: float) -> None:
    assert height_of({"height_km": text}, "height", 3.0, fail) == height


@pytest.mark.parametrize("text", NO_LENGTHS)
def test_wrong_lengths_are_refused_with_their_place(text: str) -> None:
    with pytest.raises(BadInput) as caught:
        meters(text, "map.geojson: features[3].properties.height")
    assert str(caught.value) == (
        f'map.geojson: features[3].properties.height: expected meters or feet ("23", "23 m", "75 ft"), not {text!r}'
    )


@pytest.mark.parametrize(
    ("tags", "expected"),
    [
        ({"height": "23", "building:levels": "2"}, 23.0),
        ({"height": "12 stories"}, 36.0),
        ({"height": "about 2 floors"}, 6.0),
        ({"building:levels": "5"}, 15.0),
        ({"building:levels": "5", "roof:levels": "1"}, 18.0),
        ({"building:levels": "5", "roof:levels": "1", "roof:height": "4.5"}, 19.5),
        ({"building:levels": "2.5;3"}, 9.0),
        ({"building:levels": "0"}, None),
        ({"building": "yes"}, None),
    ],
)
def test_a_building_is_as_high_as_its_tags_say(tags: dict[str, str], expected: float | None) -> None:
    assert height_of(tags, "height", 3.0, fail) == expected


def test_another_property_may_hold_the_height() -> None:
    assert height_of({"h_mean": "12.5", "height": "99"}, "h_mean", 3.0, fail) == 12.5


@pytest.mark.parametrize("text", ["0", "0 m", "-5", "tall", ""])
def test_wrong_heights_are_remarked_and_left_out(text: str) -> None:
    skipped: list[tuple[str, str]] = []
    tags = {"height": text, "building:levels": "4", "roof:height": "?", "roof:levels": "1"}
    assert height_of(tags, "height", 3.0, lambda *odd: skipped.append(odd)) == 15.0
    assert skipped == [("height", text), ("roof:height", "?")]


@pytest.mark.parametrize(
    ("tags", "expected"),
    [({"min_height": "6 m"}, 6.0), ({"building:min_level": "2"}, 6.0), ({"min_height": "-2"}, 0.0), ({}, 0.0)],
)
def test_bridges_begin_above_their_street(tags: dict[str, str], expected: float) -> None:
    assert foot_of(tags, 3.0, fail) == expected


def fail(key: str, value: str) -> None:
    pytest.fail(f"{key} {value!r} is a height")
