#!/bin/bash
# Purges the packages of /packages, and finds what they left: purge.sh. scripts/check-packages runs it, as root.
set -euo pipefail
export DEBIAN_FRONTEND=noninteractive LC_ALL=C.UTF-8
here=$(dirname "$0")
failed() { echo "check-packages: $1" >&2; exit 1; }
# The packages with debugging symbols are not installed, and apt knows nothing of them.
for package in /packages/*.deb; do
  name=$(dpkg-deb --field "$package" Package)
  if dpkg-query --show "$name" >/dev/null 2>&1; then names+=("$name"); fi
done

apt-get purge -y -qq "${names[@]}" >/tmp/apt.log 2>&1 || { cat /tmp/apt.log; failed "apt-get purge fails"; }
left=$(find / -xdev \( -path /proc -o -path /packages -o -path "$here" -o -path /tmp -o -path /var/cache \) -prune -o -iname '*feltwire*' -print)
[ -z "$left" ] || failed "after the purge there is still $left"
echo "purged; nothing is left but the system user feltwire"
