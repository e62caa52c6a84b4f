# shellcheck shell=bash
# What the scripts share; sourced, after which the current folder is the repository's root and
# an error ends the script.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

say() { printf '%s\n' "$*"; }
fail() { printf '%s: %s\n' "${0##*/}" "$*" >&2; exit 1; }
wrong_usage() { printf '%s: %s (see --help)\n' "${0##*/}" "$*" >&2; exit 2; }

# Prints the comment at the head of the script: its help, written once.
print_help() { sed -n '2,/^$/s/^# \{0,1\}//p' "$0"; }

# quietly TITLE LOG COMMAND...: runs the command with its output in the log; shows a line, and the
# log's end where the command fails.
quietly() {
  local title=$1 log=$2 start=$SECONDS status=0
  shift 2
  mkdir -p "$(dirname "$log")"
  printf '%s … ' "$title"
  "$@" >"$log" 2>&1 </dev/null || status=$?
  if ((status == 0)); then
    say "done ($((SECONDS - start)) s)"
  else
    say "failed (exit $status). The end of $log:"
    tail -n 25 "$log" | sed 's/^/    /'
  fi
  return "$status"
}

# build PRESET TARGET...: configures where needed and builds, with ccache.
build() {
  local preset=$1 log=build/logs/build-$1.log
  shift
  if [[ ! -f build/$preset/build.ninja ]]; then
    quietly "configuring $preset" "build/logs/configure-$preset.log" cmake --preset "$preset" ||
      return
  fi
  if [[ -t 1 ]]; then  # ninja shows its progress in one line
    NINJA_STATUS="building $preset %f/%t " cmake --build --preset "$preset" --target "$@"
  else
    quietly "building $preset" "$log" cmake --build --preset "$preset" --target "$@"
  fi
}
