"""Pages that come from the program: nothing is left out, and what they show works."""

import re
import shlex
from pathlib import Path

import pytest
from generators import ROOMS, commands
from generators.examples import EXAMPLES
from generators.links import led_to_pages

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


def test_every_command_has_a_page_with_its_options_and_an_example(reference):
    assert {page.stem for page in (reference / "commands").iterdir()} == {"index", *COMMANDS}
    for name, command in COMMANDS.items():
        text = (reference / "commands" / f"{name}.md").read_text(encoding="utf-8")
        options = [
            option for parameter in command.params for option in parameter.opts if option.startswith("--")
        ]
        assert all(f"`{option}" in text for option in options if option != "--help")
        assert f"hydrofdi {name}" in text.partition("## Examples")[2]


@pytest.mark.parametrize("line", [line for text in EXAMPLES.values() for line in text.splitlines()])
def test_every_example_is_a_command_line_that_hydrofdi_takes(line):
    for part in line.replace(" > ", " | ").split(" | "):
        program, *arguments = shlex.split(part)
        if program == "hydrofdi":
            name, *rest = arguments
            COMMANDS[name].make_context(name, rest)


def test_every_public_name_has_a_page_and_a_place_in_the_overview(reference):
    index = (reference / "api" / "index.md").read_text(encoding="utf-8")
    for name in set(hydrofdi.__all__) - {"__version__"}:
        assert f"   hydrofdi.{name}\n" in index
        assert f":: hydrofdi.{name}\n" in (reference / "api" / f"{name}.md").read_text(encoding="utf-8")


def test_every_ready_configuration_has_a_page_with_its_file(reference):
    for name in ready_names():
        page = reference / "configurations" / f"{name}.md"
        assert f"configs/{name}.yaml\n" in page.read_text(encoding="utf-8")
        assert f"]({name}.md)" in (reference / "configurations" / "index.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("name", "models"),
    [
        ("configuration", [ExperimentConfig, FluidConfig, OnlineConfig]),
        ("samples", [MeasuredConfig, FleetConfig, MqttConfig]),
    ],
)
def test_every_key_of_a_file_is_described(reference, name, models):
    text = (reference / f"{name}.md").read_text(encoding="utf-8")
    headings = ", ".join(re.findall(r"^##+ (.*)$", text, re.MULTILINE))
    described = {*re.findall(r"^\| `(\w+)` \|", text, re.MULTILINE), *re.findall(r"[`.](\w+)`", headings)}
    assert {key for model in models for key in model.model_fields} - described == set()


def test_keys_of_files_and_streams_stand_once(reference):
    text = (reference / "samples.md").read_text(encoding="utf-8")
    assert text.count("| `sampling_frequency` |") == text.count("| `piston_area` |") == 1


def test_every_indicator_has_a_section_with_its_outputs(reference):
    page = (reference / "indicators.md").read_text(encoding="utf-8")
    for name in indicator_names():
        section = page.partition(f"\n## {name}\n")[2].partition("\n## ")[0]
        assert "Source: " in section
        assert f"`{describe(name).outputs[0].name}`" in section


def test_every_kind_of_figure_is_in_the_gallery():
    text = (DOCS / "gallery.md").read_text(encoding="utf-8")
    (listed,) = (option.help for option in COMMANDS["report"].params if "--figure" in option.opts)
    figures = ", ".join(re.findall(r": (\w+(?:, \w+)+)", listed)).split(", ")
    assert len(figures) > 10
    assert [name for name in figures if f"{name}.png" not in text and f"`{name}`" not in text] == []


@pytest.mark.parametrize(
    ("page", "link", "led"),
    [
        ("docs/results.md", "../configs/table3.yaml", "/reference/configurations/table3.md"),
        ("docs/studies.md", "../configs/schema.json#study", "/reference/configuration.md#study"),
        ("docs/index.md", "../hydrofdi/indicators/catalogue#weak_rls", "/reference/indicators.md#weak_rls"),
        ("docs/running.md", "../configs/", "/reference/configurations/index.md"),
        ("CHANGELOG.md", "docs/files.md#layout", "/files.md#layout"),
        ("docs/measured.md", "https://example.org/a.yaml", "https://example.org/a.yaml"),
    ],
)
def test_links_lead_to_the_page_that_shows_the_file(page, link, led):
    assert led_to_pages(f"see [this]({link}).", page) == f"see [this]({led})."
