"""Physical quantities that can only be positive, such as a bulk modulus, as a check of records."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.indicators.contract import Indicator
from hydrofdi.records import Array

CAUSES = "is a sign wrong, are two channels swapped, or is a constant of the actuator wrong?"


def not_positive(
    indicator: Indicator[Any], values: Mapping[str, Array], prefix: str = ""
) -> dict[str, NDArray[np.bool_]]:
    """Records in which a quantity that can only be positive is negative or missing.

    Parameters
    ----------
    indicator : Indicator
    values : mapping of str to ndarray, shape (n_record, ...)
        Its outputs by name.
    prefix : str
        Prefix of these names.

    Returns
    -------
    dict of str to ndarray of bool, shape (n_record,)
        By name of the output; False for records without any number.
    """
    own = {each.name: values[prefix + each.name] for each in indicator.outputs}
    positive = [each.name for each in indicator.outputs if each.is_positive]
    if not positive:
        return {}
    is_measured = np.any([np.isfinite(own[name]) for name, array in own.items() if array.ndim == 1], axis=0)
    return {name: is_measured & ~(own[name] > 0.0) for name in positive}


def doubts(found: Iterable[str], n_record: int) -> Iterator[str]:
    """A sentence on each quantity that is not positive in more than half of the records.

    Parameters
    ----------
    found : iterable of str
        Name of the quantity, for each record in which it is not positive.
    n_record : int
        Number of records with numbers.
    """
    for name, count in Counter(found).items():
        if 2 * count > n_record:
            yield f"{name} is not positive in {count:,} of {n_record:,} records: {CAUSES}"
