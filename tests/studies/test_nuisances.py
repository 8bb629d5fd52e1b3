"""What the records of a study say of nuisances."""

import numpy as np
import pytest

from hydrofdi.evaluation.scores import NOTHING, Kind, Population
from hydrofdi.studies.records import nuisances_of
from tests.studies.made_up_nuisances import BULK, FRICTION, IDLE, LITRES_PER_MINUTE, NOISE, study


@pytest.fixture(scope="module")
def found():
    return {each.parameter: each for each in nuisances_of(*study().records())[0]}


def test_a_nuisance_alone_spreads_the_score_as_far_as_it_does_by_itself(found):
    everything = np.ptp(np.quantile(study().scores[0], [0.05, 0.95]))
    assert found[BULK].alone.value == pytest.approx(2.7 / everything, rel=0.1)
    for name in (IDLE, NOTHING):
        assert found[name].alone.value == pytest.approx(3.29 * NOISE / everything, rel=0.15)


def test_a_nuisance_is_as_much_as_the_leak_that_moves_the_score_as_far(found):
    """The median moves by 2 at the smallest leak and by 1.35 within nine records in ten."""
    assert found[BULK].imitated.place == "below"
    wide = study()
    wide.scores[wide.populations.index(Population(BULK, Kind.ALONE))] *= 2.0
    bulk = next(each for each in nuisances_of(*wide.records())[0] if each.parameter == BULK)
    leak = 10.0 ** (2.7 / 2.0 - 3.0) * LITRES_PER_MINUTE
    assert bulk.imitated.severity == pytest.approx(leak, rel=0.3)


def test_failed_records_are_left_out():
    records, scored = study().records()
    scored.values[records.rows(Population(FRICTION, Kind.ALONE))[:5]] = np.nan
    found, refusals = nuisances_of(records, scored)
    assert [each.alone.n_record for each in found] == [
        395 if each.parameter == FRICTION else 400 for each in found
    ]
    assert not refusals


def test_without_leaks_spreads_are_still_stated():
    found, _ = nuisances_of(*study(levels=()).records())
    assert all(each.alone and each.imitated is None for each in found)
