"""Where and how a study is made; light enough for the command line to read."""

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, kw_only=True)
class Work:
    """Where and how a study is made, and what is printed of it.

    Args:
        out: Folder for the report, and for datasets and submissions; what it holds is reused. Default: named after the
            study.
        seed: Seed of all random numbers.
        jobs: Processes; the numbers do not depend on it.
        scheduler: Address of a Dask cluster (tcp://...) that makes datasets and submissions instead.
        tls: Folder with the certificates (ca.pem, cert.pem, key.pem) of a cluster whose address is tls://...
        overwrite: Generate and solve everything again.
        json: Print every number as JSON instead of the tables.
    """

    out: Path | None = None
    seed: int = 0
    jobs: int = 1
    scheduler: str | None = None
    tls: Path | None = None
    overwrite: bool = False
    json: bool = False


@dataclass(frozen=True, kw_only=True)
class Downloads:
    """Where the user's own downloads are; by default they are searched in the usual places.

    Args:
        kitti: Folder of KITTI's tracking benchmark, as for 'vbbench generate kitti --source'.
        poses: Folder of the poses of KITTI's camera, as for 'vbbench generate kitti --poses'.
        jrdb: Folder of JRDB, as for 'vbbench generate jrdb --source'.
        bags: Folder of JRDB's rosbags, which hold how the robot moved.
        motsynth: Folder or file of MOTSynth's annotations, as for 'vbbench generate motsynth --source'.
    """

    kitti: Path | None = None
    poses: Path | None = None
    jrdb: Path | None = None
    bags: Path | None = None
    motsynth: Path | None = None
