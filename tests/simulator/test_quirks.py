"""ArduCopter 4.7's and PX4 1.17's measured answers, row by row."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.link.codec import Target
from ipoa_mission.link.messages import (
    Ack,
    ClearAll,
    Count,
    ItemAt,
    Message,
    MissionType,
    Request,
    RequestList,
    Result,
    Text,
    WritePartialList,
)
from ipoa_mission.mission.items import Item, land
from tests.link_pair import CLIENT, HOME, STRANGER, Vehicle, items_of, plain

ARDUPILOT, PX4 = Autopilot.ARDUPILOT, Autopilot.PX4
WAYPOINT = Item(16, 3, (0.0, 0.0, 0.0, 0.0), 47.4, 8.5, 30.0)
CIRCLE = Item(5003, 3, (100.0, 0.0, 0.0, 0.0), 47.4, 8.5, 0.0)
RALLY = Item(5100, 3, (0.0,) * 4, 47.4, 8.5, 20.0)
OK, NAN, INF = Result.ACCEPTED, math.nan, math.inf
FENCE = MissionType.FENCE


def vehicle(autopilot: Autopilot, old: int = 0) -> Vehicle:
    mock = Vehicle(autopilot)
    mock.store(items_of(autopilot, old, shift=0.01))
    return mock


def begun(autopilot: Autopilot, count: int = 3, received: int = 0, old: int = 0) -> Vehicle:
    mock = vehicle(autopilot, old)
    mock.hear(Count(count))
    for seq in range(received):
        mock.hear(ItemAt(seq, items_of(autopilot, count)[seq]))
    return mock


def begun_list(autopilot: Autopilot, kind: int, old: Sequence[Item]) -> Vehicle:
    mock = Vehicle(autopilot)
    mock.store(tuple(old), kind)
    return mock


# --- single items ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class ItemRow:
    """The second item of a mission, and the result that ends or continues the transfer."""

    autopilot: Autopilot
    name: str
    item: Item
    result: int


def having(**changes: object) -> Item:
    return replace(WAYPOINT, **changes)  # type: ignore[arg-type]


def params(n: int, value: float, command: int = 16) -> Item:
    return replace(WAYPOINT, command=command, params=tuple(value if i == n else 0.0 for i in range(4)))  # type: ignore[arg-type]


ITEM_ROWS = [
    ItemRow(ARDUPILOT, "bad latitude", having(latitude_deg=95.0), Result.INVALID_PARAM5_X),
    ItemRow(ARDUPILOT, "bad longitude", having(longitude_deg=200.0), Result.INVALID_PARAM6_Y),
    ItemRow(ARDUPILOT, "altitude NaN", having(altitude=NAN), Result.INVALID_PARAM7),
    ItemRow(ARDUPILOT, "altitude inf", having(altitude=INF), Result.INVALID_PARAM7),
    ItemRow(ARDUPILOT, "altitude 83 km", having(altitude=83_000.0), Result.INVALID_PARAM7),
    ItemRow(ARDUPILOT, "altitude -500", having(altitude=-500.0), OK),
    ItemRow(ARDUPILOT, "position (0, 0)", having(latitude_deg=0.0, longitude_deg=0.0), OK),
    *[ItemRow(ARDUPILOT, f"NaN in param{n + 1}", params(n, NAN), 6 + n) for n in range(3)],
    *[ItemRow(ARDUPILOT, f"inf in param{n + 1}", params(n, INF), 6 + n) for n in (3,)],
    *[ItemRow(ARDUPILOT, f"NaN in param4 of {c}", params(3, NAN, c), OK) for c in (16, 17, 21, 22)],
    ItemRow(ARDUPILOT, "NaN in param4 of LOITER_TIME", params(3, NAN, 19), Result.INVALID_PARAM4),
    *[ItemRow(ARDUPILOT, f"frame {f}", having(frame=f), 2) for f in (1, 4, 7, 8, 9, 12, 20, 99)],
    *[ItemRow(ARDUPILOT, f"frame {f}", having(frame=f), OK) for f in (0, 2, 3, 5, 6, 10, 11)],
    *[ItemRow(ARDUPILOT, f"command {c}", having(command=c), Result.INVALID) for c in (0, 1)],
    ItemRow(ARDUPILOT, "unknown command", having(command=31000), Result.UNSUPPORTED),
    *[ItemRow(ARDUPILOT, f"DO_JUMP to {t}", params(0, t, 177), Result.ERROR) for t in (0.0, -1.0, 3.0)],
    ItemRow(ARDUPILOT, "DO_JUMP to an item", params(0, 1.0, 177), OK),
    ItemRow(ARDUPILOT, "a spline", having(command=82), OK),
    ItemRow(ARDUPILOT, "RETURN_TO_LAUNCH in a global frame", having(command=20), OK),
    ItemRow(PX4, "latitude 95", having(latitude_deg=95.0), OK),
    ItemRow(PX4, "longitude 200", having(longitude_deg=200.0), OK),
    ItemRow(PX4, "position (0, 0)", having(latitude_deg=0.0, longitude_deg=0.0), OK),
    *[ItemRow(PX4, f"altitude {a}", having(altitude=a), OK) for a in (NAN, INF, -100.0)],
    ItemRow(PX4, "hold NaN", params(0, NAN), OK),
    *[ItemRow(PX4, f"command {c}", having(command=c), Result.UNSUPPORTED) for c in (31000, 18, 82, 115)],
    *[ItemRow(PX4, f"command {c} in a global frame", having(command=c), 3) for c in (20, 178, 93)],
    *[ItemRow(PX4, f"command {c} in frame 2", having(command=c, frame=2), OK) for c in (20, 178, 93)],
    ItemRow(PX4, "WAYPOINT in frame 2", having(frame=2), Result.UNSUPPORTED),
    *[ItemRow(PX4, f"frame {f}", having(frame=f), Result.UNSUPPORTED_FRAME) for f in (1, 10, 99)],
    ItemRow(PX4, "a fence in the mission", CIRCLE, Result.ERROR),
    ItemRow(PX4, "a rally point in the mission", RALLY, Result.ERROR),
]


@pytest.mark.parametrize("row", ITEM_ROWS, ids=lambda row: f"{row.autopilot}: {row.name}")
def test_an_item_gets_the_measured_result(row: ItemRow) -> None:
    mock = begun(row.autopilot, received=1)
    answer = mock.hear(ItemAt(1, row.item))
    if row.result == OK:
        assert answer == [Request(2, legacy=row.autopilot is ARDUPILOT)]
    else:
        assert answer[0] == Ack(row.result)
        assert mock.wait(60.0) == []  # and the transfer is over


# --- conversations --------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Row:
    """Messages to a vehicle in some state, and its answer; words (STATUSTEXT) by their content."""

    name: str
    vehicle: Vehicle
    answers: Sequence[Message]
    answer: Sequence[Message | str]
    source: Target = CLIENT
    after: int | None = None  # items in the store
    kind: int = MissionType.MISSION  # of that store


def conversation_rows() -> list[Row]:
    def a(seq: int, kind: int = 0) -> Request:
        return Request(seq, kind, legacy=True)

    ap, px = items_of(ARDUPILOT, 5), items_of(PX4, 5)
    booting = Vehicle(ARDUPILOT)
    booting.transfers.booted = False
    return [
        # ArduCopter
        Row("ardupilot: NO_SPACE until its start-up ends", booting, [Count(3)], [Ack(Result.NO_SPACE)]),
        Row("ardupilot: asks with the old MISSION_REQUEST", vehicle(ARDUPILOT), [Count(3)], [a(0)]),
        Row("ardupilot: COUNT 0 clears", vehicle(ARDUPILOT, 4), [Count(0)], [Ack(OK)], after=0),
        Row("ardupilot: 651 items", vehicle(ARDUPILOT), [Count(651)], [Ack(Result.NO_SPACE), "Only 650 items"]),
        Row("ardupilot: 650 items", vehicle(ARDUPILOT), [Count(650)], [a(0)]),
        Row("ardupilot: 71 fence", vehicle(ARDUPILOT), [Count(71, 1)], [Ack(4, 1), "Only 70 items are supported"]),
        Row("ardupilot: 47 rally", vehicle(ARDUPILOT), [Count(47, 2)], [Ack(4, 2), "Only 46 items are supported"]),
        Row("ardupilot: COUNT truncates at once", vehicle(ARDUPILOT, 5), [Count(2)], [a(0)], after=2),
        Row("ardupilot: a NAK leaves a mixture", begun(ARDUPILOT, 5, 3, old=5), [ItemAt(3, having(command=0))],
            [Ack(Result.INVALID)], after=5),
        Row("ardupilot: a stray item is rebuked and it goes on", begun(ARDUPILOT, 3, 1), [ItemAt(2, ap[2])],
            [Ack(Result.INVALID_SEQUENCE)]),
        Row("ardupilot: so is a duplicate", begun(ARDUPILOT, 3, 1), [ItemAt(0, ap[0]), ItemAt(1, ap[1])],
            [Ack(Result.INVALID_SEQUENCE), a(2)]),
        Row("ardupilot: a cancel is ignored", begun(ARDUPILOT, 3, 1), [Ack(15), ItemAt(1, ap[1])], [a(2)]),
        Row("ardupilot: a new COUNT ends an upload", begun(ARDUPILOT, 3, 2), [Count(4)], [a(0)]),
        Row("ardupilot: CLEAR_ALL ends an upload", begun(ARDUPILOT, 3, 2), [ClearAll()], [Ack(OK)], after=0),
        Row("ardupilot: reading in mid-upload", begun(ARDUPILOT, 3, 1), [RequestList(), Request(0)],
            [Ack(Result.DENIED), Ack(Result.DENIED)]),
        Row("ardupilot: COUNT of another in mid-upload", begun(ARDUPILOT, 3, 1), [Count(2)], [Ack(Result.DENIED)],
            source=STRANGER),
        Row("ardupilot: the fence keeps its old items till the end", begun(ARDUPILOT), [Count(1, 1)], [a(0, 1)]),
        Row("ardupilot: item 0 is validated", begun(ARDUPILOT, 3), [ItemAt(0, having(latitude_deg=95.0))],
            [Ack(Result.INVALID_PARAM5_X)]),
        Row("ardupilot: the final ack is said once", begun(ARDUPILOT, 3, 3), [ItemAt(2, ap[2])], [Ack(Result.ERROR)]),
        Row("ardupilot: a NAK leaves the fence as it was", begun_list(ARDUPILOT, FENCE, [CIRCLE, CIRCLE]),
            [Count(1, 1), ItemAt(0, WAYPOINT, 1)], [a(0, 1), Ack(Result.UNSUPPORTED, 1)], after=2, kind=FENCE),
        Row("ardupilot: and the rally points not", begun_list(ARDUPILOT, MissionType.RALLY, [RALLY, RALLY]),
            [Count(1, 2), ItemAt(0, WAYPOINT, 2)], [a(0, 2), Ack(Result.UNSUPPORTED, 2)], after=1, kind=2),
        Row("ardupilot: items are given without a list", vehicle(ARDUPILOT, 3), [Request(9)],
            [Count(3), Ack(Result.INVALID_SEQUENCE)]),
        # PX4
        Row("px4: asks with MISSION_REQUEST_INT", vehicle(PX4), [Count(3)], [Request(0)]),
        Row("px4: COUNT 0 clears", vehicle(PX4, 4), [Count(0)], [Ack(OK)], after=0),
        Row("px4: 10001 items", vehicle(PX4), [Count(10001)], [Ack(Result.NO_SPACE), "Only 10000"]),
        Row("px4: 65 fence", vehicle(PX4), [Count(65, 1)], [Ack(4, 1), "Only 64"]),
        Row("px4: 33 rally", vehicle(PX4), [Count(33, 2)], [Ack(4, 2), "Only 32"]),
        Row("px4: an upload is atomic", begun(PX4, 5, 3, old=4), [ItemAt(3, having(command=82))],
            [Ack(Result.UNSUPPORTED)], after=4),
        Row("px4: a stray item is ignored", begun(PX4, 3, 1), [ItemAt(2, px[2]), ItemAt(0, px[0])], []),
        Row("px4: a duplicate of the last item is accepted again", begun(PX4, 3, 3), [ItemAt(2, items_of(PX4, 3)[2])],
            [Ack(OK)]),
        Row("px4: but not one of another", begun(PX4, 3, 3), [ItemAt(1, px[1])], []),
        Row("px4: a second COUNT gets ERROR and it goes on", begun(PX4, 3, 1), [Count(3), ItemAt(1, px[1])],
            [Ack(Result.ERROR), Request(2)]),
        Row("px4: a second client gets ERROR", begun(PX4, 3, 1), [Count(2)], [Ack(Result.ERROR)], source=STRANGER),
        Row("px4: an item of the wrong list gets ERROR and it goes on", begun(PX4, 3, 1),
            [ItemAt(1, CIRCLE, FENCE), ItemAt(1, px[1])], [Ack(Result.ERROR, FENCE), Request(2)]),
        Row("px4: a cancel ends it silently", begun(PX4, 3, 1, old=4), [Ack(15), ItemAt(1, px[1])], [], after=4),
        Row("px4: reading in mid-upload is refused by words", begun(PX4, 3, 1), [RequestList()], ["busy"]),
        Row("px4: clearing in mid-upload is refused by words", begun(PX4, 3, 1), [ClearAll()], ["busy"]),
        Row("px4: partial lists meet silence", vehicle(PX4, 5), [WritePartialList(0, 1)], []),
        Row("px4: a request without a list meets silence", vehicle(PX4, 3), [Request(0)], []),
        *[Row(f"px4: a NAK leaves list {kind} as it was", begun_list(PX4, kind, [item, item]),
              [Count(1, kind), ItemAt(0, WAYPOINT, kind)], [Request(0, kind), Ack(Result.ERROR, kind)], after=2,
              kind=kind)
          for kind, item in ((1, CIRCLE), (2, RALLY))],
        # both
        *[Row(f"{autopilot}: a list of no known kind", vehicle(autopilot),
              [Count(1, 7), RequestList(7), Request(0, 7)], [Ack(Result.UNSUPPORTED, 7)] * 2)
          for autopilot in registered()],
        *[Row(f"ardupilot: clearing list {kind}", vehicle(ARDUPILOT, 4), [ClearAll(kind)],
              [Ack(Result.UNSUPPORTED, kind)], after=4) for kind in (7, 255)],
        Row("px4: clearing list 7", vehicle(PX4, 4), [ClearAll(7)], [Ack(OK, 7)], after=4),
        Row("px4: clearing all lists", vehicle(PX4, 4), [ClearAll(255)], [Ack(OK, 255)], after=0),
    ]  # fmt: skip


@pytest.mark.parametrize("row", conversation_rows(), ids=lambda row: row.name)
def test_a_vehicle_answers_as_measured(row: Row) -> None:
    answers: list[Message] = []
    for message in row.answers:
        answers += row.vehicle.hear(message, source=row.source)
    assert len(answers) == len(row.answer), answers
    for got, expected in zip(answers, row.answer, strict=True):
        if isinstance(expected, str):
            assert isinstance(got, Text)
            assert expected in got.text
        else:
            assert plain(got) == expected
    if row.after is not None:
        assert len(row.vehicle.holds(row.kind)) == row.after


def test_ardupilot_asks_again_every_second_and_gives_up_after_eight() -> None:
    answers = begun(ARDUPILOT).wait(60.0)
    assert answers[:-2] == [(float(second), Request(0, legacy=True)) for second in range(1, 8)]
    assert [message for _, message in answers[-2:]] == [Ack(15), Text(4, "Mission upload timeout")]
    assert answers[-1][0] == 8.0


def test_px4_repeats_item_requests_and_gives_up_after_five() -> None:
    mock = begun(PX4, old=4)
    answers = mock.wait(60.0)
    assert [when for when, _ in answers[:4]] == [0.25, 0.5, 0.75, 1.0]
    assert answers[-1] == (5.0, Text(4, "Operation timeout"))
    assert not any(isinstance(message, Ack) for _, message in answers)
    assert len(mock.holds()) == 4


def test_px4_never_repeats_in_a_download() -> None:
    mock = vehicle(PX4, 3)
    assert mock.hear(RequestList()) == [Count(3)]
    assert not any(isinstance(message, Count | ItemAt) for _, message in mock.wait(60.0))


def test_ardupilots_item_0_is_its_own_home() -> None:
    mock = begun(ARDUPILOT, 2)
    elsewhere = having(frame=0, latitude_deg=10.0, longitude_deg=20.0)
    mock.hear(ItemAt(0, elsewhere))
    mock.hear(ItemAt(1, WAYPOINT))
    mock.hear(RequestList())
    (first,) = mock.hear(Request(0))
    assert isinstance(first, ItemAt)
    assert (first.item.latitude_deg, first.item.longitude_deg) == (HOME.latitude_deg, HOME.longitude_deg)


READ_BACK = [
    (ARDUPILOT, params(0, 2.7), "params", (2.0, 0.0, 0.0, 0.0)),
    (ARDUPILOT, having(params=(0.0, 1.0, 2.0, 3.0)), "params", (0.0, 0.0, 0.0, 0.0)),
    (ARDUPILOT, having(altitude=30.12999), "altitude", 30.12),
    (ARDUPILOT, having(frame=5), "frame", 0),
    (ARDUPILOT, having(frame=6), "frame", 3),
    (ARDUPILOT, having(frame=11), "frame", 10),
    (ARDUPILOT, having(frame=2), "frame", 0),
    (ARDUPILOT, having(autocontinue=False), "autocontinue", True),
    (ARDUPILOT, land(HOME), "params", (0.0, 0.0, 0.0, 1.0)),
    (PX4, having(frame=0), "frame", 5),
    (PX4, having(frame=3), "frame", 6),
    (PX4, having(command=22, params=(15.0, 1.0, 2.0, 0.0)), "params", (0.0, 0.0, 0.0, 0.0)),
]


@pytest.mark.parametrize(("autopilot", "item", "field", "kept"), READ_BACK, ids=lambda value: str(value)[:40])
def test_read_back_differs_as_measured(autopilot: Autopilot, item: Item, field: str, kept: object) -> None:
    mock = begun(autopilot, 2, 1)
    mock.hear(ItemAt(1, item))
    mock.hear(RequestList())
    (read,) = mock.hear(Request(1))
    assert isinstance(read, ItemAt)
    assert getattr(read.item, field) == pytest.approx(kept, abs=1e-5)
