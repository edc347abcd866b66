"""Commands with their help, common options first, and shell completion."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterable, Iterator
from typing import Any

import click

from roughcontact.analyses import tasks
from roughcontact.request import parsing
from roughcontact.request.options import Option
from roughcontact.request.task import Command

_SHOW_ALL = "roughcontact.help-all"
# Maximum width of the option column; the text of longer options starts on the next line.
_COLUMN_WIDTH = 27

Rows = list[tuple[str, str]]
Completion = Callable[[str], list[str]]
"""Function that returns the values with a prefix."""


class CommandGroup(click.Group):
    """The program, whose help lists the commands in groups."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the groups of commands, then the options."""
        for heading, group in tasks.GROUPS.items():
            rows = [(command.name, _first_sentence(command.help)) for command in group]
            _write_section(formatter, heading, rows)
        _write_section(formatter, "Options", list(_records(self, ctx)))


class Subject(click.Argument):
    """Positional argument of a command, with its help; optional in brackets."""

    def __init__(
        self, metavar: str, text: str, complete: Completion | None = None, nargs: int = 1
    ) -> None:
        super().__init__(
            ["subject"],
            metavar=metavar,
            nargs=nargs,
            required=metavar[0] != "[",
            shell_complete=_completer(complete),
        )
        self.row = metavar.strip("[]"), text


class HelpCommand(click.Command):
    """A command, whose help lists the common options first."""

    def __init__(self, table: Command, subject: Subject | None, act: Callable[..., None]) -> None:
        self.table, self.subject = table, subject
        self.settings = [option for option in table.options if option.is_setting]
        parameters = [_parameter(option) for option in table.options if not option.is_setting]
        if self.settings:
            names = [option.name for option in self.settings]
            complete = _completer(_from_list(names))
            text = "One of the settings below; repeatable."
            parameters.append(
                click.Option(["--set"], multiple=True, help=text, shell_complete=complete)
            )
        if table.short_help:
            text = "Show all options."
            parameters.append(eager_option("--help-all", text, self._show_all, is_flag=True))
        super().__init__(
            table.name,
            callback=act,
            params=[*([] if subject is None else [subject]), *parameters],
            help=table.help,
            epilog=f"Example:\n\n{table.example}" if table.example else None,
        )

    def _show_all(self, ctx: click.Context, _: click.Parameter, wanted: bool) -> None:
        """Print the help with all options, and exit."""
        if wanted:
            ctx.meta[_SHOW_ALL] = True
            print(ctx.get_help())
            ctx.exit()

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write arguments and options; explain the common options, and list the others."""
        _write_section(formatter, "Arguments", [self.subject.row] if self.subject else [])
        common = [] if ctx.meta.get(_SHOW_ALL) else self.table.short_help.split()
        panels: dict[str, list[Option[Any]]] = {}
        for option in self.table.options:
            if option.name not in common and not option.is_setting:
                panels.setdefault(option.panel, []).append(option)
        about = [row for row in _records(self, ctx) if "help" in row[0]]
        if not common:
            for panel, held in panels.items():
                _write_section(formatter, panel, list(map(_row, held)))
            if self.settings:
                lead = ("--set NAME=VALUE", "One of the settings below; repeatable.")
                _write_section(formatter, "Settings", [lead, *map(_setting_row, self.settings)])
        else:
            _write_section(
                formatter, "Common options", [_row(self.table.by_name[name]) for name in common]
            )
            rest = [
                (panel, " ".join(f"--{item.name}" for item in held))
                for panel, held in panels.items()
            ]
            names = " ".join(item.name for item in self.settings)
            rest += [("--set NAME=VALUE", names)]
            _write_section(formatter, "More options (--help-all)", rest)
        _write_section(formatter, "Help", about)


def eager_option(name: str, text: str, act: Callable[..., None], **more: Any) -> click.Option:
    """Return an option that acts before the others are read."""
    return click.Option([name], help=text, callback=act, is_eager=True, expose_value=False, **more)


def _parameter(option: Option[Any]) -> click.Option:
    """Return the parameter of an option; one that is given twice keeps both values."""
    return click.Option(
        [f"--{option.name}", option.argument],
        is_flag=option.is_flag or None,
        multiple=not option.is_flag,
        shell_complete=_completer(_completion_of(option)),
    )


def _records(command: click.Command, ctx: click.Context) -> Iterator[tuple[str, str]]:
    """Yield the help rows of the parameters of a command that have one."""
    for parameter in command.get_params(ctx):
        if (record := parameter.get_help_record(ctx)) is not None:
            names, text = record
            yield ", ".join(sorted(names.split(", "), key=len)), text


def _row(option: Option[Any]) -> tuple[str, str]:
    return f"--{option.name} {option.metavar}".rstrip(), option.help


def _setting_row(option: Option[Any]) -> tuple[str, str]:
    return f"{option.name}={option.metavar}".rstrip("="), option.help


def _write_section(formatter: click.HelpFormatter, heading: str, rows: Rows) -> None:
    """Write two columns under a heading, without line breaks at hyphens."""
    if not rows:
        return
    indent_width = min(max(len(label) for label, _ in rows), _COLUMN_WIDTH) + 2
    with formatter.section(heading):
        indent = " " * formatter.current_indent
        for label, text in rows:
            width = formatter.width - len(indent) - indent_width
            lines = textwrap.wrap(text, width, break_on_hyphens=False)
            if len(label) + 2 > indent_width:
                lines.insert(0, "")
            for number, line in enumerate(lines):
                start = label if number == 0 else ""
                formatter.write(f"{indent}{start:{indent_width}}{line}".rstrip() + "\n")


def _first_sentence(text: str) -> str:
    return " ".join(text.partition("\n\n")[0].split())


# Shell completion


def _completer(complete: Completion | None) -> Callable[..., Any] | None:
    return None if complete is None else lambda ctx, parameter, start: complete(start)


def _from_list(values: Iterable[str]) -> Completion:
    return lambda start: [value for value in values if value.startswith(start)]


def _completion_of(option: Option[Any]) -> Completion | None:
    """Return the completion of the value of an option; None without known values."""
    if option.parse is parsing.material:
        return complete_materials
    known = list(map(str, option.parse.known))
    return _from_list(known) if known else None


def complete_materials(start: str) -> list[str]:
    """Return material names with a prefix; without a prefix, only the main names."""
    from roughcontact.material import catalog

    names = [
        name for entry in catalog.entries() for name in (entry.key, *(entry.names if start else ()))
    ]
    # A shell would split a name at a blank.
    return [name for name in _from_list(names)(start) if " " not in name]
