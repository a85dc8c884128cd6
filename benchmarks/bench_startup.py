"""How long `vbbench --help` and `import vbbench` take, beside a bare Python: best of several, wall time."""

import argparse
import subprocess
import sys
import time

REPEATS = 7
COMMANDS = {
    "python -c pass": (["-c", "pass"], None),
    "import vbbench": (["-c", "import vbbench"], 0.05),
    "vbbench --help": (["-m", "vbbench", "--help"], 0.3),
    "vbbench --version": (["-m", "vbbench", "--version"], None),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=REPEATS)
    runs = parser.parse_args().runs
    print(f"{'':<20}{'best':>10}{'target':>10}")
    for name, (arguments, target) in COMMANDS.items():
        best = min(_seconds(arguments) for _ in range(runs))
        wanted = "" if target is None else f"{target:.2g} s"
        missed = "  missed" if target is not None and best >= target else ""
        print(f"{name:<20}{best:>8.3f} s{wanted:>10}{missed}")


def _seconds(arguments: list[str]) -> float:
    started = time.perf_counter()
    subprocess.run([sys.executable, *arguments], check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - started


if __name__ == "__main__":
    main()
