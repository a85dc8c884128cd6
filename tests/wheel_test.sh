#!/bin/sh
# Builds the wheel, installs it into an empty environment and uses it from another folder.
set -eu
here=$(pwd)
room=$(mktemp -d)
trap 'rm -rf "$room"' EXIT
export PIP_CONSTRAINT="$here/constraints.txt" PIP_BUILD_CONSTRAINT="$here/constraints.txt"
"${PYTHON:-python3}" -m build --quiet --wheel --outdir "$room/dist" "$here"
"${PYTHON:-python3}" -m venv "$room/venv"
"$room/venv/bin/python" -m pip install --quiet "$room"/dist/*.whl
mkdir "$room/elsewhere"
cd "$room/elsewhere"
"$room/venv/bin/vbbench" splits
env -u VBBENCH_DATA "$room/venv/bin/vbbench" demo --out demo
test -s demo/index.md
"$room/venv/bin/vbbench" generate demo --limit 1 --out one
status=0
"$room/venv/bin/vbbench" render one --sequence 0 --out one.mp4 2>message || status=$?
test "$status" = 2
grep -q "pip install 'vbbench\[render\]'" message
"$room/venv/bin/python" -c "
import vbbench, vbbench_generators, vbbench_baselines, vbbench_renderers, vbbench_leaderboards
assert 'site-packages' in vbbench.__file__, vbbench.__file__
"
published=$("$room/venv/bin/python" -c "from vbbench_leaderboards.results.folder import published_results as p; print(p())")
"$room/venv/bin/vbbench" leaderboard check --results "$published"
"$room/venv/bin/vbbench" leaderboard template mine
test -s mine/mysolver.py
"$room/venv/bin/vbbench" leaderboard build --out site
test -s site/index.html && test -s site/assets/page.css && test -s site/assets/player.js
echo "wheel: installed and used from another folder"
