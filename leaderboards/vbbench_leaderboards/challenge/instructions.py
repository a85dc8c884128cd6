"""How to take part in one challenge: its commands, which run as they are, and its rules and dates in Markdown."""

from vbbench.files.dataset_info import DatasetInfo, describe
from vbbench_leaderboards.challenge.definition import Challenge, Phase

OWN_RULES = (
    "A solver uses boxes, camera, dt, the prior of heights, and what the protocol gives. It does not look for the "
    "truth or the seed.",
    "Nothing learned from one sequence is used in another.",
    "An answer depends on its own frame and earlier ones, or `delay` says in submission.json that it does not.",
)
"""Of the rules of all boards, those that a challenge cannot do without."""

_SOLVER = "mysolver:MySolver"


def solving_commands(challenge: Challenge) -> list[str]:
    """From the unpacked bundle to a submission that is checked, with the template's solver."""
    return [
        "vbbench leaderboard template mine",
        "cd mine",
        f"vbbench solve ../data --solver {_SOLVER} --protocol {challenge.protocol} --out answer",
        "vbbench challenge check answer --challenge ..",
    ]


def practice_commands(challenge: Challenge) -> list[str]:
    """A set like the secret one, whose truth is at hand, and a score on it."""
    return [
        challenge.data.command("--seed 1", "--out practice"),
        f"vbbench solve practice --solver {_SOLVER} --protocol {challenge.protocol} --out practice-answer",
        "vbbench score practice-answer --dataset practice",
    ]


def unpacking_commands(challenge: Challenge) -> list[str]:
    """From the archive to the folder in which the other commands run."""
    return [f"unzip {challenge.name}.zip", f"cd {challenge.name}"]


def phase_words(phase: Phase) -> str:
    """What a phase is for."""
    told = "scores are told at once" if phase.part == "public" else "scores are told when it has closed"
    return f"counts on the {phase.part} part of the sequences, whose {told}"


def parts_words(challenge: Challenge) -> str:
    """How the secret set is divided, and what a participant knows of it."""
    if challenge.hidden_phase is None:
        return "A part of the sequences counts. Which ones follows from the secret seed."
    return (
        f"About {challenge.data.public_share:.0%} of the sequences are the public part, the others the hidden one. A "
        "submission answers all of them. Which are which follows from the secret seed, and nobody is told before the "
        "end."
    )


def missing_words(challenge: Challenge) -> str:
    """What becomes of a gap."""
    if challenge.missing_rows == "refuse":
        return "Every row that is scored must be there."
    return "A missing row counts as the last one known, if submission.json declares the failure policy 'hold'."


def readme(challenge: Challenge, data: DatasetInfo) -> str:
    """The text of the bundle's ``README.md``."""
    about = "\n\n".join(challenge.about)
    phases = "\n".join(
        f"| {phase.name} | {phase.start} | {phase.end} | {phase.part} | {phase.submissions} |"
        for phase in challenge.phases
    )
    return f"""# {challenge.title}

{about}

Held by {challenge.organisers}. Questions and submissions: {challenge.contact}

| phase | first day | last day | part that counts | submissions of a team |
|---|---|---|---|---:|
{phases}

Days are whole days in UTC. {parts_words(challenge)}

## What is here

| | |
|---|---|
| `data` | the dataset, without truth |
| `challenge.toml` | the challenge, for `vbbench challenge check` |
| `RULES.md`, `LICENCE.txt` | rules; the licence of the data |
| `SHA256SUMS` | of every file: `sha256sum --check SHA256SUMS` |

{_indented(describe(data).splitlines())}

The truth is withheld. Its SHA-256 stands above; it will be published after the end, and everybody can compare.

## Take part

In this folder, with vbbench installed:

{_indented(solving_commands(challenge))}

`mine/mysolver.py` is yours to change. Say in its `facts` who you are, and what it was trained and tuned on: a
submission without them is refused. Programs in other languages hand in CSV:
`vbbench export csv data --out boxes` writes what a solver may see. {missing_words(challenge)}

Send the folder `answer` to {challenge.contact}

## Practise

A set of the same kind, with truth:

{_indented(practice_commands(challenge))}

## Rules

{_numbered(challenge)}
"""


def rules_text(challenge: Challenge) -> str:
    """The text of the bundle's ``RULES.md``."""
    return f"# Rules of {challenge.title}\n\n{_numbered(challenge)}\n"


def _numbered(challenge: Challenge) -> str:
    return "\n".join(f"{n}. {rule}" for n, rule in enumerate((*OWN_RULES, *challenge.rules), 1))


def _indented(lines: list[str]) -> str:
    return "\n".join(f"    {line}" for line in lines)
