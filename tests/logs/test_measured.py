"""Batteries in logs: ArduPilot's records, MAVLink's two messages."""

import math
import struct
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from pymavlink import mavutil
from pyulog import ULog  # type: ignore[import-untyped]
from scipy.spatial.transform import Rotation

from ipoa_mission.link.codec import EVERYONE, Codec, TlogWriter, read_tlog
from ipoa_mission.link.messages import BatteryStatus, Message, SystemStatus
from ipoa_mission.logs.flight_log import LoggedFlight, read_flights
from ipoa_mission.logs.logged import Measured
from tests.refused import refuses

LOGS = Path(__file__).parent.parent / "logs"
HEAD = b"\xa3\x95"
#: Records of ArduCopter 3.3, 3.5, 4.0 and 4.7: struct format, ArduPilot's letters, columns.
LAYOUTS = {
    "3.3": ("CURR", "QhhhHfh", "QhhhHfh", "TimeUS,Throttle,Volt,Curr,Vcc,CurrTot,Volt2"),
    "3.5": ("CURR", "Qfff", "Qfff", "TimeUS,Volt,Curr,CurrTot"),
    "3.5 second": ("CUR2", "Qfff", "Qfff", "TimeUS,Volt,Curr,CurrTot"),
    "4.0": ("BAT", "QBffff", "QBffff", "TimeUS,Instance,Volt,VoltR,Curr,CurrTot"),
    "4.7": ("BAT", "QBffff", "QBffff", "TimeUS,Inst,Volt,VoltR,Curr,CurrTot"),
}
PARM = ("PARM", "Q16sf", "QNf", "TimeUS,Name,Value")


def logged(path: Path, *kinds: tuple[tuple[str, str, str, str], Sequence[tuple[object, ...]]]) -> LoggedFlight:
    """Write a flight with these records, a value a second."""
    data = (LOGS / "sitl-ardupilot.bin").read_bytes()
    armed_s = read_flights(LOGS / "sitl-ardupilot.bin").flights[0].armed_s
    for number, ((kind, layout, letters, columns), rows) in enumerate(kinds, 240):
        size = 3 + struct.calcsize("<" + layout)
        words = (kind.encode(), letters.encode(), columns.encode())
        data += HEAD + struct.pack("<BBB4s16s64s", 128, number, size, *words)
        for n, row in enumerate(rows, 1):
            data += HEAD + struct.pack("<B" + layout, number, round((armed_s + n) * 1e6), *row)
    path.write_bytes(data)
    return read_flights(path).flights[0]


def test_batteries_are_read_as_each_firmware_wrote_them(tmp_path: Path) -> None:
    path = tmp_path / "one.bin"
    centi = [(500, 1200, 2000, 5000, 0.0, 0), (500, 1180, 2100, 5000, 0.0, 0)]
    plain = [(12.0, 20.0, 0.0), (11.8, 21.0, 0.0)]
    numbered = [(0, 12.0, 12.2, 20.0, 0.0), (0, 11.8, 12.2, 21.0, 0.0)]
    for name, rows in (("3.3", centi), ("3.5", plain), ("4.0", numbered), ("4.7", numbered)):
        power = logged(path, (LAYOUTS[name], rows)).measured.power()
        np.testing.assert_allclose(power, [[1.0, 240.0], [2.0, 247.8]], rtol=1e-6, err_msg=name)


def test_two_batteries_are_summed_and_esc_telemetry_counts_none_twice(tmp_path: Path) -> None:
    path, first, second = (
        tmp_path / "two.bin",
        [(12.0, 20.0, 0.0), (12.0, 21.0, 0.0)],
        [(6.0, 3.0, 0.0), (6.0, 4.0, 0.0)],
    )
    both = (LAYOUTS["3.5"], first), (LAYOUTS["3.5 second"], second)
    assert logged(path, *both).measured.power()[:, 1] == pytest.approx([258.0, 276.0])
    escs = (PARM, [(b"BATT2_MONITOR", 9.0)])
    assert logged(path, *both, escs).measured.power()[:, 1] == pytest.approx([240.0, 252.0])


@pytest.mark.parametrize(
    ("amperes", "words"),
    [
        ((math.nan, math.nan), ("log-useless", "", "current")),
        ((-1.0, -1.0), ("log-useless", "", "current")),
        ((0.0, 0.0), ("log-useless", "", "current")),
        ((15.0, 15.0), ("log-useless", "", "15 A")),
    ],
)
def test_a_current_that_was_not_measured_is_named(amperes: tuple[float, ...], words: tuple[str, ...]) -> None:
    battery = [(float(n), 12.0, ampere) for n, ampere in enumerate(amperes)]
    with refuses(*words):
        Measured.of([battery], []).power()
    measured = [(0.0, 12.0, 1.0), (1.0, 12.0, 2.0)]
    assert Measured.of([battery, measured], []).power()[:, 1] == pytest.approx([12.0, 24.0])
    with refuses("log-useless", "", "voltage"):
        Measured.of([[(0.0, 0.0, 3.0)]], []).power()


def with_messages(path: Path, *definitions: tuple[Message, Message]) -> LoggedFlight:
    """Read a .tlog with each message in its two forms by turns."""
    codec = Codec(1, 1)
    with closing(TlogWriter(path)) as log:
        for n, record in enumerate(read_tlog(LOGS / "sitl-ardupilot.tlog")):
            log.write(record.frame, record.unix_s)
            for forms in definitions:
                log.write(codec.encode(forms[n % 2], EVERYONE, 0.0), record.unix_s)
    return read_flights(path).flights[0]


def test_a_telemetry_log_tells_each_battery_or_the_general_one(tmp_path: Path) -> None:
    path = tmp_path / "told.tlog"
    general = SystemStatus(0, 0, 0, 12.0, 90, 20.0), SystemStatus(0, 0, 0, 12.0, 90, 22.0)
    assert set(np.round(with_messages(path, general).measured.power()[:, 1])) == {240.0, 264.0}
    each = [(BatteryStatus(n, 11.0, 10.0), BatteryStatus(n, 11.0, 10.2)) for n in (0, 1)]
    power = with_messages(path, general, *each).measured.power()[:, 1]
    assert set(np.round(power, 1)) == {220.0, 224.4}
    untold = SystemStatus(0, 0, 0, 12.0, 90), SystemStatus(0, 0, 0, 12.1, 90)
    with refuses("log-useless", "", "current"):
        with_messages(path, untold).measured.power()


RECORDED = LOGS


def test_px4s_attitude_is_that_of_its_quaternions_by_scipy() -> None:
    flight = read_flights(RECORDED / "other_vehicle-0.ulg").flights[0]
    (data,) = (d.data for d in ULog(str(RECORDED / "other_vehicle-0.ulg")).data_list if d.name == "vehicle_attitude")
    turned = Rotation.from_quat(np.column_stack([data[f"q[{n}]"] for n in (1, 2, 3, 0)]))
    angles = turned.as_euler("ZYX")[:, ::-1]
    attitude = flight.measured.attitude
    which = np.searchsorted(data["timestamp"] / 1e6 - flight.armed_s, attitude[:, 0] - 1e-6)
    assert len(attitude) > 50
    assert np.abs(attitude[:, 1:] - angles[which]).max() < 1e-5
    with refuses("log-useless", "", "current"):  # its simulator has none
        flight.measured.power()


def test_copters_attitude_is_what_pymavlink_reads() -> None:
    flight = read_flights(RECORDED.parents[1] / "missions" / "logs" / "copter-6.bin").flights[0]
    log, degrees = mavutil.mavlink_connection(str(RECORDED.parents[1] / "missions" / "logs" / "copter-6.bin")), []
    while (record := log.recv_match(type="ATT")) is not None:
        degrees.append((record.TimeUS / 1e6 - flight.armed_s, record.Roll, record.Pitch, record.Yaw))
    log.close()
    expected = np.array(degrees)
    attitude = flight.measured.attitude
    assert len(attitude) > 100
    nearest = np.abs(attitude[:, :1] - expected[:, 0]).argmin(axis=1)
    assert np.abs(np.degrees(attitude[:, 1:]) - expected[nearest, 1:]).max() < 0.01
    assert flight.measured.power()[:, 1].max() > 200.0
