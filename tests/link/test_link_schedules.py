"""Random radios: whatever they lose, double, delay and reorder, an upload is exact or an error, never false."""

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from link_pair import HOME, Air, Fate, Vehicle, items_of

from ipoa_mission.errors import MissionError
from ipoa_mission.link.conversations import download
from ipoa_mission.link.dialogue import Cancelled
from ipoa_mission.link.messages import MissionType
from ipoa_mission.link.upload import Upload, upload
from ipoa_mission.mission.firmware import compare, home_item
from ipoa_mission.vehicle import Autopilot

FATES = st.builds(
    Fate,
    copies=st.sampled_from([1, 1, 1, 1, 1, 0, 0, 2]),
    delay_s=st.sampled_from([0.0, 0.01, 0.05, 0.3, 0.3, 0.9, 2.5]),
)
SCHEDULES = st.lists(FATES, min_size=1, max_size=40)
UNHURRIED = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])


@settings(UNHURRIED, max_examples=2000)
@given(SCHEDULES, st.sampled_from(Autopilot), st.integers(0, 6), st.integers(0, 6))
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


@settings(UNHURRIED, max_examples=300)
@given(SCHEDULES, st.sampled_from(Autopilot), st.integers(0, 6), st.integers(1, 6), st.floats(0.0, 3.0))
def test_what_a_cancelled_upload_leaves_is_what_it_says(
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


@settings(UNHURRIED, max_examples=500)
@given(SCHEDULES, st.sampled_from(Autopilot), st.integers(0, 8))
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
