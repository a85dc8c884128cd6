"""Where the work of a study is done; light enough for the command line to read."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import arg

PLAIN = arg(help_behavior_hint="")
"""Says nothing in ``--help`` of a default that says nothing."""


@dataclass(frozen=True, kw_only=True)
class Work:
    """Where the work is done, and whether what is there is used."""

    jobs: int = 1
    """Processes; the numbers do not depend on it."""
    scheduler: Annotated[str | None, PLAIN] = None
    """Address of a Dask cluster (tcp://...) that makes datasets and submissions instead."""
    tls: Annotated[Path | None, PLAIN] = None
    """Folder with the certificates (ca.pem, cert.pem, key.pem) of a cluster whose address is tls://..."""
    overwrite: Annotated[bool, PLAIN] = False
    """Generate and solve everything again."""
