"""State that commands change and telemetry reports."""

from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.link.codec import EVERYONE, Target
from ipoa_mission.link.events import mission_event
from ipoa_mission.link.messages import CRITICAL, Event, Message, MissionType, Text
from ipoa_mission.mission.items import Item
from ipoa_mission.simulator.judgement import Infeasible, infeasibility
from ipoa_mission.simulator.mission_service import MissionService
from ipoa_mission.simulator.mock_profile import MockProfile
from ipoa_mission.simulator.simulated_flight import SimulatedFlight
from ipoa_mission.simulator.situation import FlightMode

ERROR_LEVELS = 0x63  # of an event
TEXT_BYTES = 50  # of a STATUSTEXT


class MockVehicle:
    def __init__(
        self,
        profile: MockProfile,
        flight: SimulatedFlight,
        parameters: Parameters,
        powered_s: float,
        nak_at: int | None,
    ) -> None:
        self.profile, self.flight, self.parameters = profile, flight, parameters
        self.transfers = MissionService(profile, lambda: flight.home, self.send, self.load_list, nak_at)
        self.now = 0.0
        self.powered_s = powered_s
        self.outbox: list[tuple[Message, Target]] = []
        self.items: tuple[Item, ...] = ()  # without home, and only a complete mission
        self.infeasible: Infeasible | None = None
        self.idle_mode = profile.first_mode  # without a command
        self.mission_begun = self.mission_runs = False  # ArduPilot: has a current item, and advances

    @property
    def age(self) -> float:
        return self.now - self.powered_s  # [s]

    @property
    def mode(self) -> int:
        return self.idle_mode if self.flight.mode is FlightMode.HOLD else self.profile.modes[self.flight.mode]

    @property
    def mission_mode(self) -> int:
        return self.profile.modes[FlightMode.MISSION]

    @property
    def first_item(self) -> int:
        return self.profile.autopilot.counts_home

    def send(self, message: Message, to: Target = EVERYONE) -> None:
        self.outbox.append((message, to))

    def send_text(self, severity: int, text: str) -> None:
        """Split a text that exceeds one message."""
        for chunk, start in enumerate(range(0, len(text), TEXT_BYTES)):
            self.send(Text(severity, text[start : start + TEXT_BYTES], int(len(text) > TEXT_BYTES), chunk))

    def arming_refusal(self) -> str:
        start_up = self.profile.start_up
        if self.age < start_up.steady_s:
            return start_up.unsteady
        if self.age < start_up.position_s and self.mode in self.profile.placed_modes:
            return start_up.unplaced
        if self.mode == self.mission_mode and not self.items:
            return start_up.no_mission
        if not self.profile.reports_prearm and self.mode not in self.profile.armable_modes:
            return start_up.unsteady
        return ""

    def load_list(self, kind: int) -> None:
        if kind == MissionType.RALLY:
            self.flight.know_rally(self.transfers.listed(kind))
        if kind != MissionType.MISSION:
            return
        items = self.transfers.listed(kind)[self.first_item :]
        self.infeasible = None
        if self.profile.autopilot.protocol_profile.judges_later and items:
            self.infeasible = infeasibility(self.profile.firmware, items, self.flight.home, self.parameters)
        if self.infeasible:
            self.send_text(CRITICAL, f"{self.infeasible.words}\t")  # an event says the same
            number, arguments = mission_event(self.infeasible.event, *self.infeasible.values)
            self.send(Event(number, ERROR_LEVELS, arguments))
        self.items = () if self.infeasible else items
        self.flight.load(self.items)
        if not items:
            self.mission_begun = self.mission_runs = False
