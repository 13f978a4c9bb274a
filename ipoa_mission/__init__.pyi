"""Every public name and where it lives; `ipoa_mission` imports each from there when it is first used."""

from typing import Any

from ipoa_mission.checks.check import Finding as Finding
from ipoa_mission.checks.check import Severity as Severity
from ipoa_mission.checks.check import check_mission as check_mission
from ipoa_mission.checks.start import NotAtStart as NotAtStart
from ipoa_mission.checks.unsafe import Unsafe as Unsafe
from ipoa_mission.commands import Command as Command
from ipoa_mission.commands import Frame as Frame
from ipoa_mission.energy.flight import NotEnoughBattery as NotEnoughBattery
from ipoa_mission.errors import BadInput as BadInput
from ipoa_mission.errors import MissionError as MissionError
from ipoa_mission.exports import write_export as write_export
from ipoa_mission.exports.table import mission_table as mission_table
from ipoa_mission.flight.flight import Flight as Flight
from ipoa_mission.flight.flight import plan_flight as plan_flight
from ipoa_mission.items import FenceCircle as FenceCircle
from ipoa_mission.items import FencePolygon as FencePolygon
from ipoa_mission.items import Item as Item
from ipoa_mission.items import Mission as Mission
from ipoa_mission.link.channel import LinkDown as LinkDown
from ipoa_mission.link.connect import connect as connect
from ipoa_mission.link.conversations import MissionRefused as MissionRefused
from ipoa_mission.link.deafness import SignsOtherwise as SignsOtherwise
from ipoa_mission.link.deafness import SpeaksMavlink1 as SpeaksMavlink1
from ipoa_mission.link.definitions import add_dialect as add_dialect
from ipoa_mission.link.dialogue import Cancelled as Cancelled
from ipoa_mission.link.dialogue import NoAnswer as NoAnswer
from ipoa_mission.link.dialogue import TimeUp as TimeUp
from ipoa_mission.link.flight_log import read_flight as read_flight
from ipoa_mission.link.holding import ReplacedSince as ReplacedSince
from ipoa_mission.link.line import Contested as Contested
from ipoa_mission.link.logbook import FlightRecord as FlightRecord
from ipoa_mission.link.orders import CommandRefused as CommandRefused
from ipoa_mission.link.state import NotFlown as NotFlown
from ipoa_mission.link.state import NotReady as NotReady
from ipoa_mission.link.unbroken import Unsettled as Unsettled
from ipoa_mission.link.upload import ReadBackDiffers as ReadBackDiffers
from ipoa_mission.link.upload import Replaced as Replaced
from ipoa_mission.link.upload import Unflyable as Unflyable
from ipoa_mission.link.vehicle import Vehicle as Vehicle
from ipoa_mission.mission.files import read_mission as read_mission
from ipoa_mission.mission.files import write_mission as write_mission
from ipoa_mission.mission.plan_file import write_plan as write_plan
from ipoa_mission.mission.waypoints_file import write_waypoints as write_waypoints
from ipoa_mission.optimize.ipoa import IPOA as IPOA
from ipoa_mission.optimize.search import Box as Box
from ipoa_mission.optimize.search import Optimizer as Optimizer
from ipoa_mission.optimize.search import minimize as minimize
from ipoa_mission.planning.obstruction import NoPath as NoPath
from ipoa_mission.planning.path_problem import PathProblem as PathProblem
from ipoa_mission.planning.plan import Plan as Plan
from ipoa_mission.planning.planner import plan_path as plan_path
from ipoa_mission.report.compare import Comparison as Comparison
from ipoa_mission.report.compare import compare_flight as compare_flight
from ipoa_mission.report.page import write_report as write_report
from ipoa_mission.report.plots import draw_views as draw_views
from ipoa_mission.report.plots import write_picture as write_picture
from ipoa_mission.routing.assemble import assemble as assemble
from ipoa_mission.routing.assemble import weigh_routes as weigh_routes
from ipoa_mission.routing.route import NoRoute as NoRoute
from ipoa_mission.scenario import Scenario as Scenario
from ipoa_mission.scenario import read_scenario as read_scenario
from ipoa_mission.scenario.limits import Limits as Limits
from ipoa_mission.simulator.faults import Faults as Faults
from ipoa_mission.simulator.fly import fly as fly
from ipoa_mission.timing.estimate import Estimate as Estimate
from ipoa_mission.timing.estimate import ItemTime as ItemTime
from ipoa_mission.timing.estimate import estimate as estimate
from ipoa_mission.vehicles.autopilot import Autopilot as Autopilot
from ipoa_mission.wind import Wind as Wind
from ipoa_mission.world.airspace import Airspace as Airspace
from ipoa_mission.world.airspace import Bounds as Bounds
from ipoa_mission.world.frame import Geodetic as Geodetic
from ipoa_mission.world.obstacles import Cylinder as Cylinder
from ipoa_mission.world.obstacles import Prism as Prism
from ipoa_mission.world.obstacles import Sphere as Sphere
from ipoa_mission.world.terrain import Flat as Flat

__version__: str
__all__: list[str]

def load_ipython_extension(shell: Any) -> None: ...
