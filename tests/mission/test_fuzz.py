import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipoa_mission.checks.check import check_mission
from ipoa_mission.errors import BadInput
from ipoa_mission.mission.mission_io import read_mission
from ipoa_mission.mission.stored_mission import as_stored, compare, to_wire
from tests.refused import refuses

FILES = Path(__file__).parent / "files"
PLANS = sorted(FILES.glob("*.plan"))
LISTS = sorted(FILES.glob("*.waypoints"))
NUMBERS = st.integers() | st.floats() | st.sampled_from([0, 3, 10, 16, 21, 22, 82, 177, 178, 206, 5001, 10**400])
VALUES = st.recursive(
    st.none() | st.booleans() | NUMBERS | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=7) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=8,
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("fuzz")


def probe(path: Path) -> None:
    try:
        mission = read_mission(path)
    except BadInput as refusal:
        if not str(refusal).startswith(f"{path}: "):
            pytest.fail(f"does not begin with the file: {refusal}")
        return
    check_mission(mission)
    wire = to_wire(mission)
    assert compare(wire, as_stored(wire, mission.autopilot), mission.autopilot) is None


def places(node: Any, so_far: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """The path of keys to every value of a document."""
    pairs = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    paths = [so_far] if so_far else []
    for key, value in pairs:
        paths += places(value, (*so_far, key))
    return paths


@given(data=st.data())
def test_a_plan_with_any_value_replaced_is_read_or_refused(data: st.DataObject, folder: Path) -> None:
    document = json.loads(data.draw(st.sampled_from(PLANS)).read_text())
    for _ in range(data.draw(st.integers(1, 2))):
        *way, last = data.draw(st.sampled_from(places(document)))
        parent = document
        for key in way:
            parent = parent[key]
        parent[last] = data.draw(VALUES)
    path = folder / "fuzz.plan"
    path.write_text(json.dumps(document))
    probe(path)


@given(data=st.data())
def test_a_list_with_any_field_replaced_is_read_or_refused(data: st.DataObject, folder: Path) -> None:
    lines = [line.split("\t") for line in data.draw(st.sampled_from(LISTS)).read_text().splitlines()]
    for _ in range(data.draw(st.integers(1, 2))):
        line = data.draw(st.sampled_from(lines))
        line[data.draw(st.integers(0, len(line) - 1))] = data.draw(NUMBERS.map(str) | st.text(max_size=5))
    path = folder / "fuzz.waypoints"
    path.write_text("\n".join(map("\t".join, lines)), encoding="utf-8", errors="replace")
    probe(path)


@given(data=st.data(), noise=st.binary(max_size=40))
def test_a_file_with_noise_in_it_is_read_or_refused(data: st.DataObject, noise: bytes, folder: Path) -> None:
    source = data.draw(st.sampled_from([*PLANS, *LISTS]))
    content = source.read_bytes()
    first, last = sorted((data.draw(st.integers(0, len(content))), data.draw(st.integers(0, len(content)))))
    path = folder / f"noise{source.suffix}"
    path.write_bytes(content[:first] + noise + content[last:])
    probe(path)


@given(content=st.binary(max_size=200))
def test_bytes_of_any_kind_are_refused(content: bytes, folder: Path) -> None:
    for suffix in (".plan", ".waypoints", ".txt"):
        path = folder / f"any{suffix}"
        path.write_bytes(content)
        with pytest.raises(BadInput) as refused:
            read_mission(path)
        assert (refused.value.place or "").startswith(str(path))


@pytest.mark.parametrize("bomb", ["[" * 100_000, '{"a":' * 100_000, '{"fileType": ' + "9" * 10_000 + "}"])
def test_documents_that_break_parsers_are_refused(bomb: str, tmp_path: Path) -> None:
    path = tmp_path / "bomb.plan"
    path.write_text(bomb)
    with refuses("too-large", "bomb.plan"):
        read_mission(path)
