"""A download that goes on where an interrupted one stopped."""

from pathlib import Path
from typing import Any

PARTIAL = ".partial"
"""What is added to the name of a file that is not whole yet."""
_CHUNK = 2**12
"""Bytes taken at a time; of a chunk that is cut short nothing is kept."""


class ResumingDownloader:
    """Does the downloading for pooch, which then compares the checksum and gives the file its name.

    What came before an interruption is kept under a name of its own, and the server is asked for the rest. If that
    turns out to be of another file, the checksum is wrong, everything is thrown away, and the next try starts anew.

    Parameters
    ----------
    target : name that the whole file will have.
    most : no more bytes than this are taken; ``None`` for any number.
    timeout : seconds without an answer after which the download is given up.
    progress : whether to draw a bar on stderr.
    """

    def __init__(self, target: Path, *, most: int | None, timeout: float, progress: bool) -> None:
        self.most, self.timeout, self.progress = most, timeout, progress
        self.partial = target.with_name(target.name + PARTIAL)

    def __call__(self, url: str, output_file: str, _: Any) -> None:
        """Download ``url`` to ``output_file``, a name of this download alone.

        Raises
        ------
        OSError
            If the server cannot be had, or stops; what came is kept.
        ValueError
            If more comes than `most`.
        """
        part = Path(output_file)
        if self.partial.is_file():
            self.partial.replace(part)  # whoever gets it has it alone, should two fetch at once
        try:
            self._go_on(url, part)
        except BaseException as error:
            if not isinstance(error, ValueError) and part.stat().st_size:
                part.replace(self.partial)
            raise

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
