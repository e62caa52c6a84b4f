#!/bin/sh
# manual.sh PROGRAM PAGE.gz [NAME VERSION]: writes a manual page from the --help of a program and of
# each of its commands.  NAME and VERSION are for scripts, which do not print them.
set -eu
program=$1
page=$2
command -v help2man >/dev/null || {
  echo "help2man is missing: deploy/setup --for packages installs it" >&2
  exit 1
}
# Writes a section for each command, from its --help; "Subcommands:" lists them, indented by
# two spaces.
commands=$page.commands
"$program" --help | sed -n '/^Subcommands:/,/^$/s/^  \([a-z][a-z-]*\).*/\1/p' | while read -r command; do
  printf '[COMMAND %s]\n.nf\n' "$command"
  "$program" "$command" --help | sed 's/\\/\\e/g; s/-/\\-/g; s/^[.'"'"']/\\\&&/'
  printf '.fi\n\n'
done >"$commands"
has_commands=$(head -c 1 "$commands")
help2man --no-info --no-discard-stderr --section 1 ${has_commands:+--include "$commands"} \
  --name "${3:-$("$program" --help | sed -n '1{s/[:.,;] .*//;s/\.$//;p}')}" ${4:+--version-string "$4"} \
  "$program" >"$page.part"
gzip -9n <"$page.part" >"$page"
rm "$page.part" "$commands"
