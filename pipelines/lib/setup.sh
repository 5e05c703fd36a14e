# SPDX-License-Identifier: LGPL-2.1-or-later
# Sourced by the commands of this repository: installs and builds what they need, and runs them. Expects $root, the repository.

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

# make_in DIR TARGET...: sets DIR up ($options: for configure, if any) and builds these in it. Commands that start at the same
# time take turns, as two ninjas in one folder would break each other's work.
make_in() {
  local dir=$1
  shift
  mkdir -p "$dir" && (
    flock 9
    configure "$dir" "${options[@]}" && ninja -C "$dir" "$@"
  ) 9<"$dir"
}

# build_for COMMAND TARGET...: builds these in $build, quietly unless it fails, and lets GStreamer find the plugin there.
# $options: for configure, if any.
build_for() {
  local command=$1 target output
  shift
  for target in "$@"; do
    [ -f "$build/$target" ] || { echo "building csdtrack, once; this takes some minutes" >&2; break; }
  done
  if ! output=$(make_in "$build" "$@" 2>&1 </dev/null); then
    printf '%s\n' "$output" | grep -m5 -A3 -E 'error:|ERROR:' >&2
    echo "$command: csdtrack could not be built; 'ninja -C $build $*' shows all" >&2
    return 1
  fi
  export GST_PLUGIN_PATH_1_0=$build/gst${GST_PLUGIN_PATH_1_0:+:$GST_PLUGIN_PATH_1_0} GST_REGISTRY=$build/gst-registry.bin
  export GST_PRESET_PATH=$root/gst/presets${GST_PRESET_PATH:+:$GST_PRESET_PATH}
}

# run_module MODULE ARGUMENTS...: goes on as a Python module of this repository. The processes that it starts import from the repository, too.
# -P: nothing is imported from the working directory.
run_module() {
  export PYTHONPATH=$root${PYTHONPATH:+:$PYTHONPATH}
  exec /usr/bin/python3 -B -P -m "$@"
}

# run_program NAME ARGUMENTS...: what pipelines/NAME does: installs and builds what lib/NAME.py needs, and runs it. That
# program reads the arguments; --help and what it refuses need no build.
run_program() {
  local name=$1 argument install=yes
  shift
  (run_module "pipelines.lib.$name" --check "$@") || exit $?
  for argument in "$@"; do
    case $argument in -h | --help) exit 0 ;; --no-install) install=no ;; esac
  done
  [ $install = no ] || ensure_packages run || exit 1
  build=${CSDTRACK_BUILD:-$root/build} options=()
  build_for "$name" gst/libgstcsdtrack.so || exit 1
  run_module "pipelines.lib.$name" "$@"
}
