"""The command line: parse, call one library function, print.

Results go to stdout, everything else to stderr. Exit status: 0 success, 2 the user's mistake (one line, no traceback),
1 a failure of the program, 128 + the signal that stopped it (`vbbench.parallel.stopping`).
"""

import errno
import os
import sys
import textwrap
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from vbbench.cli import birdify, data, evaluation, exchange, reproduce, views
from vbbench.cli.parsing import columns, first_sentence, in_options, parse, wrapped
from vbbench.cli.terminal import OutputLost, check_arguments, guarded_streams, plain_output, say, say_warning
from vbbench.errors import FileError, UnknownNameError, VbbenchError, VbbenchWarning, one_line
from vbbench.version import __version__

COMMANDS: dict[str, Callable[..., Any]] = {
    "splits": data.splits,
    "tiers": data.tiers,
    "fetch": data.fetch,
    "generate": data.generate,
    "info": data.info,
    "verify": data.verify,
    "card": data.card,
    "parts": data.parts,
    "solvers": evaluation.solvers,
    "solve": evaluation.solve,
    "check": evaluation.check,
    "score": evaluation.score,
    "compare": evaluation.compare,
    "plot": views.plot,
    "render": views.render,
    "view": views.view,
    "birdify": birdify.birdify,
    "reproduce": reproduce.reproduce,
    "export csv": exchange.export_csv,
    "export mot": exchange.export_mot,
    "import mot": exchange.import_mot,
    "export tum": exchange.export_tum,
    "import tum": exchange.import_tum,
}


def all_commands() -> dict[str, Callable[..., Any]]:
    """Every command by name: the core's, and those of installed packages.

    These are entry points of the group ``vbbench.commands``. Each names a dict name → function; entry point ``tool``
    with a function ``run`` gives ``vbbench tool run``, and with one of the empty name ``vbbench tool``. A plugin that
    is broken, or whose name is taken, causes a warning.
    """
    from vbbench.registry import load_all

    found = dict(COMMANDS)
    for group, commands in load_all("command").items():
        if group in COMMANDS or not isinstance(commands, Mapping):
            reason = "its name is a command of vbbench" if group in COMMANDS else "it is not a dict of functions"
            warnings.warn(f"commands '{group}' are skipped: {reason}", VbbenchWarning, stacklevel=2)
            continue
        found |= {f"{group} {name}".strip(): function for name, function in commands.items()}
    return found


DESCRIPTION = (
    "Data, solvers and trusted numbers for view birdification. Start with: vbbench demo",
    "'vbbench COMMAND --help' lists the options of a command, 'vbbench GROUP --help' its commands.",
)

UNWRITABLE = {
    *(errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOTDIR, errno.EISDIR, errno.ELOOP, errno.ENAMETOOLONG),
    *(errno.ENOSPC, errno.EDQUOT, errno.EFBIG),
}
"""System errors that mean that the place which the user named cannot be written or read."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    warnings.showwarning = lambda message, *_where, **_more: say_warning(message)
    # A solver module:attribute may be in the current folder, which comes last: it must not hide installed modules.
    sys.path.append(os.getcwd())  # noqa: PTH109
    with guarded_streams():
        return _guarded(arguments)


def _guarded(arguments: list[str]) -> int:
    """Run the command; errors that the user can fix are printed as a message, without a traceback."""
    try:
        check_arguments(arguments)
        status = _run(arguments)
        sys.stdout.flush()
    except VbbenchError as error:
        say(str(error))
        return 2
    except OutputLost as lost:
        if lost.reason is None:
            return 0
        say(f"the output cannot be written: {lost.reason}")
        return 2
    except OSError as error:
        if error.errno not in UNWRITABLE:
            raise
        say(f"{one_line(str(error.filename or error))}: {error.strerror}; choose another place")
        return 2
    return status


def _run(arguments: list[str]) -> int:
    """Run the command and return its exit status; a command that returns ``None`` succeeded."""
    if arguments == ["--version"]:
        print(f"vbbench {__version__}")
        return 0
    if not arguments:
        raise VbbenchError("which command? 'vbbench --help' lists them")
    if arguments[0] in ("-h", "--help"):
        print(_overview(all_commands()))
        return 0
    if arguments[0].startswith("-"):
        raise UnknownNameError("option", arguments[0], ("--help", "--version"))
    commands = COMMANDS if arguments[0] in COMMANDS else all_commands()
    group = {name: function for name, function in commands.items() if name.startswith(f"{arguments[0]} ")}
    if arguments[0] not in commands and arguments[1:2] in (["-h"], ["--help"]) and group:
        print(_listing(group))
        return 0
    name, rest = _named(commands, group, arguments)
    command = parse(commands, [name, *rest])
    try:
        with plain_output():
            return command() or 0
    except VbbenchError as error:
        say(in_options(str(error), commands[name], of_file=isinstance(error, FileError)))
        return 2


def _named(
    commands: Mapping[str, Callable[..., Any]], group: Mapping[str, Any], arguments: list[str]
) -> tuple[str, list[str]]:
    """The command that the first word, or the first two of a ``group``, name; and what follows."""
    first, *rest = arguments
    if first in commands:
        return first, rest
    if group and not rest:
        known = ", ".join(sorted(name.partition(" ")[2] for name in group))
        raise VbbenchError(f"'{first}' needs one of {known}; see 'vbbench {first} --help'")
    name = " ".join(arguments[:2])
    if name not in commands:
        raise UnknownNameError("command", name if group else first, group or {each.split()[0] for each in commands})
    return name, rest[1:]


_HEADINGS = {
    "vbbench.cli.data": "datasets",
    "vbbench.cli.evaluation": "solvers",
    "vbbench.cli.views": "pictures",
    "vbbench.cli.birdify": "boxes and films",
    "vbbench.cli.exchange": "boxes and films",
    "vbbench.cli.reproduce": "the paper",
}
"""Headings of the overview by the module of a command; groups of commands are the last."""


def _overview(commands: Mapping[str, Callable[..., Any]]) -> str:
    """The help of the whole program: each command on a line, and each group of commands."""
    sections: dict[str, dict[str, str]] = {heading: {} for heading in _HEADINGS.values()}
    for name, function in commands.items():
        first, _, second = name.partition(" ")
        if second:
            known = sections.setdefault("groups of commands", {})
            known[first] = f"{known[first]}, {second}" if first in known else second
        else:
            heading = _HEADINGS.get(function.__module__, "other commands")
            sections.setdefault(heading, {})[first] = first_sentence(function)
    lines = ["usage: vbbench COMMAND ...", "", *map(wrapped, DESCRIPTION)]
    for heading, entries in sections.items():
        lines += ["", f"{heading}:", *_rows(entries)] if entries else []
    return "\n".join(lines)


def _listing(group: Mapping[str, Callable[..., Any]]) -> str:
    """The help of a group of commands."""
    first = next(iter(group)).partition(" ")[0]
    entries = {name.partition(" ")[2]: first_sentence(function) for name, function in group.items()}
    return "\n".join([f"usage: vbbench {first} NAME ...", "", *_rows(entries)])


def _rows(entries: Mapping[str, str]) -> Iterator[str]:
    for name, text in entries.items():
        yield f"  {name:18} {textwrap.shorten(text, columns() - 21, placeholder=' …')}"
