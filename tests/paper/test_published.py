import numpy as np
import pytest

from ipoa_mission.paper.problems import FUNCTIONS
from ipoa_mission.paper.runs import ALGORITHMS
from ipoa_mission.paper.tables import PRINTED, improved

TABLES = {name: PRINTED[name] for name in ("table_3", "table_5", "table_6", "table_7")} | {
    "table_8": {"": PRINTED["table_8"]}
}


@pytest.mark.parametrize("table", TABLES.values(), ids=TABLES)
def test_every_row_has_a_number_for_each_algorithm(table: dict[str, dict[str, list[float]]]) -> None:
    for part in table.values():
        assert all(len(row) == len(ALGORITHMS) for row in part.values())


def test_ipoa_is_first_in_twenty_five_of_thirty_six_metrics() -> None:
    """Section 5.2 and the abstract's 69.4 %."""
    firsts = sum(min(row) == row[0] for part in PRINTED["table_3"].values() for row in part.values())
    assert firsts == 25
    assert round(100 * firsts / 36, 1) == 69.4


def test_ipoa_is_first_in_seven_of_nine_metrics_under_the_weights() -> None:
    """Section 6.2."""
    assert sum(min(row) == row[0] for part in PRINTED["table_5"].values() for row in part.values()) == 7


def test_table_3_is_possible() -> None:
    """Best below mean, and no mean farther above the best than the deviation of thirty numbers allows."""
    assert set(PRINTED["table_3"]) == set(FUNCTIONS)
    for part in PRINTED["table_3"].values():
        best, mean, sd = (np.array(part[key]) for key in ("best", "mean", "sd"))
        assert np.all(best < mean)
        assert np.all(mean - best <= sd * np.sqrt(29))


def test_table_4_holds_the_p_of_complete_separation() -> None:
    assert set(PRINTED["table_4"]) == set(FUNCTIONS)
    assert min(p for row in PRINTED["table_4"].values() for p in row) == 3.0198e-11


@pytest.mark.parametrize("where", ["Table 6", "Table 7, 10 obstacles", "Table 8"])
@pytest.mark.parametrize("rival", ["poa", "mpoa"])
def test_the_improvement_in_length_is_that_of_the_text(where: str, rival: str) -> None:
    k = ALGORITHMS.index(rival)
    rows = [table["distance"] for table in improved(where)]
    follows = np.mean([(row[k] - row[0]) / row[k] for row in rows]) * 100
    assert follows == pytest.approx(PRINTED["improvements"][where][rival][0], abs=0.02)
