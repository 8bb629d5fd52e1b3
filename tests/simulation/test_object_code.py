"""Machine code of functions and of recorded operations, and its cache on disk."""

import math
import os
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numba.core.errors import NumbaError
from numpy.typing import NDArray

from hydrofdi.compilation import object_code
from hydrofdi.compilation.object_code import kernel, recorded_kernel
from hydrofdi.compilation.symbols import each


def with_memory_of_its_own(values: NDArray[Any]) -> None:
    values[:] = np.sort(values)


def with_another_function(values: NDArray[Any]) -> None:
    for k in range(values.size):
        values[k] = math.acosh(values[k])


def twice(values: NDArray[Any]) -> None:
    for k in range(values.size):
        values[k] *= 2.0


def thrice(values: NDArray[Any]) -> None:
    for k in range(values.size):
        values[k] *= 3.0


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache."""
    monkeypatch.setattr(object_code, "cache_directory", lambda room: tmp_path)
    return tmp_path


def doubled() -> list[float]:
    values = np.ones(2)
    kernel(twice)(values)
    return values.tolist()


def test_damaged_machine_code_is_not_run_but_made_again(folder: Path) -> None:
    assert doubled() == [2.0, 2.0]
    (file,) = folder.iterdir()
    whole = file.read_bytes()
    flipped = bytes([whole[0] ^ 1]) + whole[1:], whole[:-9] + bytes([whole[-9] ^ 1]) + whole[-8:]
    for damage in (whole[:-1], b"", *flipped):
        file.write_bytes(damage)
        assert doubled() == [2.0, 2.0]
        assert file.read_bytes() != damage
    assert list(folder.iterdir()) == [file]


def test_what_needs_the_runtime_of_numba_is_refused(folder: Path) -> None:
    with pytest.raises(NumbaError):
        kernel(with_memory_of_its_own)(np.array([2.0, 3.0, 1.0]))
    with pytest.raises(TypeError, match="cos"):
        kernel(with_another_function)(np.ones(3))
    assert not list(folder.iterdir())


def _give_away(path: Path) -> None:
    if os.geteuid():
        pytest.skip("only root can give a file to another user: run as root")
    os.chown(path, 65534, 65534)


def _let_the_group_write(path: Path) -> None:
    path.chmod(0o770)


def _put_aside(path: Path) -> None:
    path.symlink_to(path.rename(path.with_name("aside")))


PLANTED = [_give_away, _let_the_group_write, _put_aside]


@pytest.mark.parametrize(("plant", "factor"), [(lambda path: None, 3.0), *((each, 2.0) for each in PLANTED)])
def test_code_that_others_may_have_written_is_not_run(plant, factor, folder):
    for function in (twice, thrice):
        kernel(function)(np.ones(2))
    (own,), (other,) = folder.glob("twice-*.o"), folder.glob("thrice-*.o")
    own.write_bytes(other.read_bytes())
    plant(own)
    assert doubled() == [factor, factor]


def _refuse(path: Path) -> None:
    path.rmdir()
    path.touch()


@pytest.mark.parametrize("plant", [*PLANTED, _refuse])
def test_without_a_folder_of_its_own_nothing_is_kept_or_left_behind(plant, tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    find = object_code.cache_directory.__wrapped__
    before = os.umask(0)
    try:
        own = find("simulation")
    finally:
        os.umask(before)
    assert own is not None
    assert (own.stat().st_mode & 0o777, own.parent.stat().st_mode & 0o777) == (0o700, 0o700)
    plant(own)
    assert find("simulation") is None
    monkeypatch.setattr(object_code, "cache_directory", find)
    assert doubled() == [2.0, 2.0]
    assert [path.name for path in tmp_path.iterdir()] == ["cache"]
    assert not list(tmp_path.rglob("*.o"))


OPERATIONS = {
    "arithmetic": lambda x, y: (x + y) * (x - 2.0) / (3.0 + y * y) - -x,
    "roots": lambda x, y: np.copysign(np.sqrt(np.abs(x)), y) + np.floor(x) + np.rint(y),
    "limits": lambda x, y: np.minimum(np.maximum(x, -1.0), y),
    "choice": lambda x, y: np.where((x >= y) & (x > 0.0), x, np.where(x == y, 1.0, np.where(x < y, y, -y))),
    "bits": lambda x, y: (((x.view(np.int64) >> 52) << 3) - 7 + y.view(np.int64) * 0) % 1000 // 3 * 1.0,
    "order": lambda x, y: np.where(x <= 0.5, y, x),
}  # fmt: skip


@pytest.mark.parametrize("name", OPERATIONS)
@pytest.mark.usefixtures("folder")
def test_each_recorded_operation_gives_what_numpy_gives(name: str) -> None:
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


def test_each_value_of_an_option_has_its_machine_code_by_its_place_and_numbers_share_it(folder: Path) -> None:
    def scaled(values, factor, first, second):
        values[0] = (
            factor * values[0] + (1.0 if first == "more" else 0.0) + (9.0 if second == "more" else 0.0)
        )

    scale, values = recorded_kernel(scaled), np.ones(1)
    for given in (2.0, "more", None), (3.0, "more", None), (0.5, None, None), (1.0, None, "more"):
        scale(values, *given)
    assert values[0] == 14.0
    assert len(list(folder.glob("scaled-*.o"))) == 3
    with pytest.raises(IndexError):
        recorded_kernel(lambda values: values.__setitem__(-1, 1.0))(values)


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize("branching", [lambda x: 1.0 if x > 0.0 else 0.0, lambda x: min(x, 1.0)])
def test_a_branch_on_a_symbol_is_refused(branching) -> None:
    def fill(values):
        values[0] = branching(values[0])

    with pytest.raises(TypeError):
        recorded_kernel(fill)(np.ones(1))
    assert list(each(2)) == [0, 1]
