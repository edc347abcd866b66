"""Parsing of commands, their help with common options first, and shell completion."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import Any

import typer.core

from roughcontact.analyses import tasks
from roughcontact.request import parsing
from roughcontact.request.options import Option, Panel

HELP_ALL = "help-all"
_HELP_ALL_KEY = "roughcontact.help-all"

# Maximum width of the option column; the text of longer options starts on the next line.
_COMPLETION_WIDTH = 27

Rows = list[tuple[str, str]]


class CommandGroup(typer.core.TyperGroup):
    """The program, whose help lists the commands in groups."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse the arguments before the command."""
        _take_words(self.get_params(ctx))
        return super().parse_args(ctx, args)

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write the groups of commands, then the options."""
        for heading, group in tasks.GROUPS.items():
            rows = [(command.name, _first_sentence(command.help)) for command in group]
            _write_section(formatter, heading, rows)
        _write_section(formatter, "Options", [_row(option) for option in _options(self, ctx)])


class HelpCommand(typer.core.TyperCommand):
    """A command, whose help lists the common options first."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse the arguments after the command."""
        _take_words(self.get_params(ctx))
        return super().parse_args(ctx, args)

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write arguments and options; explain the common options, and list the others."""
        params: list[Any] = self.get_params(ctx)
        specified = [item for item in params if item.param_type_name == "argument"]
        _write_section(
            formatter, "Arguments", [(str(item.metavar), str(item.help)) for item in specified]
        )
        options = {option.opts[0].removeprefix("--"): option for option in _options(self, ctx)}
        show_all = ctx.meta.get(_HELP_ALL_KEY)
        command = tasks.COMMANDS[str(self.name)]
        settings = [option for option in command.options if option.is_setting]
        first = [] if show_all else command.short_help.split()
        panels: dict[str, list[Any]] = {}
        for name, option in options.items():
            if name not in first:
                panels.setdefault(option.rich_help_panel or "Help", []).append(option)
        if not first:
            for panel, held in panels.items():
                rows = [_row(option) for option in held]
                rows += map(_setting_row, settings) if panel == Panel.SETTINGS else ()
                _write_section(formatter, panel, rows)
            return
        _write_section(formatter, "Common options", [_row(options[name]) for name in first])
        about = [_row(option) for option in panels.pop("Help")]
        rest = [(panel, " ".join(item.opts[0] for item in held)) for panel, held in panels.items()]
        rest[-1] = ("--set NAME=VALUE", " ".join(item.name for item in settings))
        _write_section(formatter, f"More options (--{HELP_ALL})", rest)
        _write_section(formatter, "Help", about)


def _take_words(parameters: Iterable[Any]) -> None:
    """Replace the value parser of parameters: texts pass unchanged."""
    for parameter in parameters:
        parameter.process_value = partial(_argument_value, parameter, parameter.process_value)


def _argument_value(parameter: Any, process: Callable[..., Any], ctx: Any, value: Any) -> Any:
    """Return texts and missing values of a parameter unchanged; parse other values."""
    if value is None and (parameter.multiple or parameter.nargs == -1):
        value = ()
    lacking = value is None or value == ()
    words = value if isinstance(value, (list, tuple)) else [value]
    if parameter.required if lacking else not all(isinstance(word, str) for word in words):
        return process(ctx, value)
    return value if parameter.callback is None else parameter.callback(ctx, parameter, value)


def show_all(ctx: typer.Context, wanted: bool) -> None:
    """Print the help with all options, and exit."""
    if wanted:
        ctx.meta[_HELP_ALL_KEY] = True
        print(ctx.get_help())
        raise typer.Exit(0)


def _options(command: Any, ctx: Any) -> Iterator[Any]:
    return (item for item in command.get_params(ctx) if item.param_type_name == "option")


def _row(option: Any) -> tuple[str, str]:
    takes = "" if option.is_flag else f" {option.metavar}"
    return ", ".join(sorted(option.opts, key=len)) + takes, str(option.help)


def _setting_row(option: Option[Any]) -> tuple[str, str]:
    return f"{option.name}={option.metavar}".rstrip("="), option.help


def _write_section(formatter: Any, heading: str, rows: Rows) -> None:
    """Write two columns under a heading, without line breaks at hyphens."""
    if not rows:
        return
    indent_width = min(max(len(words) for words, _ in rows), _COMPLETION_WIDTH) + 2
    with formatter.section(heading):
        indent = " " * formatter.current_indent
        for words, text in rows:
            width = formatter.width - len(indent) - indent_width
            lines = textwrap.wrap(text, width, break_on_hyphens=False)
            if len(words) + 2 > indent_width:
                lines.insert(0, "")
            for number, line in enumerate(lines):
                start = words if number == 0 else ""
                formatter.write(f"{indent}{start:{indent_width}}{line}".rstrip() + "\n")


def _first_sentence(text: str) -> str:
    return " ".join(text.partition("\n\n")[0].split())


# Shell completion


def completer_of(option: Option[Any]) -> Callable[[str], list[str]] | None:
    """Return a function that lists the values with a prefix; None without known values."""
    if option.parse is parsing.material:
        return complete_materials
    if known := [str(word) for word in option.parse.known]:
        return lambda incomplete: [word for word in known if word.startswith(incomplete)]
    return None


def complete_materials(incomplete: str) -> list[str]:
    """Return material names with a prefix; without a prefix, only the main names."""
    from roughcontact.material import catalog

    names = [
        name
        for entry in catalog.entries()
        for name in (entry.key, *(entry.names if incomplete else ()))
    ]
    # A shell would split a name at a blank.
    return [name for name in names if name.startswith(incomplete) and " " not in name]
