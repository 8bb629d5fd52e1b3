"""The house rules, read from the sources: who may import whom, and where outside libraries live."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import hydrofdi

PACKAGE = Path(hydrofdi.__file__).parent

LAYERS = [
    {"cli"},
    {"api"},
    {"execution"},
    {"papers"},
    {"monitor", "report", "studies", "quality", "sensing", "store", "simulation"},
    {"config"},
    {"detectors"},
    {"indicators", "scoring"},
    {"estimation", "evaluation", "transforms", "records"},
    {"compilation"},
    {"physics"},
    {"settings"},
    {"units"},
    {"errors"},
]
"""Top to bottom; a room imports from rooms below, and execution from its own layer as the house allows."""

SIDEWAYS = {
    ("report", "store"),
    ("report", "quality"),
    ("report", "studies"),
    ("studies", "store"),
    ("quality", "simulation"),
    ("sensing", "simulation"),
    ("monitor", "store"),
}
"""Imports within a layer."""

HOMES = {
    "h5py": ("store/", "records/array_reader.py"),
    "pywt": ("transforms/", "indicators/catalogue/", "config/sections/fit.py"),
    "typer": ("cli/",),
    "rich": ("cli/",),
    "yaml": ("settings/yaml_source.py", "config/loading.py"),
    "matplotlib": ("report/figures/", "papers/maddahi2015/figures/", "api/"),
    "pyarrow": (
        "report/forms/tidy.py",
        "report/table.py",
        "records/measured/",
        "records/written/",
    ),
    "xarray": ("api/", "report/table.py"),
    "pandas": ("api/", "report/table.py"),
    "pebble": ("execution/",),
    "numba": ("compilation/",),
    "llvmlite": ("compilation/",),
    "distributed": ("execution/",),
    "dask": ("execution/",),
    "sklearn": ("scoring/",),
    "threadpoolctl": ("scoring/extra.py",),
    "paho": ("monitor/",),
    "asyncua": ("monitor/opcua/",),
    "cryptography": ("monitor/opcua/",),
    "prometheus_client": ("monitor/sinks/",),
}
"""Outside library → where it may be imported."""

FILES = sorted(path for path in PACKAGE.rglob("*.py"))
TREES = {path: ast.parse(path.read_text(encoding="utf-8")) for path in FILES}


def place(path):
    return path.relative_to(PACKAGE).as_posix()


def room(path):
    first = path.relative_to(PACKAGE).parts[0]
    return first.removesuffix(".py")


def imported(tree):
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "imports are absolute"
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def rooms_imported(path):
    rooms = {layer for group in LAYERS for layer in group}
    names = (name.split(".") for name in imported(TREES[path]))
    return {parts[1] for parts in names if parts[0] == "hydrofdi" and len(parts) > 1 and parts[1] in rooms}


INSIDE = [path for path in FILES if room(path) not in ("__init__", "__main__")]


def test_every_room_has_its_layer():
    assert {room(path) for path in INSIDE} <= {name for layer in LAYERS for name in layer}


@pytest.mark.parametrize("path", INSIDE, ids=place)
def test_a_module_imports_only_from_below(path):
    height = {name: position for position, layer in enumerate(LAYERS) for name in layer}
    here = room(path)
    for other in rooms_imported(path) - {here}:
        assert height[other] > height[here] or (here, other) in SIDEWAYS, f"{place(path)} imports {other}"


def test_nothing_imports_the_command_line():
    importers = {room(path) for path in FILES if "cli" in rooms_imported(path)}
    assert importers <= {"cli", "__main__"}


BELOW_THE_API = {
    "execution", "monitor", "papers", "simulation", "store", "studies",
    "config.load_experiment",
}  # fmt: skip
"""What commands do, they do through ``hydrofdi.api``: they import none of these when they run."""

EXCEPTIONS = {
    "cli/report.py",
}  # fmt: skip
"""Commands that still do; the list only shrinks."""


def used_below_the_api(path):
    names = {name.removeprefix("hydrofdi.") for name in imported(without_type_checking(TREES[path]))}
    return {name for name in names if {name, name.split(".")[0]} & BELOW_THE_API}


def without_type_checking(tree):
    kept = [node for node in tree.body if ast.unparse(getattr(node, "test", node)) != "TYPE_CHECKING"]
    return ast.Module(kept, [])


COMMANDS = [path for path in INSIDE if room(path) == "cli"]


@pytest.mark.parametrize("path", COMMANDS, ids=place)
def test_a_command_acts_through_the_public_api(path):
    assert bool(used_below_the_api(path)) == (place(path) in EXCEPTIONS), used_below_the_api(path)


def test_there_are_no_circles_between_rooms():
    below = {}
    for path in INSIDE:
        below.setdefault(room(path), set()).update(rooms_imported(path) - {room(path)})
    while leaves := {name for name, others in below.items() if not others & below.keys()}:
        below = {name: others for name, others in below.items() if name not in leaves}
    assert not below


@pytest.mark.parametrize("library", HOMES)
def test_an_outside_library_is_imported_only_at_home(library):
    for path in FILES:
        if any(name.split(".")[0] == library for name in imported(TREES[path])):
            assert place(path).startswith(HOMES[library]), f"{place(path)} imports {library}"


@pytest.mark.parametrize("path", FILES, ids=place)
def test_what_is_public_has_a_docstring(path):
    tree = TREES[path]
    assert ast.get_docstring(tree), place(path)
    for node in tree.body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_"):
            assert ast.get_docstring(node), f"{place(path)}: {node.name}"


def test_names_that_say_nothing_are_not_used():
    empty = {"utils", "util", "core", "common", "helpers", "helper", "manager", "misc"}
    assert not {part for path in FILES for part in path.relative_to(PACKAGE).with_suffix("").parts} & empty


def test_what_reads_records_never_loads_what_makes_them():
    code = (
        "import sys; from hydrofdi.indicators import indicator_kind, indicator_names;"
        "[indicator_kind(name) for name in indicator_names()];"
        "print(sorted(m for m in sys.modules if m.startswith(('hydrofdi.config', 'hydrofdi.simulation'))))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
