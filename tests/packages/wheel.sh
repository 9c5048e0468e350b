#!/bin/bash
# Installs the wheel of /packages in an environment of its own, and lets a hand feel a plane: wheel.sh. scripts/check-packages runs it in
# systems that have python3-venv.
set -euo pipefail
here=$(dirname "$0")
environment=$(mktemp -d)
python3 -m venv "$environment"
"$environment/bin/pip" install --quiet --no-index /packages/*.whl
"$environment/bin/python" "$here/ten_lines.py"
"$environment/bin/python" -c 'import feltwire.gym, feltwire.isaac, feltwire.lerobot; from importlib import metadata
print("LeRobot finds", metadata.distribution("lerobot_teleoperator_feltwire").metadata["Name"])'
"$environment/bin/feltwire-client" --version
"$environment/bin/feltwire-lab" compare --help >/dev/null
rm -rf "$environment"
echo "the wheel works with $(ldd --version | head -n 1), $(python3 --version)"
