"""``vbbench train vb-former``: the weights of the learned solver, or of your own, from simulated crowds."""

from pathlib import Path


def train_vb_former(
    out: Path,
    seed: int = 0,
    recipe: Path | None = None,
    part: float = 1.0,
    device: str = "cpu",
    jobs: int = 1,
) -> None:
    """Train the solver vb-former on simulated crowds, or go on where that was stopped.

    Args:
        out: Folder of the training; curve.png shows how it goes, and it ends with weights.npz.
        seed: Of the first weights and of what is drawn from the crowds.
        recipe: TOML file that says what is trained on; default: that of the weights that come with vbbench.
        part: Make so many sequences, and learn from so many windows, next to what the recipe says: .01 tries it out.
        device: Of PyTorch, such as cuda; only on cpu are the weights the same each time.
        jobs: Processes that make crowds, then draw from them ahead of the training; nothing depends on it.
    """
    import sys

    from vbbench.errors import VbbenchError, needs_extra

    if not 0.0 < part <= 100.0:
        raise VbbenchError(f"--part is above 0 and at most 100, not {part:g}")
    if not 0 <= seed < 2**63:
        raise VbbenchError(f"--seed is from 0 to 2^63 - 1, not {seed}")
    with needs_extra("torch", "training"):
        from vbbench_baselines.former.training.loop import Asked, train
        from vbbench_baselines.former.training.recipe import read_recipe
    asked = Asked(recipe=read_recipe(recipe), seed=seed, part=part)
    path = train(out, asked, device=device, jobs=jobs)
    sys.stderr.write(f"{path}\n")


COMMANDS = {"vb-former": train_vb_former}
"""What ``vbbench train`` can train."""
