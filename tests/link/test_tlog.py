"""Telemetry logs on a full disk."""

from contextlib import closing
from pathlib import Path

import pytest

from ipoa_mission.link.codec import TlogWriter


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
def test_a_disk_that_is_full_ends_the_log_and_not_the_flight(caplog: pytest.LogCaptureFixture) -> None:
    with closing(TlogWriter("/dev/full")) as log:
        for _ in range(3):
            log.write(b"frame", 1.0)
    assert len(caplog.messages) == 1
    assert "/dev/full: cannot be written any more: No space left on device" in caplog.messages[0]


def test_a_disk_that_takes_half_a_record_is_full(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    class Half:
        def write(self, data: bytes) -> int:
            return len(data) // 2

        def close(self) -> None: ...

    with closing(TlogWriter(tmp_path / "x.tlog")) as log:
        log._file.close()
        log._file = Half()  # type: ignore[assignment]
        log.write(b"frame", 1.0)
    assert "No space left on device" in caplog.messages[0]
