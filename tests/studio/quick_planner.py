from ipoa_mission.studio.plan_worker import PlanWorker
from ipoa_mission.studio.processes import Worker
from tests.quick_search import search_quickly

if __name__ == "__main__":
    search_quickly()
    Worker(PlanWorker().jobs).run()
