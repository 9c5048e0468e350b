#!/bin/bash
# Installs, upgrades and uses the packages of /packages in a bare Debian 12: in_debian.sh. scripts/check-packages runs it there, as root.
set -euo pipefail
export DEBIAN_FRONTEND=noninteractive LC_ALL=C.UTF-8
here=$(dirname "$0")
failed() { echo "check-packages: $1" >&2; exit 1; }
install() { apt-get install -y -qq --no-install-recommends --allow-downgrades "$@" >/tmp/apt.log 2>&1 || { cat /tmp/apt.log; failed "apt-get install $* fails"; }; }

# The same packages with a lower version, which the real ones then replace.
mkdir -p /tmp/lower
for package in /packages/*.deb; do
  case $package in *-dbgsym_*) continue ;; esac
  rm -rf /tmp/unpacked
  dpkg-deb --raw-extract "$package" /tmp/unpacked
  version=$(dpkg-deb --field "$package" Version)
  sed -i -e "s/^Version: .*/Version: 0.0.1/" -e "s/= ${version//./\\.})/= 0.0.1)/g" /tmp/unpacked/DEBIAN/control
  dpkg-deb --build /tmp/unpacked /tmp/lower >/dev/null
  packages+=("$package")
  names+=("$(dpkg-deb --field "$package" Package)")
done

apt-get update -qq
install /tmp/lower/*.deb
echo "FELTWIRE_SERVER_LOG_LEVEL=debug" >>/etc/default/feltwire-server
echo "installed: ${names[*]}"
install "${packages[@]}"
[ "$(dpkg-query -W -f '${Version}' feltwire-server)" = "$version" ] || failed "the upgrade left the lower version"
install --reinstall "${packages[@]}"
grep -q FELTWIRE_SERVER_LOG_LEVEL=debug /etc/default/feltwire-server || failed "the upgrade replaced a file that its owner changed"
echo "upgraded from 0.0.1 to $version, and installed again"
for compiler in cc c++ g++ gcc clang; do
  ! command -v $compiler || failed "this system should have no compiler"
done

for program in /usr/bin/feltwire-*; do
  [ -e "/usr/share/man/man1/$(basename "$program").1.gz" ] || failed "$program has no man page"
  [ "$(basename "$program")" = feltwire-mjcf ] || "$program" --version
done
# MuJoCo's reader is found, too.
feltwire-server --explain /usr/share/feltwire/scenes/arm/workcell.json >/dev/null
[ "$(ldd /usr/lib/feltwire/feltwire-nats.so | grep -c 'not found')" = 0 ] || failed "feltwire-fleet lacks a library"
systemd-analyze --man=no verify /lib/systemd/system/feltwire-server.service feltwire-server@room.service
python3 "$here/ten_lines.py"
