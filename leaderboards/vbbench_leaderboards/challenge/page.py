"""The page of a challenge: what it is, which phase is open, who leads, and how to take part.

While the challenge runs, it shows figures of the public part alone, and nothing of single sequences; after the end it
leads to full boards of both parts.
"""

from datetime import datetime
from functools import partial
from pathlib import Path

from vbbench import __version__
from vbbench.folders.work_folder import WorkFolder
from vbbench_leaderboards.challenge.organiser import Organiser, digest_of_last
from vbbench_leaderboards.challenge.standings import shown_standings
from vbbench_leaderboards.results.result import write_result
from vbbench_leaderboards.site.building import MARKER, assets, build, check_site, write_files
from vbbench_leaderboards.site.pages import render


def build_challenge(out: Path, folder: Path, moment: datetime) -> Path:
    """Write the page of the challenge in ``folder`` into ``out``; return the path of the page.

    Raises
    ------
    VbbenchError
        If ``out`` exists and is not a site, or the challenge cannot be read.
    """
    organiser = Organiser(folder)
    challenge, dataset, entries = organiser.challenge, organiser.dataset, organiser.entries
    info, over, rows = dataset.info, challenge.is_over(moment), shown_standings(organiser, moment)
    page = render(
        "challenge.html",
        challenge=challenge,
        moment=moment,
        standings=rows,
        over=over,
        taken=[(entry.team, entry.phase) for entry in entries if entry.is_accepted],
        pairs={
            "Protocol": challenge.protocol,
            "Data": f"{info.split}, tier {info.tier}, {len(dataset)} sequences, dataset {info.id}",
            "Truth": f"withheld, SHA-256 {info.truth_sha256}",
            "Log": f"{len(entries)} submissions, SHA-256 {digest_of_last(entries)}",
            "Licence": challenge.licence,
        },
    )
    own = {name: assets()[name] for name in ("assets/page.css", "assets/page.js", "assets/challenge.js")}
    with WorkFolder(out, partial(check_site, out)) as work:
        work.begin()
        work.new.mkdir()
        for part, own_rows in rows.items() if over else ():
            results = work.new / "results" / part
            for row in own_rows:
                write_result(row.result, results, organiser.record(part))
            if own_rows:
                build(work.new / part, results)
        write_files(work.new, {MARKER: f"vbbench {__version__}\n", "index.html": page, **own})
        work.publish()
    return out / "index.html"
