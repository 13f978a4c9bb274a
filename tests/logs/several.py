"""Merge logs of one vehicle each, under other system ids."""

from collections.abc import Iterator, Mapping
from contextlib import closing
from pathlib import Path

from pymavlink.dialects.v20 import ardupilotmega

from ipoa_mission.link.codec import Record, TlogWriter, read_tlog

PLANE = 1  # MAV_TYPE


def as_system(log: Path, system: int, of: int = 1) -> Iterator[Record]:
    """Return frames of vehicle `of` under another system id."""
    reader, writer = ardupilotmega.MAVLink(None), ardupilotmega.MAVLink(None)
    reader.robust_parsing = True
    for record in read_tlog(log):
        for message in reader.parse_buffer(record.frame) or []:
            source = message.get_srcSystem()
            if message.get_type() == "BAD_DATA" or of not in (source, getattr(message, "target_system", None)):
                continue
            if source != of:
                message.target_system = system
            writer.srcSystem, writer.srcComponent = system if source == of else source, message.get_srcComponent()
            yield Record(record.unix_s, message.pack(writer))


def plane(system: int, unix_s: float) -> Record:
    writer = ardupilotmega.MAVLink(None, srcSystem=system, srcComponent=1)
    return Record(unix_s, writer.heartbeat_encode(PLANE, 3, 81, 0, 3).pack(writer))


def write_several(path: Path, first: Path, others: Mapping[int, Path], plane_first: int | None = None) -> Path:
    """Write the first log's frames and the others', begun just after it."""
    records = list(read_tlog(first))
    begins = records[0].unix_s
    for system, log in others.items():
        theirs = list(as_system(log, system))
        shift = begins - theirs[0].unix_s + 3.0  # heard after the first
        records += [Record(record.unix_s + shift, record.frame) for record in theirs]
    if plane_first is not None:
        records.append(plane(plane_first, begins - 1.0))
    with closing(TlogWriter(path)) as log_file:
        for record in sorted(records, key=lambda each: each.unix_s):
            log_file.write(record.frame, record.unix_s)
    return path
