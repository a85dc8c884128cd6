"""A download that continues an interrupted one."""

import os
from pathlib import Path
from typing import Any

from vbbench.files.tables import file_sha256
from vbbench.folders.locks import BusyError, close_early, is_file_at, lock_file

PARTIAL = ".partial"
"""Ending of the name of an incomplete file."""
_CHUNK = 2**12
"""Bytes received at a time; an incomplete chunk is not kept."""


class ResumingDownload:
    """A file from the network that becomes ``target`` when it is complete and its checksum is right.

    Received bytes are kept under a temporary name, whatever stops this process, and the next attempt requests the rest.
    If the checksum of the whole is wrong, it is deleted, and the next attempt starts again.

    Parameters
    ----------
    target : path of the complete file.
    sha256 : 64 hex digits of its bytes.
    most : most bytes that are accepted; ``None`` for any number.
    timeout : seconds without an answer after which the download fails.
    """

    def __init__(self, target: Path, sha256: str, *, most: int | None, timeout: float) -> None:
        self.target, self.sha256 = target, sha256
        self.most, self.timeout = most, timeout
        self.partial = target.with_name(target.name + PARTIAL)

    def fetch(self, url: str) -> None:
        """Download ``url``.

        Raises BusyError if another command is downloading the file, OSError if the server cannot be reached or stops
        (received bytes are kept), ValueError if it sends more than ``most`` bytes or the checksum is wrong.
        """
        self.target.parent.mkdir(parents=True, exist_ok=True)
        with self.partial.open("ab") as file:
            if not lock_file(file.fileno()) or not is_file_at(file.fileno(), self.partial):
                raise BusyError(f"{self.target} is being downloaded by another command; wait until it is done")
            try:
                self._continue(url)
                if file_sha256(self.partial) != self.sha256:
                    raise ValueError(f"its SHA-256 is not {self.sha256}")
            except BaseException as error:
                if isinstance(error, ValueError) or not self.partial.stat().st_size:
                    close_early(file)
                    self.partial.unlink()
                raise
            os.fsync(file.fileno())
            close_early(file)
            self.partial.replace(self.target)

    def _continue(self, url: str) -> None:
        import requests

        have = self.partial.stat().st_size
        if have and have == self.most:
            return
        headers = {"Accept-Encoding": "identity"} | ({"Range": f"bytes={have}-"} if have else {})
        with requests.get(url, stream=True, timeout=self.timeout, headers=headers) as response:
            refused = have > 0 and response.status_code == requests.codes.requested_range_not_satisfiable
            if not refused:
                response.raise_for_status()
                goes_on = response.headers.get("Content-Range", "").startswith(f"bytes {have}-")
                self._append(response, have if goes_on else 0)
        if refused:
            self.partial.write_bytes(b"")
            self._continue(url)

    def _append(self, response: Any, have: int) -> None:
        """Append the response to the first ``have`` bytes."""
        from tqdm import tqdm

        rest = response.headers.get("Content-Length")
        total = None if rest is None else have + int(rest)
        bar = tqdm(total=total, initial=have, unit="B", unit_scale=True, disable=None)
        with self.partial.open("ab" if have else "wb") as file, bar:
            for chunk in response.iter_content(_CHUNK):
                have += len(chunk)
                if self.most is not None and have > self.most:
                    raise ValueError(f"more than {self.most} bytes came")
                file.write(chunk)
                bar.update(len(chunk))
