"""Licences in the words of programs: a hub's identifier and a web address, from the text of a split."""

import re

_CREATIVE_COMMONS = re.compile(r"CC[ -](BY(?:-(?:NC|SA|ND))*)[ -]([1-4]\.\d)", re.IGNORECASE)
_NAMED = {
    "Apache-2.0": ("apache-2.0", "https://www.apache.org/licenses/LICENSE-2.0"),
    "CC0": ("cc0-1.0", "https://creativecommons.org/publicdomain/zero/1.0/"),
    "MIT": ("mit", "https://opensource.org/license/mit"),
}


def hub_identifier(licence: str) -> str:
    """What Hugging Face calls a licence: ``unknown`` where none is stated, ``other`` where its list has it not."""
    if licence.startswith("none stated"):
        return "unknown"
    known = _known(licence)
    return known[0] if known else "other"


def licence_address(licence: str) -> str | None:
    """Web address of a licence's text, if it is a well-known one."""
    known = _known(licence)
    return known[1] if known else None


def _known(licence: str) -> tuple[str, str] | None:
    """Identifier and address of the licence that a text begins with."""
    if found := _CREATIVE_COMMONS.match(licence):
        kind, version = found[1].lower(), found[2]
        return f"cc-{kind}-{version}", f"https://creativecommons.org/licenses/{kind}/{version}/"
    return next((facts for name, facts in _NAMED.items() if re.match(rf"{name}\b", licence)), None)
