#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# The packages of a folder in a bare Debian, without a compiler: bare_root.sh deb|wheel FOLDER [SUITE], the suite bookworm unless named.
#   deb    installed, `tactel demo` and two processes run, an alarm, a network and a controller made, purged without a trace
#   wheel  installed into an environment of the suite's Python, refused without an OpenCL device, run with that of pip
# Takes root, debootstrap, a Debian mirror, for wheel also PyPI. Prints the seconds to the first answer.
set -euo pipefail

kind="$1" packages="$2" suite="${3:-bookworm}"
root="$(mktemp -d)"
leave() {
  umount -l "$root/proc" "$root/sys" "$root/dev" 2> /dev/null || true
  rm -rf --one-file-system "$root"
}
trap leave EXIT
debootstrap --variant=minbase "$suite" "$root" > /dev/null
mount -t proc proc "$root/proc"
mount -t sysfs sys "$root/sys"
mount --rbind /dev "$root/dev"
cp /etc/resolv.conf "$root/etc/"
cp /etc/ssl/certs/ca-certificates.crt "$root/root"
cp "$packages"/*."${kind/wheel/whl}" "$root/root"

inside() {
  chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root DEBIAN_FRONTEND=noninteractive \
    PIP_CERT=/root/ca-certificates.crt bash -euc "cd /root; $1"
}
fail() { echo "$*" && exit 1; }
said() { echo "$1: $((SECONDS - start)) s" && start=$SECONDS; }

deb() {
  local before after left
  before="$(inside 'dpkg --list | grep -c "^ii"')"
  inside 'apt-get install -y --no-install-recommends ./tactel_*.deb > /dev/null'
  after="$(inside 'dpkg --list | grep -c "^ii"')"
  said "installation of $((after - before)) packages"
  [ $((after - before)) -lt 65 ] || fail "$((after - before)) packages are installed"
  inside 'tactel solve /usr/share/tactel/examples/parabola.toml | grep "the whole contact slides"'
  said "first answer"
  inside 'tactel demo --output demo; test -s demo/contact.html; test -s demo/networks.html'
  said "demo"
  inside 'sed -n "/^cat > grip/,/^END/p" /usr/share/doc/tactel/docs/pad-to-alarm.md > grip.sh; . ./grip.sh
  pad="simulate:grip.toml?rest=3&hold=1&time_constant=0"
  tactel record --source "$pad" --seconds 4.7 --output hold.rec --quiet
  tactel tare --source "$pad" --output pad.toml --hold hold.rec 2> said
  tactel monitor --source "$pad&paced=0" --calibration pad.toml --rest --alarm --quiet > lines
  grep -m 1 "\"alarm\": true" lines | grep "\"true_slip_index\": 0[.]8"'
  said "an alarm, of which the pad plays 10 s"
  inside 'tactel generate /usr/share/tactel/examples/random_sweep.toml --output learn.h5 --quiet
  tactel train learn.h5 --output networks --network 42-42-21-1 --scaling frame --cycles 5 --quiet
  tactel recall networks learn.h5 --json errors.json > /dev/null; test -s errors.json'
  said "a set of 100 000 contacts and a network of it"
  inside 'apt-get install -y --no-install-recommends g++ pkg-config ./tactel-dev_*.deb > /dev/null
  sed -n "/^.. controller.cpp/,/^}$/p" /usr/share/doc/tactel/README.md > controller.cpp
  c++ -std=c++20 controller.cpp -o controller $(pkg-config --cflags --libs tactel); ./controller'
  said "a compiler, and a controller"
  inside 'for page in /usr/share/man/man1/tactel*.1; do
    name="$(basename "$page" .1)"
    grep -A1 "^[.]SH NAME" "$page" | grep -q "^$name .- [a-z]" || { echo "$page: no NAME line"; exit 1; }
    [ "$name" = tactel ] || grep -q "^[.]SH EXAMPLES" "$page" || { echo "$page: no example"; exit 1; }
    [[ "$name" =~ ^tactel(-calibrate)?$ ]] || grep -A1 "^[.]SH OPTIONS" "$page" | grep -q "^[.]SS" || { echo "$page: no groups of options"; exit 1; }
  done
  tactel solve --help | grep -o "docs/[a-z]*[.]md" | while read -r page; do test -s "/usr/share/doc/tactel/$page"; done
  tactel solve --help | grep -o "examples/[a-z]*[.]toml" | while read -r scene; do test -s "/usr/share/tactel/$scene"; done
  source /usr/share/bash-completion/completions/tactel
  if dpkg-query --show | grep -E "openmpi|mpich"; then echo "MPI is installed"; exit 1; fi
  sed "s/^contacts .*/contacts = 300/" /usr/share/tactel/examples/random_sweep.toml > sweep.toml
  if OMPI_COMM_WORLD_SIZE=2 tactel generate sweep.toml --output a.h5 2> said; then exit 1; fi
  grep -q "tactel-mpi" said
  apt-get install -y --no-install-recommends ./tactel-mpi_*.deb > /dev/null
  export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
  tactel generate sweep.toml --output one.h5 --quiet
  mpirun --oversubscribe -n 2 tactel-mpi generate sweep.toml --output two.h5 --quiet
  cmp one.h5 two.h5
  dpkg --purge tactel-mpi tactel-dev tactel > /dev/null'
  left="$(chroot "$root" find / -xdev -name '*tactel*' -not -path '/proc/*' -not -path '/root/*' -not -path '/var/log/*')"
  [ -z "$left" ] || fail "left after the removal: $left"
}

wheel() {
  local python
  inside 'apt-get install -y --no-install-recommends python3-venv > /dev/null; python3 -m venv venv'
  python="$(inside 'python3 -c "import sys; print(\"cp%d%d\" % sys.version_info[:2])"')"
  start=$SECONDS
  inside "venv/bin/pip install -q ./tactel-*-$python-*.whl"
  said "installation of the wheel for $python"
  inside 'if ldconfig -p | grep -E "OpenCL|hdf5|libusb"; then echo "the root is not bare"; exit 1; fi
  code=0; venv/bin/tactel solve venv/share/tactel/examples/parabola.toml 2> said || code=$?
  test $code = 3; grep "apt install pocl-opencl-icd.*pip install intel-opencl-rt" said'
  start=$SECONDS
  inside "venv/bin/pip install -q \"\$(ls ./tactel-*-$python-*.whl)[device]\""
  said "installation of a device"
  inside 'venv/bin/tactel solve venv/share/tactel/examples/parabola.toml | grep "the whole contact slides"'
  said "first answer"
  inside 'cd venv/share/tactel/examples
  ../../../bin/tactel solve parabola.toml --json /root/answer.json > /dev/null
  sed "s/^contacts .*/contacts = 300/" random_sweep.toml > sweep.toml
  ../../../bin/tactel generate sweep.toml --output /root/set.h5 --quiet
  ../../../bin/python -c "
import json, numpy, tactel
steps = json.load(open(\"/root/answer.json\"))[\"steps\"]
path = tactel.solve(tactel.read_scene(\"parabola.toml\"))
assert numpy.array_equal([step[\"slip_index\"] for step in steps], path.slip_index), path.slip_index
assert len(tactel.read_set(\"/root/set.h5\").frames) > 300
steps = tactel.PadStepper(tactel.Pad(tactels=(4, 4), pitch=2, thickness=4, young=0.5, poisson=0.48), 1000, friction=0.6, cells=12, cell=0.6)
steps.shapes(tactel.Sphere(radius=8))
assert abs(steps.press([1.0, 0.1, 0, 0]).slip_index - 0.1 / 0.6).max() < 2e-3
"'
  said "the module, the same numbers"
  inside 'venv/bin/tactel generate venv/share/tactel/examples/sweep.toml --output again.h5 2> said; cmp set.h5 again.h5
  if grep compiling said; then exit 1; fi
  for run in 1 2 3 4; do
    taskset -c 0 venv/bin/tactel train set.h5 --network 6 --schedule batch --cycles 30 --output networks --force --quiet
    sha256sum networks/*.onnx
  done > sums; test "$(sort -u sums | wc -l)" = 1'
  said "kept kernels, networks with the same bits in four runs"
}

inside 'apt-get update -qq'
start=$SECONDS
"$kind"
echo "installed and used"
