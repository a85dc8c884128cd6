"""From the functions behind commands to options with help, and from arguments to a call."""

import contextlib
import functools
import inspect
import io
import sys
from collections.abc import Callable, Mapping, Sequence
from typing import Annotated, Any, Union, get_origin, get_type_hints

from vbbench.cli.mistakes import check_options, explain
from vbbench.errors import VbbenchError

DESCRIPTION = "Data, solvers and trusted numbers for view birdification. Start with: vbbench demo --out demo"


def parse(commands: Mapping[str, Callable[..., Any]], arguments: Sequence[str]) -> Callable[[], Any]:
    """The call that the arguments ask for, one of ``commands``.

    Raises
    ------
    VbbenchError
        If they are wrong; one line says why.
    SystemExit
        When help was asked for and printed.
    """
    import tyro

    name = next((argument for argument in arguments[:1] if argument in commands), "")
    if name:
        check_options(name, commands[name], arguments[1:])
    complaints = io.StringIO()
    try:
        with contextlib.redirect_stderr(complaints):
            call: Callable[[], Any] = tyro.cli(
                _subcommands(commands),
                prog="vbbench",
                description=DESCRIPTION,
                args=arguments,
                config=(
                    *(tyro.conf.FlagCreatePairsOff, tyro.conf.DisallowNone),
                    tyro.conf.PositionalMetavarFromFieldName,
                ),
            )
    except SystemExit as stop:
        if stop.code:
            raise VbbenchError(explain(complaints.getvalue(), name, commands.get(name))) from None
        sys.stdout.flush()
        raise
    return call


def _subcommands(commands: Mapping[str, Callable[..., Any]]) -> Any:
    """A type with a member for each command, as of `tyro.extras.subcommand_cli_from_dict`.

    Its members are `object` where that has `Any`, for which tyro imports typeguard (0.06 s).
    """
    import tyro

    members = [
        Annotated[object, tyro.conf.subcommand(name=name, constructor=_deferred(function))]
        for name, function in commands.items()
    ]
    return Union[(*members, Annotated[None, tyro.conf.Suppress])]


def _deferred(function: Callable[..., Any]) -> Callable[..., Callable[[], Any]]:
    """Parse now, run later, so that the command's own output is not taken for tyro's messages.

    ``--help`` does not show trivial defaults such as None.
    """
    import tyro

    @functools.wraps(function)
    def parsed(*arguments: Any, **options: Any) -> Callable[[], Any]:
        return functools.partial(function, *arguments, **options)

    hints, kinds = get_type_hints(function, include_extras=True), get_type_hints(function)
    signature = inspect.signature(function)
    for name, parameter in signature.parameters.items():
        silent = parameter.default in ((), None) or isinstance(parameter.default, bool)
        if silent or (parameter.default is parameter.empty and get_origin(kinds[name]) is tuple):
            hints[name] = Annotated[hints[name], tyro.conf.arg(help_behavior_hint="")]
    del parsed.__wrapped__  # tyro would use its signature
    parsed.__annotations__ = hints
    parsed.__signature__ = signature.replace(  # type: ignore[attr-defined]
        parameters=[each.replace(annotation=hints[name]) for name, each in signature.parameters.items()]
    )
    return parsed
