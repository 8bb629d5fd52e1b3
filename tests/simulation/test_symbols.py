"""Machine code of recorded operations gives what the same operations give in NumPy."""

from pathlib import Path

import numpy as np
import pytest

from hydrofdi.compilation import object_code
from hydrofdi.compilation.object_code import recorded_kernel
from hydrofdi.compilation.symbols import each

OPERATIONS = {
    "arithmetic": lambda x, y: (x + y) * (x - 2.0) / (3.0 + y * y) - -x,
    "roots": lambda x, y: np.copysign(np.sqrt(np.abs(x)), y) + np.floor(x) + np.rint(y),
    "limits": lambda x, y: np.minimum(np.maximum(x, -1.0), y),
    "choice": lambda x, y: np.where((x >= y) & (x > 0.0), x, np.where(x == y, 1.0, np.where(x < y, y, -y))),
    "bits": lambda x, y: (((x.view(np.int64) >> 52) << 3) - 7 + y.view(np.int64) * 0) % 1000 // 3 * 1.0,
    "order": lambda x, y: np.where(x <= 0.5, y, x),
}  # fmt: skip


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A cache of its own: it does not tell functions of one name apart."""
    monkeypatch.setattr(object_code, "cache_directory", lambda room: tmp_path)
    return tmp_path


@pytest.mark.parametrize("name", OPERATIONS)
def test_each_operation_gives_what_numpy_gives(name: str) -> None:
    operation = OPERATIONS[name]

    def fill(x, y, results):
        for k in each(x.shape[0]):
            results[k] = operation(x[k], y[k])

    x, y = np.abs(np.random.default_rng(1).normal(0.0, 2.0, (2, 500)))
    x[::7] = y[::7]
    x[3] = np.nan if name == "limits" else 1.0  # of both operands of a limit, the first remains NaN
    signs = np.ones(500) if name == "bits" else np.where(np.arange(500) % 3, 1.0, -1.0)
    results = np.empty(500)
    recorded_kernel(fill)(x * signs, y, results)
    np.testing.assert_allclose(results, operation(x * signs, y), rtol=1e-14, atol=1e-14)


RECORD = np.dtype([("name", "i8"), ("level", "f8", (3,))])


def test_each_value_of_an_option_has_its_machine_code_by_its_place_and_numbers_share_it(folder: Path) -> None:
    def scaled(values, factor, first, second):
        values[0] = (
            factor * values[0] + (1.0 if first == "more" else 0.0) + (9.0 if second == "more" else 0.0)
        )

    kernel, values = recorded_kernel(scaled), np.ones(1)
    for given in (2.0, "more", None), (3.0, "more", None), (0.5, None, None), (1.0, None, "more"):
        kernel(values, *given)
    assert values[0] == 14.0
    assert len(list(folder.glob("scaled-*.o"))) == 3
    with pytest.raises(IndexError):
        recorded_kernel(lambda values: values.__setitem__(-1, 1.0))(values)


@pytest.mark.parametrize("branching", [lambda x: 1.0 if x > 0.0 else 0.0, lambda x: min(x, 1.0)])
def test_a_branch_on_a_symbol_is_refused(branching) -> None:
    def fill(values):
        values[0] = branching(values[0])

    with pytest.raises(TypeError):
        recorded_kernel(fill)(np.ones(1))
    assert list(each(2)) == [0, 1]
