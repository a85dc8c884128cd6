"""A command line from functions: options and help from their parameters and docstrings, parsed by argparse.

Positional-only parameters are arguments; all others, and the fields of a parameter that is a dataclass, are options.
The docstring is the help: a text before ``Args:``, and one for each parameter after it.
"""

import argparse
import inspect
import re
import shutil
import textwrap
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import MISSING, dataclass, fields, is_dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal, NoReturn, get_args, get_origin, get_type_hints

from vbbench.errors import UnknownNameError, VbbenchError, quoted, suggestion


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """An argument or option of a command.

    Parameters
    ----------
    parameter, field : name of the function's parameter, and of the field if that is a dataclass.
    kind : its type.
    default : its default; `inspect.Parameter.empty` if it is required.
    help : its description.
    positional : whether it is an argument, not an option.
    """

    parameter: str
    field: str = ""
    kind: Any
    default: Any
    help: str
    positional: bool = False

    @property
    def option(self) -> str:
        """The option's name."""
        return f"--{(self.field or self.parameter).replace('_', '-')}"

    @property
    def key(self) -> str:
        """The name of its value in argparse's namespace."""
        return self.parameter if self.positional else self.option

    @property
    def shown(self) -> str:
        """Its name in help and messages."""
        return self.parameter.upper().replace("_", "-") if self.positional else self.option

    @property
    def opposite(self) -> str:
        """The flag that turns a flag off: ``--no-film``."""
        return f"--no-{self.option[2:]}"

    @property
    def required(self) -> bool:
        """Whether it must be given."""
        return self.default is inspect.Parameter.empty

    @property
    def shown_default(self) -> str:
        """The default as text; "" if there is none, or it is obvious."""
        if self.required or self.default in (None, (), "") or isinstance(self.default, bool):
            return ""
        items = self.default if isinstance(self.default, tuple) else (self.default,)
        return f" (default: {' '.join(map(str, items))})"


@dataclass(frozen=True)
class Further:
    """Annotation of a parameter that takes NAME=VALUE: the names are also options, ``--NAME VALUE``.

    Parameters
    ----------
    names : returns the names with their types; a bool is a flag: ``--NAME`` or ``--no-NAME``.
    """

    names: Callable[[], Mapping[str, Any]]


def named(kind: str, words: Iterable[str], kinds: Mapping[str, Any]) -> dict[str, Any]:
    """Values by name from words NAME=VALUE, each of its type in ``kinds``.

    Raises UnknownNameError, which calls them of this ``kind``, for another name, and VbbenchError for another value.
    """
    found = {}
    for word in words:
        name, equals, value = word.partition("=")
        name = name.replace("-", "_")
        if not equals or name not in kinds:
            raise UnknownNameError(kind, name, kinds)
        try:
            found[name] = _type(kinds[name])[0](value)
        except argparse.ArgumentTypeError as error:
            raise VbbenchError(f"{name}: {error}") from error
    return found


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        raise VbbenchError(f"{message.removeprefix('argument ')}; see '{self.prog} --help'")


def parse(commands: Mapping[str, Callable[..., Any]], arguments: Sequence[str]) -> Callable[[], Any]:
    """The call for ``arguments``: the name of one of ``commands``, then its arguments and options.

    Raises VbbenchError if they are invalid; the message is one line; SystemExit if they request help, which is printed.
    """
    name, *given = arguments
    function = commands[name]
    parameters = list(parameters_of(function))
    parser = _parser(name, function, parameters)
    read = vars(parser.parse_intermixed_args(list(_spelled(name, function, parameters, given))))
    values = {each: read.get(each.key, each.default) for each in parameters}
    missing = [each.shown for each, value in values.items() if value is inspect.Parameter.empty]
    if missing:
        parser.error(f"the following arguments are required: {', '.join(missing)}")
    positional: list[Any] = []
    options: dict[str, Any] = {}
    for each, value in values.items():
        value = tuple(value) if isinstance(value, list) else value
        if each.positional:
            positional.append(value)
        elif each.field:
            options.setdefault(each.parameter, {})[each.field] = value
        else:
            options[each.parameter] = value
    hints = get_type_hints(function)
    made = {key: hints[key](**value) if is_dataclass(hints[key]) else value for key, value in options.items()}
    return partial(function, *positional, **made)


def parameters_of(function: Callable[..., Any]) -> Iterator[Parameter]:
    """Every argument and option of a command."""
    hints, texts = get_type_hints(function), _sections(function)[1]
    for name, parameter in inspect.signature(function).parameters.items():
        kind: Any = hints[name]
        if is_dataclass(kind):
            inner, words = get_type_hints(kind), _sections(kind)[1]
            for each in fields(kind):
                default = inspect.Parameter.empty if each.default is MISSING else each.default
                text = words.get(each.name, "")
                yield Parameter(parameter=name, field=each.name, kind=inner[each.name], default=default, help=text)
        else:
            positional = parameter.kind is parameter.POSITIONAL_ONLY
            default = () if positional and get_origin(kind) is tuple else parameter.default
            yield Parameter(parameter=name, kind=kind, default=default, help=texts.get(name, ""), positional=positional)


def first_sentence(function: Callable[..., Any]) -> str:
    """The first sentence of a command's help, on one line."""
    return re.split(r"(?<=[.])\s", " ".join(_sections(function)[0].split()), maxsplit=1)[0]


def columns() -> int:
    """Width of the terminal, limited to a readable one."""
    return max(60, min(shutil.get_terminal_size().columns, 120))


def wrapped(text: str) -> str:
    """The text with each paragraph filled to the width of the terminal; indented ones stay."""
    paragraphs = text.split("\n\n")
    return "\n\n".join(each if "\n " in f"\n{each}" else textwrap.fill(each, columns()) for each in paragraphs)


def _sections(documented: Any) -> tuple[str, dict[str, str]]:
    """The text of a docstring before ``Args:``, and that of each parameter."""
    head, _, rest = (inspect.getdoc(documented) or "").partition("\nArgs:\n")
    entries = re.findall(r"^    (\w+): (.*(?:\n {8}.*)*)", rest, re.MULTILINE)
    return head.strip(), {name: " ".join(text.split()) for name, text in entries}


def _parser(name: str, function: Callable[..., Any], parameters: Iterable[Parameter]) -> _Parser:
    prog = f"vbbench {name}"
    parser = _Parser(
        prog=prog,
        add_help=False,
        allow_abbrev=False,
        formatter_class=lambda prog: argparse.RawDescriptionHelpFormatter(prog, max_help_position=22, width=columns()),
    )
    groups = {title: parser.add_argument_group(title) for title in ("arguments", "required", "options")}
    usage = [prog]
    for each in parameters:
        reads, metavar, count = _type(each.kind)
        text = f"{each.help}{each.shown_default}".replace("%", "%%")
        shape: dict[str, Any] = {"type": reads, "help": text, "default": argparse.SUPPRESS}
        if count:
            shape["nargs"] = count
        if each.positional:
            shape |= {} if count else {"nargs": "?", "default": each.default}
            groups["arguments"].add_argument(each.key, metavar=each.shown, **shape)
            usage.append(f"[{each.shown} ...]" if count else each.shown if each.required else f"[{each.shown}]")
            continue
        title = "required" if each.required else f"{each.parameter} options" if each.field else "options"
        group = groups.setdefault(title, groups.get(title) or parser.add_argument_group(title))
        if each.kind is bool:
            look: dict[str, Any] = {"dest": each.key, "default": argparse.SUPPRESS}
            group.add_argument(each.option, action="store_true", help=text, **look)
            group.add_argument(each.opposite, action="store_false", help=argparse.SUPPRESS, **look)
            continue
        if count == "*":
            shape["action"] = "extend"  # a second one adds to the first
        group.add_argument(each.option, dest=each.key, metavar=metavar, **shape)
        if each.required:
            usage.append(f"{each.option} {metavar}")
    groups["options"].add_argument("-h", "--help", action="help", help="show this and exit")
    parser.usage, parser.description = (
        " ".join([*usage, "[options]"]),
        wrapped(_sections(function)[0]).replace("%", "%%"),
    )
    return parser


def _spelled(
    name: str, function: Callable[..., Any], parameters: Iterable[Parameter], given: Iterable[str]
) -> Iterator[str]:
    """The arguments with hyphens for underscores in options; raises UnknownNameError for an unknown option."""
    parameters = [each for each in parameters if not each.positional]
    listed = [each.option for each in parameters]
    flags = {option for each in parameters if each.kind is bool for option in (each.option, each.opposite)} | {"--help"}
    words = iter(given)
    for argument in words:
        if re.match("-[a-z]{2}", argument):
            raise UnknownNameError(
                f"option of '{name}'", argument.partition("=")[0], [*listed, *further_options(function)]
            )
        if not argument.startswith("--") or argument == "--":
            yield argument
            continue
        option, equals, value = argument.partition("=")
        option = option.replace("_", "-")
        if option in listed or option in flags:
            if equals and option in flags:
                raise VbbenchError(f"{option} takes no value; write {option} alone")
            yield f"{option}{equals}{value}"
            continue
        further = further_options(function)
        if option not in further:
            if not (listed or further):
                raise VbbenchError(f"'{name}' has no options; remove {argument}")
            raise UnknownNameError(f"option of '{name}'", argument.partition("=")[0], [*listed, *further])
        parameter, written, kind, flag = further[option]
        text = flag or (value if equals else next(words, "--"))
        try:
            if text.startswith("--"):
                raise argparse.ArgumentTypeError("expected one argument")
            _type(kind)[0](text)
        except argparse.ArgumentTypeError as error:
            raise VbbenchError(f"{option}: {error}; see 'vbbench {name} --help'") from error
        yield f"--{parameter}={written}={text}"


def further_options(function: Callable[..., Any]) -> dict[str, tuple[str, str, Any, str]]:
    """Options that stand for NAME=VALUE of a parameter: option → its parameter, name, type, and a flag's value."""
    found: dict[str, tuple[str, str, Any, str]] = {}
    for parameter, hint in get_type_hints(function, include_extras=True).items():
        for each in get_args(hint)[1:] if get_origin(hint) is Annotated else ():
            if isinstance(each, Further):
                for name, kind in each.names().items():
                    option, is_flag = name.replace("_", "-"), bool in get_args(kind)
                    found[f"--{option}"] = parameter, name, kind, "true" if is_flag else ""
                    if is_flag:
                        found[f"--no-{option}"] = parameter, name, kind, "false"
    return found


def _type(kind: Any) -> tuple[Callable[[str], Any], str, str | int | None]:
    """The parser of a type's values, their name in help, and argparse's number of values."""
    if get_origin(kind) is tuple:
        inner, *others = get_args(kind)
        reads, metavar, _ = _type(inner)
        return reads, metavar, "*" if others == [...] else 1 + len(others)
    options = [each for each in get_args(kind) if each is not type(None)] if not _is_plain(kind) else [kind]
    if len(options) == 1 and not _is_plain(options[0]):
        return _type(options[0])
    names = [f"{{{','.join(get_args(each))}}}" if get_origin(each) is Literal else each.__name__ for each in options]
    return partial(_read, options), "|".join(name if name[0] == "{" else name.upper() for name in names), None


def _is_plain(kind: Any) -> bool:
    return (isinstance(kind, type) and get_origin(kind) is None) or get_origin(kind) is Literal


_NUMBERS = {int: "a whole number", float: "a number"}


def _read(kinds: Sequence[Any], text: str) -> Any:
    """The text as a value of the first of ``kinds`` that accepts it."""
    wanted: list[str] = []
    for kind in kinds:
        if get_origin(kind) is Literal:
            if text in get_args(kind):
                return text
            wanted.append(suggestion(text, get_args(kind)) if len(kinds) == 1 else " or ".join(get_args(kind)))
        elif kind in _NUMBERS:
            try:
                return kind(text)
            except ValueError:
                wanted.append(f"must be {_NUMBERS[kind]}")
        elif kind is Path and not text:
            raise argparse.ArgumentTypeError("is empty; name a file or folder")
        else:
            return kind(text)
    if len(wanted) == 1 and not wanted[0].startswith("must"):
        raise argparse.ArgumentTypeError(f"cannot be {quoted(text)}; {wanted[0]}")
    raise argparse.ArgumentTypeError(f"{' or '.join(wanted)}, not {quoted(text)}")


_NAMED = (
    r"`(\w+)(?:=True)?`",
    r"(?:^|(?<=[:;] ))(\w+)(?= (?:must (?:not )?be\b|is a number of\b))",
)
"""How messages of the library name a parameter; by the second also what stands in a file under the same name."""

_ALIASES = {"height_std": "sigma_h"}
"""Parameters of the library whose options have other names."""


def in_options(message: str, function: Callable[..., Any], *, of_file: bool = False) -> str:
    """A message of the library with a command's options in place of parameters: ``--limit`` for ``limit``.

    In a message ``of_file``, required values are the file's and stay.
    """
    options = {name: option for option, (_, name, _kind, flag) in further_options(function).items() if flag != "false"}
    options |= {each.field or each.parameter: each.option for each in parameters_of(function) if not each.positional}
    for pattern in _NAMED[:1] if of_file else _NAMED:
        message = re.sub(pattern, lambda found: options.get(_ALIASES.get(found[1], found[1]), found[0]), message)
    return message
