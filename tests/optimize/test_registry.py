"""An optimizer is made from a name and settings that a user wrote: what is wrong is said in the user's own terms."""

import dataclasses
from importlib.metadata import EntryPoint

import pytest

from ipoa_mission.errors import BadInput
from ipoa_mission.optimize import registry
from ipoa_mission.optimize.ipoa import IPOA
from ipoa_mission.optimize.poa import POA
from ipoa_mission.optimize.registry import build_optimizer, optimizer_class, optimizer_names


@pytest.mark.parametrize("name", optimizer_names())
def test_without_settings_the_defaults_stand(name: str) -> None:
    assert build_optimizer(name, {}) == optimizer_class(name)()


@pytest.mark.parametrize("name", optimizer_names())
def test_every_default_is_a_value_that_the_setting_may_have(name: str) -> None:
    defaults = dataclasses.asdict(optimizer_class(name)())  # type: ignore[call-overload]
    assert build_optimizer(name, defaults) == optimizer_class(name)()


def test_settings_reach_the_optimizer() -> None:
    built = build_optimizer("ipoa", {"population": 40, "reading": "literal", "levy": False, "radius": 1})
    assert built == IPOA(population=40, reading="literal", levy=False, radius=1.0)


@pytest.mark.parametrize(
    ("name", "settings", "message"),
    [
        ("ipao", {}, r"^optimizer\.name: expected ipoa.* or [a-z-]+, not 'ipao' \(did you mean 'ipoa'\?\)$"),
        (
            "ipoa",
            {"populaton": 3},
            r"^optimizer\.populaton: ipoa has no such setting; .*\(did you mean 'population'\?\)$",
        ),
        ("ipoa", {"population": 3}, r"^optimizer\.population: expected a whole number of at least 4, not 3$"),
        ("poa", {"iterations": 2.5}, r"^optimizer\.iterations: expected a whole number of at least 1, not 2\.5$"),
        ("poa", {"iterations": True}, r"^optimizer\.iterations: expected a whole number of at least 1, not True$"),
        ("ipoa", {"radius": float("nan")}, r"^optimizer\.radius: expected a number of at least 0, not nan$"),
        (
            "ipoa",
            {"population": float("inf")},
            r"^optimizer\.population: expected a whole number of at least 4, not inf$",
        ),
        ("ipoa", {"share": 2}, r"^optimizer\.share: expected a number from 0 to 1, not 2$"),
        ("ipoa", {"levy": "no"}, r"^optimizer\.levy: expected true or false, not 'no'$"),
        (
            "ipoa",
            {"reading": "print"},
            r"^optimizer\.reading: expected 'step' or 'literal' or 'survivor', not 'print'$",
        ),
    ],
)
def test_what_is_wrong_is_named_with_what_was_expected(name: str, settings: dict[str, object], message: str) -> None:
    with pytest.raises(BadInput, match=message):
        build_optimizer(name, settings)


def test_an_optimizer_of_another_package_is_found_by_its_entry_point(monkeypatch: pytest.MonkeyPatch) -> None:
    entries = {name: EntryPoint(name, value, registry.GROUP) for name, value in OTHERS.items()}
    monkeypatch.setattr(registry, "_registered", lambda: entries)
    assert build_optimizer("mine", {"population": 8}) == POA(population=8)
    for name, said in {"gone": "fails: No module", "function": "no dataclass with a search"}.items():
        with pytest.raises(BadInput, match=said):
            build_optimizer(name, {})


OTHERS = {
    "mine": "ipoa_mission.optimize.poa:POA",
    "gone": "ipoa_mission.optimize.nowhere:POA",
    "function": "ipoa_mission.optimize.poa:wing",
}
