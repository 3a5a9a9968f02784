# SPDX-License-Identifier: Apache-2.0

# What the scripts share: to be sourced, from the repository's root.

say() { echo "tactel: $*" >&2; }

# Says every half minute how long a step takes, with the last line of its log.
heartbeat() {
  local what="$1" log="$2" start=$SECONDS never
  exec {never}<> <(:)  # nothing ever comes: a sleep without a process that would outlive this one
  while true; do
    read -rt 30 -u "$never" || true
    say "$what, $((SECONDS - start)) s: $(tail -n 1 "$log" | tr '\r' '\n' | tail -n 1 | cut -c 1-100)"
  done
}

# Runs a command; its output is shown only if it fails: step WHAT COMMAND...
step() {
  local what="$1" log pulse status=0
  shift
  log="$(mktemp)"
  heartbeat "$what" "$log" &
  pulse=$!
  trap 'kill "$pulse" 2> /dev/null' EXIT
  "$@" > "$log" 2>&1 || status=$?
  kill "$pulse" && wait "$pulse" 2> /dev/null || true
  trap - EXIT
  if [ "$status" -ne 0 ]; then grep -v '^\[[0-9]*/[0-9]*\]' "$log" >&2 || true; fi
  rm -f "$log"
  return "$status"
}
