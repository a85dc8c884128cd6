"""A download that goes on where an interrupted one stopped."""

import os
from pathlib import Path
from typing import Any

from vbbench.files.tables import file_sha256
from vbbench.folders.locks import BusyError, is_file_at, lock_file

PARTIAL = ".partial"
"""What is added to the name of a file that is not whole yet."""
_CHUNK = 2**12
"""Bytes taken at a time; of a chunk that is cut short nothing is kept."""


class ResumingDownload:
    """A file of the network that becomes ``target`` when it is whole and its checksum is right.

    What comes is kept under a name of its own, whatever stops this process, and the server is asked for the rest.
    If that turns out to be of another file, the checksum is wrong, all is thrown away, and the next try starts anew.

    Parameters
    ----------
    target : name that the whole file will have.
    sha256 : 64 hex digits of its bytes.
    most : no more bytes than this are taken; ``None`` for any number.
    timeout : seconds without an answer after which the download is given up.
    progress : whether to draw a bar on stderr.
    """

    def __init__(self, target: Path, sha256: str, *, most: int | None, timeout: float, progress: bool) -> None:
        self.target, self.sha256 = target, sha256
        self.most, self.timeout, self.progress = most, timeout, progress
        self.partial = target.with_name(target.name + PARTIAL)

    def fetch(self, url: str) -> None:
        """Download ``url``.

        Raises
        ------
        BusyError
            If another command is downloading the file.
        OSError
            If the server cannot be reached, or stops; what came is kept.
        ValueError
            If more comes than `most`, or other bytes.
        """
        self.target.parent.mkdir(parents=True, exist_ok=True)
        with self.partial.open("ab") as file:
            if not lock_file(file.fileno()) or not is_file_at(file.fileno(), self.partial):
                raise BusyError(f"{self.target} is being downloaded by another command; wait until it is done")
            try:
                self._go_on(url, self.partial)
                if file_sha256(self.partial) != self.sha256:
                    raise ValueError(f"its SHA-256 is not {self.sha256}")
            except BaseException as error:
                if isinstance(error, ValueError) or not self.partial.stat().st_size:
                    self.partial.unlink()
                raise
            os.fsync(file.fileno())
            self.partial.replace(self.target)

    def _go_on(self, url: str, part: Path) -> None:
        import requests

        have = part.stat().st_size
        if have and have == self.most:
            return
        headers = {"Accept-Encoding": "identity"} | ({"Range": f"bytes={have}-"} if have else {})
        with requests.get(url, stream=True, timeout=self.timeout, headers=headers) as response:
            refused = have > 0 and response.status_code == requests.codes.requested_range_not_satisfiable
            if not refused:
                response.raise_for_status()
                goes_on = response.headers.get("Content-Range", "").startswith(f"bytes {have}-")
                self._take(response, part, have if goes_on else 0)
        if refused:
            part.write_bytes(b"")
            self._go_on(url, part)

    def _take(self, response: Any, part: Path, have: int) -> None:
        """Append what comes to the first ``have`` bytes."""
        from tqdm import tqdm

        rest = response.headers.get("Content-Length")
        total = None if rest is None else have + int(rest)
        bar = tqdm(total=total, initial=have, unit="B", unit_scale=True, disable=not self.progress)
        with part.open("ab" if have else "wb") as file, bar:
            for chunk in response.iter_content(_CHUNK):
                have += len(chunk)
                if self.most is not None and have > self.most:
                    raise ValueError(f"more than {self.most} bytes came")
                file.write(chunk)
                bar.update(len(chunk))
