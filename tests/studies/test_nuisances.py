"""What the records of a study say of nuisances."""

import numpy as np
import pytest

from hydrofdi.evaluation.scores import NOTHING, Kind
from hydrofdi.studies.records import nuisances_of
from tests.studies.made_up_nuisances import BULK, IDLE, LITRES_PER_MINUTE, NOISE, study


def found(*made):
    return {each.parameter: each for each in nuisances_of(*made)[0]}


def test_a_nuisance_alone_spreads_the_score_as_far_as_it_does_by_itself():
    records, scored = study()
    healthy = [records.rows(each) for each in records.populations if each.kind is Kind.HEALTHY]
    everything = np.ptp(np.quantile(scored.values[np.concatenate(healthy)], [0.05, 0.95]))
    alone = found(records, scored)
    assert alone[BULK].alone.value == pytest.approx(2.7 / everything, rel=0.1)
    for name in (IDLE, NOTHING):
        assert alone[name].alone.value == pytest.approx(3.29 * NOISE / everything, rel=0.15)


def test_a_nuisance_is_as_much_as_the_leak_that_moves_the_score_as_far():
    """The median moves by 2 at the smallest leak and by 1.35 within nine records in ten."""
    assert found(*study())[BULK].imitated.place == "below"
    leak = 10.0 ** (2.7 / 2.0 - 3.0) * LITRES_PER_MINUTE
    assert found(*study(wide=2.0))[BULK].imitated.severity == pytest.approx(leak, rel=0.3)
    assert all(each.alone and each.imitated is None for each in found(*study(levels=())).values())
