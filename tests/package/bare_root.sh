#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# The Debian package in a bare Debian 12: installed, `tactel demo` run, purged without a trace: bare_root.sh FOLDER_OF_PACKAGES
# Takes root, debootstrap and a Debian mirror.
set -euo pipefail

packages="$1"
root="$(mktemp -d)"
leave() {
  umount -l "$root/proc" "$root/sys" "$root/dev" 2> /dev/null || true
  rm -rf --one-file-system "$root"
}
trap leave EXIT
debootstrap --variant=minbase bookworm "$root" > /dev/null
mount -t proc proc "$root/proc"
mount -t sysfs sys "$root/sys"
mount --rbind /dev "$root/dev"
cp /etc/resolv.conf "$root/etc/"
cp "$packages"/tactel_*.deb "$root/root/tactel.deb"

inside() { chroot "$root" env DEBIAN_FRONTEND=noninteractive HOME=/root bash -euc "$1"; }
inside 'apt-get update -qq; apt-get install -y --no-install-recommends /root/tactel.deb > /dev/null'
start=$SECONDS
inside 'cd /root; tactel demo --output demo; test -s demo/contact.html; test -s demo/networks.html'
echo "demo: $((SECONDS - start)) s"
inside 'test -s /usr/share/man/man1/tactel.1; source /usr/share/bash-completion/completions/tactel; dpkg --purge tactel > /dev/null'
left="$(chroot "$root" find / -xdev -name '*tactel*' -not -path '/proc/*' -not -path '/root/*' -not -path '/var/log/*')"
if [ -n "$left" ]; then
  echo "left after the removal: $left"
  exit 1
fi
echo "installed, used and removed"
