"""Pages that come from the program: nothing is left out, and what they show works."""

import re
import shlex
from pathlib import Path

import pytest
from generators import ROOMS, commands
from generators.examples import EXAMPLES

import hydrofdi
from hydrofdi.config import ExperimentConfig
from hydrofdi.config.machine import FluidConfig
from hydrofdi.config.study import OnlineConfig
from hydrofdi.indicators import indicator_names
from hydrofdi.indicators.registry import describe
from hydrofdi.monitor.configuration import FleetConfig, MqttConfig
from hydrofdi.records.description import MeasuredConfig
from hydrofdi.settings.files import ready_names

DOCS = Path(__file__).parents[2] / "docs"
COMMANDS = commands.command_group().commands


@pytest.fixture(scope="module")
def reference(tmp_path_factory):
    folder = tmp_path_factory.mktemp("reference")
    for room in ROOMS:
        room.write(folder)
    return folder


def described():
    """Page → what it must contain."""
    listed = [f"   hydrofdi.{name}\n" for name in hydrofdi.__all__ if name != "__version__"]
    yield "api/index.md", listed
    yield from ((f"api/{name.strip()[9:]}.md", [f":: {name.strip()}\n"]) for name in listed)
    yield "configurations/index.md", [f"]({name}.md)" for name in ready_names()]
    yield from ((f"configurations/{name}.md", [f"configs/{name}.yaml\n"]) for name in ready_names())
    for name, command in COMMANDS.items():
        options = [option for each in command.params for option in each.opts if option.startswith("--")]
        yield f"commands/{name}.md", [f"`{option}" for option in options if option != "--help"]
        yield f"commands/{name}.md", ["## Examples", f"hydrofdi {name}"]
    for name in indicator_names():
        yield "indicators.md", [f"\n## {name}\n", "Source: ", f"`{describe(name).outputs[0].name}`"]


@pytest.mark.parametrize(("page", "parts"), [pytest.param(*each, id=each[0]) for each in described()])
def test_every_command_public_name_configuration_and_indicator_is_described(reference, page, parts):
    text = (reference / page).read_text(encoding="utf-8")
    if page != "indicators.md":
        assert [part for part in parts if part not in text] == []
    else:
        section = text.partition(parts[0])[2].partition("\n## ")[0]
        assert all(part in section for part in parts[1:])


@pytest.mark.parametrize("line", [line for text in EXAMPLES.values() for line in text.splitlines()])
def test_every_example_is_a_command_line_that_hydrofdi_takes(line):
    for part in line.replace(" > ", " | ").split(" | "):
        program, *arguments = shlex.split(part)
        if program == "hydrofdi":
            name, *rest = arguments
            COMMANDS[name].make_context(name, rest)


@pytest.mark.parametrize(("name", "models"), [
    ("configuration", [ExperimentConfig, FluidConfig, OnlineConfig]),
    ("samples", [MeasuredConfig, FleetConfig, MqttConfig]),
])  # fmt: skip
def test_every_key_of_a_file_is_described(reference, name, models):
    text = (reference / f"{name}.md").read_text(encoding="utf-8")
    headings = ", ".join(re.findall(r"^##+ (.*)$", text, re.MULTILINE))
    described = {*re.findall(r"^\| `(\w+)` \|", text, re.MULTILINE), *re.findall(r"[`.](\w+)`", headings)}
    assert {key for model in models for key in model.model_fields} - described == set()


def test_every_kind_of_figure_is_in_the_gallery():
    text = (DOCS / "gallery.md").read_text(encoding="utf-8")
    (listed,) = (option.help for option in COMMANDS["report"].params if "--figure" in option.opts)
    figures = ", ".join(re.findall(r": (\w+(?:, \w+)+)", listed)).split(", ")
    assert len(figures) > 10
    assert [name for name in figures if f"{name}.png" not in text and f"`{name}`" not in text] == []
