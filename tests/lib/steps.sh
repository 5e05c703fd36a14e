# SPDX-License-Identifier: LGPL-2.1-or-later
# Sourced by tests/run, tests/more, tests/long and tests/coverage: the steps, the counts, the times. Expects $root and
# pipelines/lib/setup.sh. A step is a function step_NAME. It reports by check(), check_build() and meson_tests().

passed=0 failed=0 skipped=0
build_seconds=0 sources=0
logs=$root/build/logs
mkdir -p "$logs"
jobs=$(nproc)

# check NAME COMMAND...: one check, passed if the command succeeds. Its output is shown only if it fails.
check() {
  local name=$1 log start=$SECONDS
  shift
  log=$logs/${name//[^a-zA-Z0-9]/-}.log
  if "$@" >"$log" 2>&1 </dev/null; then
    passed=$((passed + 1))
    printf 'ok      %s (%d s)\n' "$name" $((SECONDS - start))
  else
    failed=$((failed + 1))
    printf 'FAILED  %s (%d s)\n' "$name" $((SECONDS - start))
    grep -E -A4 'error:|FAILED:|ERROR' "$log" | head -n 40 | sed 's/^/        /'
    tail -n 15 "$log" | sed 's/^/        /'
    echo "        all of it: $log"
    return 1
  fi
}

# check_build NAME COMMAND...: a check whose time counts as build time. It also counts the files that ninja compiles and
# that syntax.py checks.
check_build() {
  local start=$SECONDS log=$logs/${1//[^a-zA-Z0-9]/-}.log status
  check "$@"
  status=$?
  build_seconds=$((build_seconds + SECONDS - start))
  sources=$((sources + $(grep -cE '^\[[0-9]+/[0-9]+\] (Compiling|Precompiling)|^checked ' "$log")))
  return $status
}

# read_words [ARGUMENT...]: sets `steps` to the named ones of `every_step`, or to all, and sets `install`. For --help it calls
# usage() and exits. Unknown words are errors.
read_words() {
  local word command=tests/${0##*/}
  steps=() install=
  for word; do
    case $word in
      -h | --help) usage; exit 0 ;;
      --no-install) install=--no-install ;;
      *) [[ " ${every_step[*]} " == *" $word "* ]] || { echo "$command: no step '$word' (see $command --help)" >&2; exit 2; }
        steps+=("$word") ;;
    esac
  done
  [ ${#steps[@]} -gt 0 ] || steps=("${every_step[@]}")
}

# ready [--no-install] KIND...: installs the packages of these kinds in tests/packages, and says what will be skipped.
ready() {
  local clips=${CSDTRACK_CLIPS:-$root/../shared/clips}
  if [ "$1" = --no-install ]; then shift; else
    ensure_packages "$@" || exit 1
    # Decimal commas often break code that writes numbers.
    if ! locale -a | grep -qi '^de_DE\.utf-\?8$'; then
      as_root localedef -i de_DE -f UTF-8 de_DE.UTF-8 || exit 1
    fi
  fi
  [ -d "$clips" ] || echo "no clips in $clips: tests on real video skip"
}

# run_steps STEP...: runs them in turn. Then prints a table of their times and the last line, and exits with the result.
run_steps() {
  local prefix=step_ step start spent
  [ "${0##*/}" != long ] || prefix=step_long_
  local -a rows=()
  for step; do
    start=$SECONDS build_seconds=0 sources=0
    "$prefix$step"
    spent=$((SECONDS - start))
    rows+=("$(printf '%-14s %8d %8d %8d' "$step" $build_seconds $((spent - build_seconds)) $sources)")
  done
  printf '%-14s %8s %8s %8s\n' step 'build s' 'run s' sources
  printf '%s\n' "${rows[@]}"
  printf 'in all %d min %02d s, %d processors (%s)\n' $((SECONDS / 60)) $((SECONDS % 60)) "$jobs" \
    "$(sed -n 's/^model name[^:]*: *//p' /proc/cpuinfo | head -n 1)"
  finish
}

# meson_tests NAME DIR [MESON TEST OPTIONS]: runs tests of a build folder and counts their cases. Runs one more at a time than
# there are processors, since many pipeline tests wait for a clock.
meson_tests() {
  local name=$1 dir=$2 setup='' option start=$SECONDS log
  shift 2
  for option; do [[ $option == --setup=* ]] && setup=${option#--setup=}; done
  log=$logs/tests-$name.log
  rm -f "$dir"/meson-logs/testlog*
  CSDTRACK_CLIPS=${CSDTRACK_CLIPS:-$root/../shared/clips} \
    meson test -C "$dir" --no-rebuild --num-processes $((jobs + 1)) "$@" >"$log" 2>&1 </dev/null
  local -a tally
  if ! mapfile -t tally < <("$root/tests/lib/tally.py" "$dir/meson-logs" $setup 2>>"$log") || [ ${#tally[@]} = 0 ]; then
    tally=('0 1 0' 'meson test did not run')
  fi
  local p f s
  read -r p f s <<<"${tally[0]}"
  if [ $((p + f)) = 0 ]; then f=1 tally+=('nothing ran'); fi
  passed=$((passed + p)) failed=$((failed + f)) skipped=$((skipped + s))
  printf '%-7s %s: %d passed, %d failed, %d skipped (%d s)\n' \
    "$([ "$f" = 0 ] && echo ok || echo FAILED)" "$name" "$p" "$f" "$s" $((SECONDS - start))
  if [ "$f" != 0 ]; then
    printf '        %s\n' "${tally[@]:1}"
    # The next step in the same folder overwrites these logs.
    cp "$dir"/meson-logs/testlog*.txt "$logs/tests-$name-all.log" 2>/dev/null
    # Failures of gst-check and GoogleTest, reports of sanitizers and leaks, Python's exceptions.
    grep -hE ':[FE]:|: Failure$|ERROR: |runtime error:|^SUMMARY|^leaks: |^[A-Za-z.]*(Error|Exception): ' "$logs/tests-$name-all.log" |
      cut -c1-300 | head -n 30 | sed 's/^/        /'
    echo "        all of it: $logs/tests-$name-all.log, $log"
  fi
}

# finish: prints the last line and exits with the result.
finish() {
  if [ $((passed + failed)) = 0 ]; then failed=1; fi
  printf '%d passed, %d failed' $passed $failed
  [ $skipped = 0 ] || printf ', %d skipped' $skipped
  echo
  [ $failed = 0 ]
  exit
}

source_files() { find "$root"/{core,gst,python,tests} \( -name '*.cpp' -o -name '*.c' -o -name '*.h' \) "$@"; }

# build_tree DIR COMPILER [MESON OPTIONS] [-- TARGETS]: sets up and builds the folder. Uses no compiler cache, so that times
# are comparable.
build_tree() {
  local dir=$root/$1 cc=$2 cxx=clang++
  local -a options=()
  [ "$cc" = clang ] || cxx=g++
  shift 2
  while [ $# -gt 0 ] && [ "$1" != -- ]; do options+=("$1") && shift; done
  CC=$cc CXX=$cxx configure "$dir" "${options[@]}" && ninja -C "$dir" "${@:2}"
}

step_build() {
  check_build 'build' build_tree build gcc -Dtests=enabled -Dbenchmarks=enabled -Dpython=enabled || return
  check 'the plugin links no GUI or image-file library, and calls nothing that opens sockets or starts programs' plugin_links
}

plugin_links() {
  local plugin=$root/build/gst/libgstcsdtrack.so
  [ -f "$plugin" ] || { echo "error: no $plugin"; return 1; }
  ! readelf -d "$plugin" | grep -E 'NEEDED.*(opencv_highgui|opencv_imgcodecs|libgio|libsoup|libcurl)' &&
    ! nm -D --undefined-only "$plugin" |
      grep -wE '(socket|connect|bind|getaddrinfo|system|popen|v?fork|exec[lv]p?e?|fexecve|posix_spawnp?|g_spawn_[a-z_]*|gst_uri_handler_[a-z_]*)(@.*)?$'
}

step_tests() { meson_tests tests "$root/build" --no-suite=experiments --no-suite=network; }

step_leaks() {
  check_build 'build for leaks' build_tree build gcc -Dtests=enabled || return
  meson_tests leaks "$root/build" --setup=leaks --suite=check
}

step_experiments() {
  check_build 'build for experiments' build_tree build gcc -Dtests=enabled -Dbenchmarks=enabled || return
  meson_tests experiments "$root/build" --suite=experiments
}

step_network() {
  check_build 'build for network' build_tree build gcc -Dtests=enabled || return
  meson_tests network "$root/build" --suite=network
}

# The compiler spends more than half of its time on -O2 and on the debugger's locations of variables.
instrumented=(-Dtests=enabled -Dbenchmarks=disabled -Dpython=disabled -Db_lundef=false -Dbuildtype=custom -Doptimization=1
  -Ddebug=true -Dcpp_args=-g1 -Dc_args=-g1)

# One tree for the tests and libFuzzer's targets. Only clang has libFuzzer.
asan_build() { check_build 'build with ASan, UBSan and libFuzzer' build_tree build-asan clang "${instrumented[@]}" -Dfuzz=true -Db_sanitize=address,undefined; }

# tests/long runs the programs, whole simulated pictures and csdtrack_states' larger sizes: each would take a good part of the time.
step_asan() {
  asan_build || return
  CSDTRACK_SIZES=small meson_tests asan "$root/build-asan" --setup=asan --no-suite=quickstart --no-suite=whole-pictures --no-suite=programs
}

step_fuzz() {
  asan_build || return
  check 'fuzz: planted faults' "$root/tests/fuzz/run" --planted
  check 'fuzz: seeds, regressions and some more' "$root/tests/fuzz/run"
}

tsan_build() {  # [-- NINJA TARGET]
  check_build 'build with TSan' build_tree build-tsan gcc "${instrumented[@]}" -Db_sanitize=thread -Dprograms=disabled -Dpeers=disabled "$@"
}

step_tsan() {
  tsan_build -- tsan-short || return
  meson_tests tsan "$root/build-tsan" --setup=tsan --suite=tsan-short
}

step_soak() { check 'soak: three minutes' "$root/tests/soak" --no-install 0.05; }

# The ASan step compiles core/, gst/ and their tests with clang; tests/long tidy finds missing #includes.
step_clang() { check_build 'clang' clang_syntax python tests/bench; }

# clang_syntax [FOLDER...]: compiles all sources, or those in the folders, for their warnings only, which takes a third of the
# time. Uses no precompiled headers, so that it finds missing #includes.
clang_syntax() {
  CC=clang CXX=clang++ configure "$root/build-clang" -Dtests=enabled -Dbenchmarks=enabled -Db_pch=false || return
  "$root/tests/lib/syntax.py" "$root/build-clang" "$jobs" "${@/#/$root/}"
}

step_format() {
  check 'format' bash -c "$(declare -f source_files); root=$root; source_files -print0 | xargs -0 clang-format --dry-run -Werror"
}

step_rules() {
  check 'rule: at most 450 lines a file, 700 an element' rule_lines
  check 'rule: core/ includes no GStreamer and no GLib' rule_core
  check 'rule: the rooms of core/ include only what they may' rule_rooms
  check 'rule: every source names its licence' rule_spdx
  check 'rule: scripts parse' rule_scripts
  check 'rule: flake8 finds nothing in the Python' rule_flake8
  check 'rule: mypy finds nothing' rule_mypy
  check 'rule: every core file has its test at the mirrored path' rule_mirrored
  check 'rule: names in docs/method.md exist' "$root/tests/lib/method_names.py"
  check 'rule: links in the documentation work' "$root/tests/lib/links.py"
  check 'rule: tests/bench/ablation finds the code it removes' "$root/tests/bench/ablation" --check
}

rule_lines() {
  local file lines most bad=0
  while read -r file; do
    lines=$(wc -l <"$file") most=450
    case $file in "$root"/gst/elements/*.cpp) most=700 ;; esac
    [ "$lines" -le $most ] || { echo "error: $file has $lines lines; at most $most are allowed"; bad=1; }
  done < <(source_files; find "$root"/{core,pipelines} -name '*.py')
  return $bad
}

rule_core() {
  ! grep -rnE '#include *[<"](gst|glib|gio|gobject)[/.-]' "$root/core" --include='*.h' --include='*.cpp' \
    --exclude-dir=programs
}

# CONTRIBUTING.md has the same table, with each room's purpose.
rule_rooms() {
  local bad=0 room other
  local -A may=(
    [base]='' [image]='' [content]='image' [detect]='image' [patch]='image content' [track]='base image content detect'
    [csd]='base image content detect patch track' [csd2012]='base image content detect patch track'
    [baselines]='base image track csd2012' [algorithms]='base track csd csd2012 baselines'
    [sim]='base image content detect' [score]='base' [motion]='base score' [text]='base' [programs]='base image score motion text')
  for room in "$root"/core/*/; do
    room=$(basename "$room")
    [ "$room" != precompiled ] || continue
    [ -n "${may[$room]+known}" ] || { echo "error: core/$room is missing in rule_rooms"; bad=1; continue; }
    while read -r other; do
      [[ " $room ${may[$room]} " == *" $other "* ]] || { echo "error: core/$room may not include $other/"; bad=1; }
    done < <(grep -rhoE '^ *# *include "[a-z0-9_]+/' "$root/core/$room" --include='*.h' --include='*.cpp' | sed 's/.*"//; s#/$##' | sort -u)
  done
  return $bad
}

rule_spdx() {
  local bad=0 file
  while read -r file; do
    head -n 3 "$file" | grep -q 'SPDX-License-Identifier: LGPL-2.1-or-later' ||
      { echo "error: $file has no SPDX line"; bad=1; }
  done < <(source_files; scripts)
  return $bad
}

# Each header or source of the core has its own test file, and each test file belongs to a file of the core.
rule_mirrored() {
  local bad=0 name
  while read -r name; do
    case $name in
      # Only types, constants and interfaces.
      image/frame_view | csd/frame | track/algorithm | track/executor | precompiled/*) continue ;;
      # A program's parts are tested through the program (csd_X_test.py), or by themselves where that covers more.
      programs/*) continue ;;
      # Parts of text/read_line, which its test covers.
      text/json | text/feature_state) continue ;;
    esac
    [ -f "$root/tests/core/${name}_test.cpp" ] || { echo "error: core/$name has no tests/core/${name}_test.cpp"; bad=1; }
  done < <(cd "$root/core" && find . \( -name '*.cpp' -o -name '*.h' \) -printf '%P\n' | sed 's/\.[a-z]*$//' | sort -u)
  while read -r name; do
    case $name in
      # The simulator as a whole: its truth compared with its pictures.
      sim/truth | sim/visibility) ;;
      # The tracker's failures; csd as a whole on each kind of simulated tissue.
      track/tracker_faults | csd/csd_scenes) ;;
      *)
        [ -f "$root/core/$name.h" ] || [ -f "$root/core/$name.cpp" ] ||
          { echo "error: tests/core/${name}_test.cpp belongs to no file of the core"; bad=1; } ;;
    esac
    grep -qw "${name##*/}" "$root/tests/core/${name%/*}/meson.build" ||
      { echo "error: tests/core/${name}_test.cpp is not built"; bad=1; }
  done < <(cd "$root/tests/core" && find . -name '*_test.cpp' -printf '%P\n' | sed 's/_test\.cpp$//')
  return $bad
}

# All bash and Python scripts of this repository.
scripts() {
  find "$root"/{core,docs,pipelines,python,tests} -type f \( -name '*.sh' -o -name '*.py' -o -perm -u+x \) -not -path '*/__pycache__/*'
}

rule_scripts() {
  local bad=0 file
  while read -r file; do
    case $(head -n 1 "$file") in
      '#!/usr/bin/python3') ;;
      '#!/bin/bash' | '# SPDX'*) [[ $file == *.py ]] || { bash -n "$file" || bad=1; continue; } ;;
      *) echo "error: $file begins with neither #!/bin/bash nor #!/usr/bin/python3"; bad=1; continue ;;
    esac
    /usr/bin/python3 -c 'import ast, sys; ast.parse(open(sys.argv[1]).read(), sys.argv[1])' "$file" || bad=1
  done < <(scripts)
  return $bad
}

# setup.cfg has the settings of both.
rule_flake8() {
  local file
  while read -r file; do
    [[ $file != *.py && $(head -n 1 "$file") != '#!/usr/bin/python3' ]] || echo "$file"
  done < <(scripts) | xargs -d '\n' flake8 --config "$root/setup.cfg"
}

rule_mypy() { (cd "$root" && mypy --config-file setup.cfg --cache-dir "$root/build/mypy"); }
