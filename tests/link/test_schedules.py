"""Random radios: an upload is exact or an error, never false."""

from collections import Counter

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.errors import MissionError
from ipoa_mission.link.conversations import download, offer
from ipoa_mission.link.dialogue import Cancelled
from ipoa_mission.link.messages import Current, Message, MissionType
from ipoa_mission.link.upload import Upload, upload
from ipoa_mission.mission.stored_mission import compare, home_item
from tests.examples import examples
from tests.link import random_stations
from tests.link.random_stations import Outcome
from tests.link_pair import HOME, Air, Fate, Vehicle, items_of

DELAYS_S = (0.0, 0.01, 0.05, 0.3, 0.9, 0.3, 2.5)
FATES = [Fate(copies, delay_s) for copies in (1, 0, 1, 1, 1, 2, 1, 0) for delay_s in DELAYS_S]
#: Drawing a byte a message at once is much quicker.
SCHEDULES = st.binary(min_size=1, max_size=40).map(lambda drawn: [FATES[byte % len(FATES)] for byte in drawn])
NO_TOTAL = 65535
HEARD_WITHIN_S = 1.2  # answers, or a heartbeat a second
UNHURRIED = settings(suppress_health_check=[HealthCheck.too_slow])


@settings(UNHURRIED, max_examples=examples(400))
@given(SCHEDULES, st.sampled_from(registered()), st.integers(0, 6), st.integers(0, 6))
def test_an_upload_is_exact_or_an_error(fates: list[Fate], autopilot: Autopilot, old: int, new: int) -> None:
    vehicle = Vehicle(autopilot)
    before = items_of(autopilot, old, shift=0.01)
    vehicle.store(before)
    sent = items_of(autopilot, new)
    air = Air(vehicle, fates)
    try:
        air.hold(upload(Upload(sent, autopilot)))
    except MissionError:
        if autopilot is Autopilot.PX4:  # atomic: the old list or the new one, whole
            assert None in (compare(before, vehicle.holds(), autopilot), compare(sent, vehicle.holds(), autopilot))
        return
    assert compare(sent, vehicle.holds(), autopilot) is None


class Rivalry(Air):
    """Another station uploads its mission; the vehicle reports the count five times a second."""

    def begin(self, moment: float, count: int) -> None:
        self.moment, self.count, self.replaced = moment, count, False
        self._told = 0.0

    def _launch(self, messages: list[Message], to_vehicle: bool) -> None:
        if not self.replaced and self.now >= self.moment:
            self.replaced = True
            self.vehicle.store(items_of(self.vehicle_kind, self.count, shift=0.02))
        if not to_vehicle and self.now - self._told >= 0.2:
            self._told = self.now
            messages = [*messages, Current(0, len(self.vehicle.holds()) or NO_TOTAL, 2 if self.vehicle.holds() else 1)]
        super()._launch(messages, to_vehicle)

    vehicle_kind = Autopilot.PX4


@settings(UNHURRIED, max_examples=examples(150))
@given(st.floats(0.0, 3.0), st.integers(0, 6), st.integers(1, 6), st.sampled_from([0.0, 0.02, 0.1]))
def test_a_mission_replaced_by_another_station_is_an_error_unless_unheard(
    moment: float, theirs: int, ours: int, delay_s: float
) -> None:
    assume(theirs != ours)
    air = Rivalry(Vehicle(Autopilot.PX4), [Fate(1, delay_s)])
    air.begin(moment, theirs)
    sent = items_of(Autopilot.PX4, ours)
    try:
        air.hold(upload(Upload(sent, Autopilot.PX4)))
    except MissionError:
        return
    held = compare(sent, air.vehicle.holds(), Autopilot.PX4) is None
    assert held or air.now - moment < HEARD_WITHIN_S + delay_s


@settings(UNHURRIED, max_examples=examples(150))
@given(SCHEDULES, st.sampled_from(registered()), st.integers(0, 6), st.integers(1, 6), st.floats(0.0, 3.0))
def test_cancelled_upload_leaves_the_list_that_it_names(
    fates: list[Fate], autopilot: Autopilot, old: int, new: int, moment: float
) -> None:
    vehicle = Vehicle(autopilot)
    before, sent = items_of(autopilot, old, shift=0.01), items_of(autopilot, new)
    vehicle.store(before)
    try:
        Air(vehicle, fates).hold(upload(Upload(sent, autopilot)), interrupts={moment: Cancelled("cancelled")})
    except Cancelled as cancelled:
        words = str(cancelled)
    except MissionError:
        return
    else:
        words = "done"
    held = vehicle.holds()
    if "old or the new" in words:
        assert None in (compare(before, held, autopilot), compare(sent, held, autopilot))
    else:
        assert compare(before if "keeps" in words else sent, held, autopilot) is None


@settings(UNHURRIED, max_examples=examples(200))
@given(SCHEDULES, st.sampled_from(registered()), st.integers(0, 8))
def test_a_download_is_exact_or_an_error(fates: list[Fate], autopilot: Autopilot, count: int) -> None:
    vehicle = Vehicle(autopilot)
    vehicle.store(items_of(autopilot, count))
    before = vehicle.holds()
    try:
        read = Air(vehicle, fates).hold(download(MissionType.MISSION))
    except MissionError:
        return
    assert len(read) == len(before)
    if autopilot is Autopilot.ARDUPILOT and read:
        assert read[0] == home_item(HOME)
    assert compare(before, read, autopilot) is None


@pytest.mark.parametrize("first", [0, *(pytest.param(first, marks=pytest.mark.long) for first in (100, 200, 300))])
def test_an_upload_among_strangers_is_exact_or_an_error(first: int) -> None:
    ended = [random_stations.schedule(seed) for seed in range(first, first + 15)]
    results = Counter(result for result, _ in ended)
    assert results[Outcome.FALSE] == 0
    assert results[Outcome.HANG] == 0
    assert results[Outcome.EXACT] >= 3
    assert results[Outcome.ERROR] >= 1


def test_the_judge_of_schedules_knows_a_false_success(monkeypatch: pytest.MonkeyPatch) -> None:
    """An uploader that believes the Ack, and neither reads back nor listens."""
    monkeypatch.setattr(random_stations, "upload", lambda job: offer(job.items, job.kind))
    assert any(random_stations.schedule(seed)[0] is Outcome.FALSE for seed in range(30, 60))
