import dataclasses
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest

from ipoa_mission.errors import BadInput
from ipoa_mission.optimize import registry
from ipoa_mission.optimize.ipoa import IPOA
from ipoa_mission.optimize.poa import POA
from ipoa_mission.optimize.registry import build_optimizer, optimizer_class, optimizer_names
from ipoa_mission.optimize.search import SHORT_EVALUATIONS, Box, Search, minimize
from ipoa_mission.planning.planner import plan_path
from ipoa_mission.scenario.scenario_file import parse_scenario
from tests.refused import refuses


@pytest.mark.parametrize("name", optimizer_names())
def test_defaults_hold_without_settings(name: str) -> None:
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
        ("ipao", {}, ("unknown-name", "optimizer.name", "'ipao'", "ipoa")),
        ("ipoa", {"populaton": 3}, ("unknown-name", "optimizer.populaton", "population")),
        ("ipoa", {"population": 3}, ("bad-input", "optimizer.population")),
        ("poa", {"iterations": 2.5}, ("bad-input", "optimizer.iterations", "2.5")),
        ("poa", {"iterations": True}, ("bad-input", "optimizer.iterations")),
        ("ipoa", {"radius": float("nan")}, ("bad-input", "optimizer.radius")),
        ("ipoa", {"population": float("inf")}, ("bad-input", "optimizer.population")),
        ("ipoa", {"share": 2}, ("bad-input", "optimizer.share")),
        ("ipoa", {"levy": "no"}, ("bad-input", "optimizer.levy")),
        (
            "ipoa",
            {"reading": "print"},
            ("bad-input", "optimizer.reading", "'step'", "'literal'", "'survivor'", "'print'"),
        ),
    ],
)
def test_wrong_settings_are_named_with_the_expected_ones(
    name: str, settings: dict[str, object], message: tuple[str, ...]
) -> None:
    with refuses(*message):
        build_optimizer(name, settings)


def test_the_most_similar_setting_is_the_hint() -> None:
    with refuses("unknown-name", "optimizer.populaton") as error:
        build_optimizer("ipoa", {"populaton": 3})
    assert error.value.hint == "did you mean population?"


def test_an_optimizer_of_another_package_is_found_by_its_entry_point(monkeypatch: pytest.MonkeyPatch) -> None:
    register(monkeypatch, *OTHERS.items())
    assert build_optimizer("mine", {"population": 8}) == POA(population=8)
    for name, value in {"gone": "nowhere", "function": "wing"}.items():
        with refuses("bad-input", "optimizer.name", value):
            build_optimizer(name, {})


def register(monkeypatch: pytest.MonkeyPatch, *others: tuple[str, str]) -> None:
    entries = tuple(EntryPoint(name, value, "ipoa_mission.optimizers") for name, value in others)
    monkeypatch.setattr(registry, "plug_ins", lambda group: entries)


@pytest.mark.parametrize(
    ("name", "values"),
    [("ipoa", ["other.pelican:IPOA"]), ("mine", ["other.pelican:IPOA", "ipoa_mission.optimize.poa:POA"])],
)
def test_two_optimizers_of_one_name_are_refused(monkeypatch: pytest.MonkeyPatch, name: str, values: list[str]) -> None:
    register(monkeypatch, *((name, value) for value in values))
    with refuses("bad-input", "optimizer.name", f"one optimizer {name}", *values):
        build_optimizer(name, {})
    assert optimizer_names().count(name) == 1
    assert build_optimizer("poa", {}) == POA()


def test_one_optimizer_registered_twice_is_one(monkeypatch: pytest.MonkeyPatch) -> None:
    register(monkeypatch, *[("mine", "ipoa_mission.optimize.poa:POA")] * 2)
    assert build_optimizer("mine", {}) == POA()


OTHERS = {
    "mine": "ipoa_mission.optimize.poa:POA",
    "gone": "ipoa_mission.optimize.nowhere:POA",
    "function": "ipoa_mission.optimize.poa:wing",
}


@dataclasses.dataclass(frozen=True)
class Endless:
    batch: int = 100

    def search(self, box: Box, rng: np.random.Generator) -> Search:
        while True:
            yield box.sample(self.batch, rng)


@dataclasses.dataclass(frozen=True)
class LargeBatches(Endless):
    batch: int = SHORT_EVALUATIONS + 1


def test_a_short_search_of_any_optimizer_ends(monkeypatch: pytest.MonkeyPatch, missions: Path) -> None:
    monkeypatch.setitem(registry.BUILT_IN, "endless", Endless)
    text = (missions / "sitl.toml").read_text() + '\n[optimizer]\nname = "endless"\n'
    plan = plan_path(parse_scenario(text, missions / "sitl.toml"), seed=1)
    assert plan.proof.is_proved
    assert plan.evaluations[-1] % SHORT_EVALUATIONS == 0


def test_a_budget_below_the_first_batch_is_refused() -> None:
    box = Box(-np.ones(2), np.ones(2))
    with refuses("bad-input", "", "at least 100 evaluations", "not 99", kind=BadInput):
        minimize(lambda x: (x**2).sum(axis=1), box, Endless(), np.random.default_rng(1), budget=99)
    optimum = minimize(lambda x: (x**2).sum(axis=1), box, Endless(), np.random.default_rng(1), budget=100)
    assert optimum.evaluations.tolist() == [100]


def test_a_short_search_of_too_large_batches_is_refused(monkeypatch: pytest.MonkeyPatch, missions: Path) -> None:
    monkeypatch.setitem(registry.BUILT_IN, "endless", LargeBatches)
    text = (missions / "sitl.toml").read_text() + '\n[optimizer]\nname = "endless"\n'
    with refuses("bad-input", "", f"at least {SHORT_EVALUATIONS + 1} evaluations", kind=BadInput):
        plan_path(parse_scenario(text, missions / "sitl.toml"), seed=1)
