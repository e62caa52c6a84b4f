#!/bin/sh
# manual.sh PROGRAM PAGE.gz [NAME VERSION]: a manual of the program's own --help; a script, which does not
# say them itself, has a name and a version.
set -eu
program=$1
page=$2
command -v help2man >/dev/null || {
  echo "help2man is missing: deploy/setup --for packages installs it" >&2
  exit 1
}
help2man --no-info --no-discard-stderr --section 1 \
  --name "${3:-$("$program" --help | sed -n '1{s/[:.,;] .*//;p}')}" ${4:+--version-string "$4"} \
  "$program" >"$page.part"
gzip -9n <"$page.part" >"$page"
rm "$page.part"
