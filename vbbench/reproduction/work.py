"""Where the work of a study is done; light enough for the command line to read."""

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, kw_only=True)
class Work:
    """Where the work is done, and whether what is there is used.

    Args:
        jobs: Processes; the numbers do not depend on it.
        scheduler: Address of a Dask cluster (tcp://...) that makes datasets and submissions instead.
        tls: Folder with the certificates (ca.pem, cert.pem, key.pem) of a cluster whose address is tls://...
        overwrite: Generate and solve everything again.
    """

    jobs: int = 1
    scheduler: str | None = None
    tls: Path | None = None
    overwrite: bool = False
