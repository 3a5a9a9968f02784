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
inside 'for page in /usr/share/man/man1/tactel*.1; do
  name="$(basename "$page" .1)"
  grep -A1 "^[.]SH NAME" "$page" | grep -q "^$name .- [a-z]" || { echo "$page: no NAME line"; exit 1; }
done
tactel solve --help | grep -o "docs/[a-z]*[.]md" | while read -r page; do test -s "/usr/share/doc/tactel/$page"; done
source /usr/share/bash-completion/completions/tactel
if dpkg --list | grep -i mpi | grep "^ii"; then echo "MPI is installed"; exit 1; fi
if OMPI_COMM_WORLD_SIZE=2 tactel generate /usr/share/tactel/examples/random_sweep.toml --output a.h5 2> said; then exit 1; fi
grep -q "without MPI" said
dpkg --purge tactel > /dev/null'
left="$(chroot "$root" find / -xdev -name '*tactel*' -not -path '/proc/*' -not -path '/root/*' -not -path '/var/log/*')"
if [ -n "$left" ]; then
  echo "left after the removal: $left"
  exit 1
fi
echo "installed, used and removed"
