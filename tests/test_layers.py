"""The house rules, read from the sources: who may import whom, and where outside libraries live."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

import hydrofdi

PACKAGE = Path(hydrofdi.__file__).parent

(DRAWN,) = re.findall(
    r"^    cli →.*?(?=\n\n)",
    (PACKAGE.parent / "CONTRIBUTING.md").read_text("utf-8"),
    re.DOTALL | re.MULTILINE,
)
LAYERS = [set(re.findall(r"\w+", layer)) for layer in DRAWN.split("→")]
"""Top to bottom; a room imports from rooms below."""

SIDEWAYS = {
    ("report", "store"), ("report", "studies"), ("studies", "store"),
    ("quality", "simulation"), ("monitor", "store"),
}  # fmt: skip
"""Imports within a layer."""

HOMES = {
    "h5py": ("store/", "records/array_reader.py"), "asammdf": ("records/array_reader.py",),
    "nptdms": ("records/array_reader.py",), "yaml": ("settings/files.py", "config/loading.py"),
    "pywt": ("transforms.py", "indicators/catalogue/", "config/observation.py"), "typer": ("cli/",),
    "rich": ("cli/",), "matplotlib": ("report/", "papers/maddahi2015/figures.py", "api/"),
    "pyarrow": ("tables/table.py", "records/files.py"), "xarray": ("api/", "report/", "tables/table.py"),
    "pandas": ("api/", "report/", "tables/table.py"), "numba": ("compilation/",),
    "llvmlite": ("compilation/",), "distributed": ("execution/",), "dask": ("execution/",),
    "sklearn": ("detectors/scores/",), "threadpoolctl": ("detectors/scores/contract.py",),
    "fmpy": ("fmi.py",), "paho": ("monitor/",), "asyncua": ("monitor/opcua.py",),
    "cryptography": ("monitor/opcua.py",), "prometheus_client": ("monitor/metrics.py",),
}  # fmt: skip
"""Outside library → where it may be imported."""

TREES = {
    path.relative_to(PACKAGE).as_posix(): ast.parse(path.read_text("utf-8"))
    for path in sorted(PACKAGE.rglob("*.py"))
}
ROOMS = {room for layer in LAYERS for room in layer}
BELOW_THE_API = {"execution", "monitor", "papers", "simulation", "store", "studies"}
"""What commands do, they do through ``hydrofdi.api``: they import none of these when they run."""


def room(place):
    return place.partition("/")[0].removesuffix(".py")


def imported(tree):
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "imports are absolute"
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def rooms_imported(place):
    names = (name.split(".") for name in imported(TREES[place]))
    return {parts[1] for parts in names if parts[0] == "hydrofdi" and len(parts) > 1} & ROOMS - {room(place)}


INSIDE = [place for place in TREES if room(place) not in ("__init__", "__main__")]


def test_a_module_imports_only_from_below():
    assert {room(place) for place in INSIDE} <= ROOMS
    height = {name: position for position, layer in enumerate(LAYERS) for name in layer}
    pairs = {(room(place), other) for place in INSIDE for other in rooms_imported(place)}
    assert {(one, other) for one, other in pairs - SIDEWAYS if height[other] <= height[one]} == set()


def test_commands_act_through_the_public_api():
    at_run_time = [
        ast.Module([n for n in tree.body if ast.unparse(getattr(n, "test", n)) != "TYPE_CHECKING"], [])
        for place, tree in TREES.items()
        if room(place) == "cli"
    ]
    names = {name.removeprefix("hydrofdi.") for tree in at_run_time for name in imported(tree)}
    assert names
    assert not {name for name in names if name.partition(".")[0] in BELOW_THE_API}


def test_no_files_import_each_other_in_a_circle():
    """Neither at the top, nor inside functions, nor for types."""
    names = {place: place.removesuffix(".py").removesuffix("/__init__").replace("/", ".") for place in INSIDE}
    files = {f"hydrofdi.{name}": set(imported(TREES[place])) for place, name in names.items()}
    below = {
        name: {each for each in others & files.keys() if not f"{name}.".startswith(f"{each}.")}
        for name, others in files.items()
    }
    while ends := {
        n for n in below if not below[n] & below.keys() or all(n not in o for o in below.values())
    }:
        below = {name: others for name, others in below.items() if name not in ends}
    assert not below.keys()


def test_an_outside_library_is_imported_only_at_home():
    found = {(name.split(".")[0], place) for place, tree in TREES.items() for name in imported(tree)}
    astray = [each for each in found if each[0] in HOMES and not each[1].startswith(HOMES[each[0]])]
    assert astray == []


EVALUATION = (
    "import pkgutil, importlib, hydrofdi.evaluation as room;"
    "[importlib.import_module(m.name) for m in pkgutil.walk_packages(room.__path__, room.__name__ + '.')]"
)
INDICATORS = (
    "from hydrofdi.indicators import indicator_kind, indicator_names;"
    "[indicator_kind(name) for name in indicator_names()]"
)


@pytest.mark.parametrize(("code", "forbidden"), [
    ("import hydrofdi", r"numpy|numba|pydantic|h5py"),
    (INDICATORS, r"hydrofdi\.(config|simulation)"),
    (EVALUATION, r"scipy|hydrofdi\.(?!errors|evaluation|version)\w+"),
], ids=["the package", "what reads records", "the room of arrays"])  # fmt: skip
def test_a_part_never_loads_what_it_must_not_know(code, forbidden):
    code += "; import re, sys; print([name for name in sys.modules if re.match(sys.argv[1], name)])"
    done = subprocess.run([sys.executable, "-c", code, forbidden], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
