# shellcheck shell=bash
# Shared functions of the scripts.  After sourcing this file the current folder is the repository's
# root, and any error ends the script.
set -euo pipefail
kScript=$(realpath "$0")  # resolved before the folder changes, since it may be a relative path
readonly kScript
cd "$(dirname "${BASH_SOURCE[0]}")/.."

say() { printf '%s\n' "$*"; }
fail() { printf '%s: %s\n' "${0##*/}" "$*" >&2; exit 1; }
wrong_usage() { printf '%s: %s (see --help)\n' "${0##*/}" "$*" >&2; exit 2; }

# Prints the comment at the head of the script: its help, written once.
print_help() { sed -n '2,/^$/s/^# \{0,1\}//p' "$kScript"; }

# quietly TITLE LOG COMMAND...: runs the command with its output in the log; shows one line, and the
# log's end if the command fails.
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

# Settings of ccache: share results between checkouts of the same sources, and cache compilations
# with precompiled headers, for which it needs the sloppiness.
export CCACHE_BASEDIR=$PWD CCACHE_NOHASHDIR=1 CCACHE_SLOPPINESS=pch_defines,time_macros

# configure PRESET OPTION...: also if that has been done, since packages may have come meanwhile, and with
# them targets.  It takes a second then.
configure() {
  quietly "configuring $1" "build/logs/configure-$1.log" cmake --preset "$@"
}

# build PRESET TARGET...: configures and builds.
build() {
  configure "$1" && compile "$@"
}

# compile PRESET TARGET...: builds what is configured.
compile() {
  local preset=$1
  shift
  if [[ -t 1 ]]; then  # ninja shows its progress in one line
    NINJA_STATUS="building $preset %f/%t " ninja -C "build/$preset" "$@"
  else
    quietly "building $preset" "build/logs/build-$preset.log" ninja -C "build/$preset" "$@"
  fi
}

# --- processes that run beside a script ---

# start LOG COMMAND...: runs the command in the background, detached from the terminal (Ctrl-C goes
# to this script, which ends its processes in order); the kernel ends it if this script is killed.
start() {
  local log=$1
  shift
  : >"$log"  # emptied at once, so that no lines of the last run are found
  setsid setpriv --pdeathsig TERM "$@" >"$log" 2>&1 </dev/null &
}

# stop PID NAME: sends SIGTERM, waits 5 s, then kills; removes the socket that a killed
# process leaves.
stop() {
  local pid=$1 name=$2
  [[ -n $pid ]] || return 0
  kill -TERM "$pid" 2>/dev/null || true
  for ((i = 0; i < 100; i++)); do
    kill -0 "$pid" 2>/dev/null || break
    sleep 0.05
  done
  if kill -KILL "$pid" 2>/dev/null; then say "$name did not end within 5 s and was killed"; fi
  wait "$pid" 2>/dev/null || true
  rm -f "/tmp/iceoryx_rt_${pid}_"*
}

# await_line REGEX LOG PID SECONDS: waits until the log has such a line; false if the process ends
# or the time is over first.
await_line() {
  local deadline=$((SECONDS + $4))
  until grep -qE "$1" "$2"; do
    kill -0 "$3" 2>/dev/null && ((SECONDS < deadline)) || return 1
    sleep 0.05
  done
}

fail_with_log() {
  say "$1. The end of $2:"
  tail -n 25 "$2" | sed 's/^/    /'
  exit 1
}

readonly kPools=deploy/cyclonedds/roudi.toml

# The memory that RouDi needs in /dev/shm: 66 MB of its own, and its pools, each chunk with a header
# of 40 B and 64 B of RouDi's management data.  REALTIME.md and others state the sum; a test
# compares them.
shared_memory_needed_MB() {
  awk -F= '/^size/ { size = $2 + 104 } /^count/ { bytes += size * $2 }
           END { print int(66 + bytes / 1e6 + 1) }' $kPools
}

# RouDi holds this lock while it runs.
readonly kRouDiLock=/tmp/iox-unique-roudi.lock
roudi_runs() { [[ -e $kRouDiLock ]] && ! flock -n $kRouDiLock true; }

# A RouDi that has ended leaves its lock file, and one that was killed its management data.  Only
# its own user may open these, so another user's RouDi would not start.
forget_ended_roudi() {
  ((EUID == 0)) && ! roudi_runs || return 0
  rm -f $kRouDiLock /tmp/roudi /tmp/roudi.lock /dev/shm/iceoryx_mgmt
}

# Sets `as_user` to the words that run a command as that user and group, without root's
# rights except those that a loop needs: by limits, or by two capabilities if this root may
# not raise limits.
set_as_user() {
  as_user=(setpriv --reuid "$1" --regid "$2" --clear-groups --no-new-privs)
  if prlimit --rtprio=45 --memlock=unlimited true 2>/dev/null; then
    as_user=(prlimit --rtprio=45 --memlock=unlimited "${as_user[@]}" --bounding-set=-all)
  else
    local rights=-all,+sys_nice,+ipc_lock
    as_user+=("--inh-caps=$rights" "--ambient-caps=$rights" "--bounding-set=$rights")
  fi
}

# --- a minimal Debian, for containers and for trying packages ---

readonly kDebian=build/debian/bookworm.tar

# Makes a minimal Debian 12 in $kDebian unless it exists, with debootstrap, from the mirror of this
# host's apt or debootstrap's default.
make_debian() {
  local folder mirrors as_root=()
  [[ ! -f $kDebian ]] || return 0
  ((EUID == 0)) || as_root=(sudo)
  folder=$(mktemp -d)
  # shellcheck disable=SC2016  # apt's own variable
  mapfile -t mirrors < <(apt-get indextargets --format '$(SITE)' 'Codename: bookworm' \
    'Created-By: Packages' 2>/dev/null | sort -u)
  quietly "making a minimal Debian 12" build/logs/debootstrap.log \
    "${as_root[@]}" debootstrap --variant=minbase bookworm "$folder/root" "${mirrors[@]:0:1}" || return
  mkdir -p "${kDebian%/*}"
  "${as_root[@]}" tar -C "$folder/root" -c . >"$kDebian.part"
  mv "$kDebian.part" $kDebian
  "${as_root[@]}" rm -rf "$folder"
}
