#!/bin/sh
# Builds the sdist and from it the wheel, checks both, installs the wheel into an empty environment and uses it from another folder.
# With a folder DIST, what was built and tried stays there, for a release; the wheel of the tree is in DIST/tree.
set -eu
here=$(pwd)
python=${PYTHON:-python3}
room=$(mktemp -d)
trap 'rm -rf "$room"' EXIT
export PIP_CONSTRAINT="$here/constraints.txt" PIP_BUILD_CONSTRAINT="$here/constraints.txt"
export PIP_NO_COMPILE=1  # little of what is installed is ever imported
"$python" -m build --quiet --config-setting cmake.define.VBBENCH_WERROR=ON --outdir "$room/dist" "$here"  # the wheel from the sdist
"$python" -m build --quiet --wheel --config-setting cmake.build-type=Debug --outdir "$room/tree" "$here"  # its files are compared
"$python" -m release.artefacts "$room/dist" "$room"/tree/*.whl
"$python" -m venv "$room/venv"
"$room/venv/bin/python" -m pip install --quiet "$room"/dist/*.whl
"$room/venv/bin/vbbench" --version
"$room/venv/bin/python" -m pip install --quiet --dry-run 'vbbench[pandas]'  # extras of what is installed, by its name
if "$room/venv/bin/python" -m pip install --quiet uv; then
  "$room/venv/bin/uv" pip install --quiet --dry-run --python "$room/venv" -c "$here/constraints.txt" "$room"/dist/*.whl
fi
mkdir "$room/elsewhere"
cd "$room/elsewhere"
"$room/venv/bin/vbbench" splits
"$room/venv/bin/vbbench" generate demo --limit 1 --out one
"$room/venv/bin/vbbench" solve one --solver vb-former --protocol sequential --out followed  # its weights are a file
"$room/venv/bin/vbbench" score followed --dataset one --per-sequence rows.csv
"$room/venv/bin/vbbench" plot one --sequence 0 --estimate followed --out one.png
test -s one.png && test -s rows.csv
"$room/venv/bin/vbbench" export mot one --out mot
"$room/venv/bin/vbbench" solvers
status=0
"$room/venv/bin/vbbench" render one --sequence 0 --out one.mp4 2>message || status=$?
test "$status" = 2
grep -q "pip install 'vbbench\[render\]'" message
"$room/venv/bin/python" -c "
import vbbench, vbbench_generators, vbbench_baselines, vbbench_renderers, vbbench_leaderboards
from vbbench_baselines import _core
assert 'site-packages' in vbbench.__file__, vbbench.__file__
assert 'site-packages' in _core.__file__, _core.__file__
_core.Estimator()
from vbbench_baselines.joint_map import MapCausal
MapCausal(carried_by='robot')
"
published=$("$room/venv/bin/python" -c "from vbbench_leaderboards.results.folder import published_results as p; print(p())")
"$room/venv/bin/vbbench" leaderboard check --results "$published"
"$room/venv/bin/vbbench" leaderboard export --board hotel/sequential-field --format bibtex
"$room/venv/bin/vbbench" leaderboard template mine
test -s mine/mysolver.py
"$room/venv/bin/vbbench" leaderboard build --out site
test -s site/index.html && test -s site/assets/page.css && test -s site/assets/player.js
test -s site/tables/hotel/sequential-field.tex
if [ -n "${DIST:-}" ]; then mkdir -p "$here/$DIST" && cp -r "$room"/dist/* "$room/tree" "$here/$DIST"; fi
echo "wheel: built from the sdist, installed, and used from another folder"
