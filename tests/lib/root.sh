# SPDX-License-Identifier: LGPL-2.1-or-later
# Sourced by tests/distro and tests/debian: an empty Debian for experiments, and the count of attempts.
# Expects the command's name in $name, for messages.

passed=0 failed=0 child=

die() {
  echo "$name: $1" >&2
  exit "${2:-1}"
}

# apart COMMAND...: runs it with its own mounts and processes, which end with it. To be run in the background.
apart() {
  exec unshare --mount --propagation private --pid --kill-child "$@"
}

# new_root SUITE [FOLDER]: debootstraps into FOLDER, empty or new, or into a temporary one that is removed at the end.
# Sets $folder, and $logs unless it is set; logs are kept.
new_root() {
  local suite=$1 tool mirror
  [ "$(id -u)" = 0 ] || die 'needs root'
  for tool in debootstrap unshare git; do command -v $tool >/dev/null || die "install $tool first"; done

  # The machine's own apt source of this suite. Else that of its own suite, which has the other suites, too.
  mirror=${CSDTRACK_MIRROR:-$(apt-get indextargets --format '$(CODENAME) $(SUITE) $(COMPONENT) $(REPO_URI)' 2>/dev/null |
    awk -v suite="$suite" -v own="$(. /etc/os-release && echo "$VERSION_CODENAME")" '$3 != "main" { next }
      $1 == suite || $2 == suite { found = $4; exit } $1 == own && !other { other = $4 } END { print found ? found : other }')}
  [ -n "$mirror" ] || die "this machine's apt has no source of Debian: give one in CSDTRACK_MIRROR"

  if [ $# = 2 ]; then
    folder=$2
    mkdir -p "$folder" && [ -z "$(ls -A "$folder")" ] || die "'$folder' is not empty"
  else
    folder=$(mktemp -d "${TMPDIR:-/tmp}/csdtrack-$suite.XXXXXX") || exit 1
    trap 'rm -rf --one-file-system "$folder"' EXIT
    chmod 755 "$folder"  # it is / for users such as munge's, whose daemon would not start otherwise
  fi
  folder=$(cd "$folder" && pwd)
  logs=${logs:-$folder.log}
  mkdir -p "$logs" || exit 1
  # unshare ignores weaker signals.
  trap 'kill -KILL ${child:-} 2>/dev/null; wait; exit 130' INT TERM HUP

  echo "$suite into $folder"
  apart debootstrap --variant=minbase "$suite" "$folder" "$mirror" >"$logs/debootstrap.log" 2>&1 &
  child=$!
  wait $child || { tail -n 5 "$logs/debootstrap.log" >&2; die 'debootstrap failed'; }
  # Copies this machine's network settings, and none of its other configuration.
  cp -L /etc/resolv.conf /etc/hosts "$folder/etc/" 2>/dev/null
  apt-config dump --no-empty --format '%F "%v";%n' Acquire::http Acquire::https Acquire::Check-Valid-Until \
    Acquire::Check-Date 2>/dev/null | grep ' "..*"' >"$folder/etc/apt/apt.conf.d/90-machine"
  mkdir -p "$folder/home/csdtrack"
}

# inside COMMAND...: runs it in the new system, with a clean environment.
inside() {
  apart bash -c '
    folder=$0
    mount -t proc proc "$folder/proc" && mount --rbind /dev "$folder/dev" && mount -t sysfs -o ro sysfs "$folder/sys" &&
      exec chroot "$folder" /usr/bin/env -i HOME=/root TERM=dumb LANG=C.UTF-8 \
        PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin \
        bash -c "cd /home/csdtrack && exec \"\$@\"" bash "$@"' "$folder" "$@" </dev/null
}

# attempt NAME COMMAND...: runs it and counts success or failure.
attempt() {
  local name=$1 start=$SECONDS
  shift
  # In the background, so that signals take effect at once.
  "$@" >"$logs/$name.log" 2>&1 &
  child=$!
  if wait $child; then
    passed=$((passed + 1))
    printf 'ok      %s (%d s)\n' "$name" $((SECONDS - start))
  else
    failed=$((failed + 1))
    printf 'FAILED  %s (%d s), its end:\n' "$name" $((SECONDS - start))
    tail -n 25 "$logs/$name.log" | sed 's/^/        /'
    return 1
  fi
}

# tell: prints the last line and exits with the result.
tell() {
  echo "$passed passed, $failed failed"
  [ $failed = 0 ]
  exit
}
