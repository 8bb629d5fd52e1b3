"""The command line: its commands, and the one place where errors become messages and exit codes."""

from __future__ import annotations

import errno
import os
import signal
import sys
import traceback
from collections.abc import Iterable
from importlib import import_module
from operator import attrgetter
from typing import Annotated, Any, TextIO

import typer
from typer.core import TyperGroup

import hydrofdi
from hydrofdi import errors
from hydrofdi.cli.options import options_like, with_options
from hydrofdi.cli.terminal import told_on_standard_error
from hydrofdi.settings.messages import similar

_MOST_OF_PATH = 60
"""Number of characters that are shown of a name that is too long."""

DONE, RUNS_FAILED, USER_ERROR, FAULT, INTERRUPTED, UNREAD = 0, 1, 2, 3, 130, 141


class _Commands(TyperGroup):
    """The commands. After an interruption, a message says what is stored; typer would omit it."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the commands in groups."""
        room = formatter.width - 6 - max(map(len, self.commands))
        for group, names in _GROUPS.items():
            shown = [(name, self.commands[name].get_short_help_str(room)) for name in names]
            with formatter.section(group):
                formatter.write_dl(shown, col_max=max(map(len, self.commands)))

    def invoke(self, ctx: typer.Context) -> Any:  # type: ignore[override]
        """Run a command and return its exit code."""
        try:
            _take_back_ctrl_c()
            return super().invoke(ctx)
        except BrokenPipeError:
            return _unread()
        except (Exception, KeyboardInterrupt) as error:
            if not errors.is_interruption(error):
                raise
            _complain(str(error) if isinstance(error, errors.SweepInterrupted) else "interrupted")
            return INTERRUPTED


_GROUPS = {
    "Start": ("init", "configs", "check", "simulate"),
    "Study": ("plan", "sweep", "report", "status", "collect", "calibrate"),
    "Records": ("inspect", "measure", "diagnose", "evaluate", "export"),
    "Live": ("train", "detect", "monitor", "replay", "trend"),
    "Look up": ("indicators", "schema"),
    "Audit": ("verify", "why", "rerun"),
}
"""Group of the help → commands."""

_HOMES = {
    name: {"Look up": "start", "Audit": "study"}.get(group, group.lower())
    for group, names in _GROUPS.items()
    for name in names
}
"""Command → module below ``hydrofdi.cli``."""

_KEYWORDS = {
    "calibrate": "flows:--flow",
    "detect": "sampling_frequency",
    "diagnose": "indicators healthy sampling_frequency",
    "evaluate": "indicators healthy false_alarm_rate confidence usual_scores",
    "export": "format channels unit runs sampling_frequency overwrite",
    "init": "template:--from",
    "inspect": "record write sampling_frequency",
    "measure": "indicators sampling_frequency",
    "monitor": "config state log metrics follow sampling_frequency",
    "plan": "out workers retry_failed",
    "replay": "record now sampling_frequency",
    "rerun": "experiment:--config",
    "simulate": "out",
    "sweep": "out workers engine scheduler shared_directory part retry_failed",
    "train": "healthy best sensors config sampling_frequency",
    "trend": "limit machine indicator output every begin false_alarm_rate confidence sampling_frequency",
}
"""Command → keywords of a function in Python that are its options, too."""

_FUNCTIONS = {"monitor": "Detector.monitor", "plan": "sweep"}
"""Command → that function, if it has another name."""


def application(names: Iterable[str] = _HOMES, *, with_settings: bool = True) -> typer.Typer:
    """The command line with some commands: to build the options of all takes longer than most commands.

    Without settings, options that follow from a configuration are left out, as its model takes time to load.
    """
    app = typer.Typer(
        name="hydrofdi",
        cls=_Commands,
        help="Detect internal leakage in hydraulic actuators: simulate, study what can be detected, monitor.",
        epilog="Exit codes: 0 done; 1 done, but runs failed; 2 an error that you can fix; "
        "3 a bug in hydrofdi; 130 interrupted.",
        context_settings={"help_option_names": ["-h", "--help"]},
        rich_markup_mode=None,
        pretty_exceptions_enable=False,
    )
    app.callback()(_root)
    for name in names:
        module = import_module(f"hydrofdi.cli.{_HOMES[name]}")
        options = _options(name, module) if with_settings else {}
        app.command(name)(with_options(getattr(module, name), options))
    return app


def _options(name: str, module: Any) -> dict[str, Any]:
    """The options of a command that follow from a configuration, or from a function."""
    stated: dict[str, Any] = getattr(module, f"{name}_options", dict)()
    if name in _KEYWORDS:
        stated |= options_like(attrgetter(_FUNCTIONS.get(name, name))(hydrofdi), _KEYWORDS[name].split())
    return stated


def _print_version(wanted: bool) -> None:
    if wanted:
        print(f"hydrofdi {hydrofdi.__version__}")
        raise typer.Exit


def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Detect internal leakage in hydraulic actuators: simulate, study what can be detected, monitor."""


def main() -> None:
    """Run the command line and exit."""
    try:
        with told_on_standard_error():
            arguments = sys.argv[1:] or ["--help"]
            is_command = arguments[0] in _HOMES
            is_completion = "_HYDROFDI_COMPLETE" in os.environ
            app = application(
                arguments[:1] if is_command else _HOMES, with_settings=is_command or is_completion
            )
            code = app(arguments, standalone_mode=False) or DONE
        sys.stdout.flush()
    except errors.HydrofdiError as error:
        code = _complain(str(error))
    except typer.TyperException as error:
        message = getattr(error, "format_message", error.__str__)().replace("Value error, ", "")
        context: Any = getattr(error, "ctx", None)
        if hasattr(error, "possibilities") and (option := getattr(error, "option_name", "")):
            known = [name for parameter in context.command.params for name in parameter.opts]
            message = f"No such option: {option}{similar(option, known)}"
        hint = getattr(context, "command_path", "hydrofdi")
        code = (
            _complain(errors.without_credentials(f"{message} (see '{hint} --help')"))
            if message
            else USER_ERROR
        )
    except (KeyboardInterrupt, typer.Abort):
        _complain("interrupted")
        code = INTERRUPTED
    except BrokenPipeError:
        code = _unread()
    except Exception as error:
        code = _unexpected(error)
    sys.exit(code)


def _unread() -> int:
    """Exit code if the reader of the output has ended, as ``head`` does; nothing is written after this."""
    _discard(sys.stdout, sys.stderr)
    return UNREAD


def _discard(*streams: TextIO) -> None:
    """Send what is still to be written, at the end of Python as well, nowhere."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in streams:
        os.dup2(nowhere, stream.fileno())


def _unexpected(error: Exception) -> int:
    """Exit code of an unexpected error: a long name, a full disk, no memory are the user's; else a bug."""
    if isinstance(error, OSError) and error.errno in (errno.ENAMETOOLONG, errno.ENOSPC):
        if not error.filename:
            _discard(sys.stdout)
        return _complain(f"{str(error.filename or 'standard output')[:_MOST_OF_PATH]}: {error.strerror}")
    is_memory = isinstance(error, MemoryError) or "failed to map segment" in str(error)
    if is_memory or (isinstance(error, OSError) and error.errno == errno.ENOMEM):
        return _complain("there is not enough memory; look at 'ulimit -v' and at other programs")
    traceback.print_exc()
    _complain("this is a bug in hydrofdi; please report it with the lines above")
    return FAULT


def _take_back_ctrl_c() -> None:
    """Let Ctrl-C raise `KeyboardInterrupt` again; until here, the entry point handles it."""
    if callable(signal.getsignal(signal.SIGINT)):
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _complain(message: str) -> int:
    for line in message.splitlines():
        print(line if line.startswith("  ") else f"hydrofdi: {line}", file=sys.stderr)
    return USER_ERROR
