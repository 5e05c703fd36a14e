# SPDX-License-Identifier: LGPL-2.1-or-later
# Sourced by the commands of this repository: what they need, installed and built. Expects $root, the repository.

# as_root COMMAND...
as_root() {
  if [ "$(id -u)" = 0 ]; then "$@"; elif command -v sudo >/dev/null; then sudo "$@"; else
    echo "needs root or sudo to run: $*" >&2
    return 1
  fi
}

# ensure_packages KIND...: installs what tests/packages lists for these kinds and is missing. Quiet unless it fails.
ensure_packages() {
  local kinds=" $* " kind package log
  local -a missing=()
  while read -r kind package _; do
    [[ $kind == '#'* || -z $kind || $kinds != *" $kind "* ]] && continue
    [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || missing+=("$package")
  done <"$root/tests/packages"
  [ ${#missing[@]} = 0 ] && return 0
  echo "installing ${missing[*]}" >&2
  log=$(mktemp)
  if ! { as_root apt-get update -q &&
    as_root env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends "${missing[@]}"; } \
    >"$log" 2>&1 </dev/null; then
    tail -n 20 "$log" >&2
    rm -f "$log"
    echo "could not install: ${missing[*]}; install them by hand and try again" >&2
    return 1
  fi
  rm -f "$log"
}

# configure DIR [MESON OPTIONS]: sets a build folder up, or gives an existing one these options.
configure() {
  local dir=$1
  shift
  if [ -f "$dir/build.ninja" ]; then
    [ $# = 0 ] || meson configure "$dir" "$@"
  else
    meson setup "$dir" "$root" "$@"
  fi
}
