from collections.abc import Iterator
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest
from pymavlink.dialects.v20 import ardupilotmega, storm32

from ipoa_mission.errors import BadInput
from ipoa_mission.link import definitions
from ipoa_mission.link.codec import Codec, as_pymavlink, frame_at
from ipoa_mission.link.definitions import payload_of
from tests.refused import refuses


@pytest.fixture
def _as_before(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Restore the table after a test."""
    monkeypatch.setattr(definitions, "_DIALECTS", [ardupilotmega])
    tables: list[dict[Any, Any]] = [definitions.DEFINITIONS, definitions._BY_NAME]
    before = [dict(table) for table in tables]
    new = {each.number: each for each in (*definitions._PX4_DEFINITIONS, *definitions._definitions(ardupilotmega))}
    first: tuple[dict[Any, Any], ...] = (new, {definition.name: definition for definition in new.values()})
    for table, definitions_before in zip(tables, first, strict=True):
        table.clear()
        table.update(definitions_before)
    yield
    for table, whole in zip(tables, before, strict=True):
        table.clear()
        table.update(whole)


def test_the_table_is_pymavlinks_with_what_the_stable_dialects_lack() -> None:
    known = {definitions.DEFINITIONS[number].name for number in ardupilotmega.mavlink_map}
    assert known == {kind.msgname for kind in ardupilotmega.mavlink_map.values()}
    assert "opaque_id" in definitions.definition_of("MISSION_ACK").names


@pytest.mark.usefixtures("_as_before")
@pytest.mark.parametrize("dialect", ["storm32", storm32])
def test_a_dialect_that_is_named_is_understood_and_spoken(dialect: str | ModuleType) -> None:
    message = storm32.MAVLink_qshot_status_message(3, 7)
    with refuses("bad-input", "message"):
        payload_of(message)
    theirs = bytes(message.pack(storm32.MAVLink(None, srcSystem=9)))
    assert frame_at(theirs, 0) is None
    definitions.add_dialect(dialect)
    assert frame_at(theirs, 0) == theirs
    ours = Codec(9, 0).frame(*payload_of(message), 0.0)
    assert as_pymavlink(ours).to_dict() == as_pymavlink(theirs).to_dict() == message.to_dict()


def test_text_goes_there_and_back_as_pymavlink_has_it() -> None:
    built = ardupilotmega.MAVLink_param_set_message(1, 1, b"RTL_ALT", 6500.0, 9)
    assert Codec(255, 190).frame(*payload_of(built), 0.0) == bytes(built.pack(ardupilotmega.MAVLink(None, 255, 190)))
    heard = as_pymavlink(bytes(built.pack(ardupilotmega.MAVLink(None, 255, 190))))
    assert payload_of(heard) == payload_of(built)


@pytest.mark.usefixtures("_as_before")
def test_dialects_that_are_none_or_contradict_ours_are_bad_input() -> None:
    with refuses("unknown-dialect", "dialect", "'martian'", kind=BadInput) as refused:
        definitions.add_dialect("martian")
    assert "common" in (refused.value.hint or "")
    contradicting = SimpleNamespace(
        id=0, msgname="HEARTBEAT", crc_extra=1, ordered_fieldnames=["a"], fieldnames=["a"], fieldtypes=["uint8_t"],
        lengths=[1], unpacker=SimpleNamespace(format="<B"),
    )  # fmt: skip
    with refuses("bad-input", "dialect", "HEARTBEAT"):
        definitions.add_dialect(SimpleNamespace(mavlink_map={0: contradicting}))  # type: ignore[arg-type]
    with refuses("unknown-dialect", "message 65000", kind=BadInput):
        definitions.dialect_of(65_000)


def test_known_params_of_commands_are_explained() -> None:
    assert definitions.labeled_params(177) == {1: ("Number", "", "Sequence number"), 2: ("Repeat", "", "Repeat count")}
    assert definitions.labeled_params(16)[2][:2] == ("Accept Radius", "m")
    assert definitions.labeled_params(183)[2][:2] == ("PWM", "us")
    assert definitions.labeled_params(64_999) == {}
