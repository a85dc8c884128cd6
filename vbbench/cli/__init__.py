"""The command line: parse, call one library function, print.

Results go to stdout, everything else to stderr. Exit status: 0 done, 2 the user's mistake (one line, no traceback),
1 a failure of the program, 128 + the signal that stopped it (`vbbench.parallel.stopping`).
"""

import contextlib
import errno
import io
import os
import re
import sys
import warnings
from collections.abc import Callable, Sequence
from typing import Any

from vbbench import __version__
from vbbench.cli import data, evaluation, exchange, reproduce, views
from vbbench.cli.plugins import plugin_commands
from vbbench.cli.terminal import OutputLost, check_arguments, guarded_streams, plain_output, say, say_warning
from vbbench.errors import UnknownNameError, VbbenchError, one_line

COMMANDS: dict[str, Callable[..., Any]] = {
    "splits": data.splits,
    "tiers": data.tiers,
    "fetch": data.fetch,
    "generate": data.generate,
    "merge": data.merge,
    "info": data.info,
    "verify": data.verify,
    "solve": evaluation.solve,
    "score": evaluation.score,
    "compare": evaluation.compare,
    "plot": views.plot,
    "render": views.render,
    "view": views.view,
    "detect": exchange.detect,
    "demo": views.demo,
    "reproduce figure-sigma": reproduce.figure_sigma,
    "reproduce table4": reproduce.table4,
    "export csv": exchange.export_csv,
    "export mot": exchange.export_mot,
    "import mot": exchange.import_mot,
    "export tum": exchange.export_tum,
    "import tum": exchange.import_tum,
}


def all_commands() -> dict[str, Callable[..., Any]]:
    """Every command by name: the core's, and those of installed packages."""
    return {**COMMANDS, **plugin_commands(COMMANDS)}


UNWRITABLE = {
    *(errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOTDIR, errno.EISDIR, errno.ELOOP, errno.ENAMETOOLONG),
    *(errno.ENOSPC, errno.EDQUOT, errno.EFBIG),
}
"""System errors that say that the user asked for a place where nothing can be written or read."""

DESCRIPTION = "Data, solvers and trusted numbers for view birdification. Start with: vbbench demo --out demo"


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    warnings.showwarning = lambda message, *_where, **_more: say_warning(message)
    # A solver named module:attribute lies where the user stands; what is there must not pass for an installed module.
    sys.path.append(os.getcwd())  # noqa: PTH109
    with guarded_streams():
        return _guarded(arguments)


def _guarded(arguments: list[str]) -> int:
    """Run the command; what the user can put right is one line."""
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
    """Run the command; what it returns is the exit status, nothing is 0."""
    if arguments == ["--version"]:
        print(f"vbbench {__version__}")
        return 0
    import tyro

    commands = COMMANDS if arguments and arguments[0] in COMMANDS else all_commands()
    commands, arguments = _chosen(commands, arguments)
    complaints = io.StringIO()
    try:
        with contextlib.redirect_stderr(complaints):
            command = tyro.extras.subcommand_cli_from_dict(
                {name: _deferred(function) for name, function in commands.items()},
                prog="vbbench",
                description=DESCRIPTION,
                args=arguments,
                config=(tyro.conf.FlagCreatePairsOff,),
            )
    except SystemExit as stop:
        if stop.code:
            raise VbbenchError(_without_frame(complaints.getvalue())) from None
        sys.stdout.flush()
        raise
    with plain_output():
        return command() or 0


def _chosen(
    commands: dict[str, Callable[..., Any]], arguments: list[str]
) -> tuple[dict[str, Callable[..., Any]], list[str]]:
    """The commands that can be meant, and the arguments with the name of two words as one."""
    if not arguments or arguments[0].startswith("-") or arguments[0] in commands:
        return commands, arguments
    group = {name: function for name, function in commands.items() if name.startswith(f"{arguments[0]} ")}
    if group and arguments[1:] and arguments[1] in ("-h", "--help"):
        return group, arguments[1:]
    if group and len(arguments) == 1:
        known = ", ".join(sorted(name.partition(" ")[2] for name in group))
        raise VbbenchError(f"'{arguments[0]}' wants one of {known}; see 'vbbench {arguments[0]} --help'")
    name = " ".join(arguments[:2])
    if name not in commands:
        raise UnknownNameError("command", name, group or commands)
    return commands, [name, *arguments[2:]]


def _deferred(function: Callable[..., Any]) -> Callable[..., Callable[[], Any]]:
    """Parse now, run later: what the command itself prints must not be taken for tyro's complaints."""
    import functools

    @functools.wraps(function)
    def parsed(*arguments: Any, **options: Any) -> Callable[[], Any]:
        return functools.partial(function, *arguments, **options)

    return parsed


def _without_frame(complaint: str) -> str:
    """Tyro's boxed message as one line."""
    text = re.sub(r"\x1b\[[0-9;]*m|[╭╮╰╯│─]", " ", complaint)
    return " ".join(text.split())
