from ipoa_mission.checks.landings import check_unread
from ipoa_mission.finding import Severity
from ipoa_mission.unread import Unread, gathered, unread_as_json

TAGS = [Unread("town.shp", 'tag "hgt"', f"row[{n}]", example) for n, example in ((4, "12"), (7, "13"), (9, "2"))]
LINK = Unread("zones.kml", "NetworkLink", "Placemark[0]", may_limit=True, remedy="save what it shows")


def test_each_kind_is_listed_once_with_count_place_and_example() -> None:
    first, second = gathered([*TAGS, LINK])
    assert first == LINK
    assert (second.count, second.place, second.example) == (3, "row[4]", "12")
    assert second.words == 'town.shp: not read: tag "hgt": 3 times, first row[4] ("12")'
    assert unread_as_json([second])[0]["count"] == 3


def test_only_what_may_limit_the_flight_is_an_error() -> None:
    (finding,) = check_unread([*TAGS, LINK])
    assert (finding.code, finding.severity) == ("not-read", Severity.ERROR)
    assert finding.hint == (
        'save what it shows; if it limits no flight: --ignore not-read, or [safety] ignore = ["not-read"]'
    )
    assert finding.message == "zones.kml: not read: NetworkLink: Placemark[0]"
