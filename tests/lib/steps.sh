# SPDX-License-Identifier: LGPL-2.1-or-later
# Sourced by tests/run, tests/more, tests/long and tests/coverage: the steps, the count, the times. Expects $root and
# pipelines/lib/setup.sh. A step is a function step_NAME; it reports what it did by check(), check_build() and meson_tests().

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

# check_build NAME COMMAND...: a check whose time is the compiler's. What ninja compiles in it is counted, and so is what
# syntax.py looks at.
check_build() {
  local start=$SECONDS log=$logs/${1//[^a-zA-Z0-9]/-}.log status
  check "$@"
  status=$?
  build_seconds=$((build_seconds + SECONDS - start))
  sources=$((sources + $(grep -cE '^\[[0-9]+/[0-9]+\] (Compiling|Precompiling)|^checked ' "$log")))
  return $status
}

# read_words [ARGUMENT...]: sets `steps`, those named among `every_step`, or all, and `install`. Ends the command for
# --help, which calls usage(), and for words that are none.
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

# ready [--no-install] KIND...: installs what tests/packages lists for these kinds, and says what will be missed.
ready() {
  local clips=${CSDTRACK_CLIPS:-$root/../shared/clips}
  if [ "$1" = --no-install ]; then shift; else
    ensure_packages "$@" || exit 1
    # Decimal commas are one of the things that break writers.
    if ! locale -a | grep -qi '^de_DE\.utf-\?8$'; then
      as_root localedef -i de_DE -f UTF-8 de_DE.UTF-8 || exit 1
    fi
  fi
  [ -d "$clips" ] || echo "no clips in $clips: tests on real video skip"
}

# run_steps STEP...: one after the other; then a table of what each took, the last line, and the exit code.
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

# meson_tests NAME DIR [MESON TEST OPTIONS]: runs tests of a build folder and counts their cases. One at a time more than there are
# processors: many of the pipelines' wait for a clock.
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
    # The next step of the same folder begins its logs anew.
    cp "$dir"/meson-logs/testlog*.txt "$logs/tests-$name-all.log" 2>/dev/null
    # gst-check's and GoogleTest's failures, the sanitizers' and leaks' reports, Python's exceptions.
    grep -hE ':[FE]:|: Failure$|ERROR: |runtime error:|^SUMMARY|^leaks: |^[A-Za-z.]*(Error|Exception): ' "$logs/tests-$name-all.log" |
      cut -c1-300 | head -n 30 | sed 's/^/        /'
    echo "        all of it: $logs/tests-$name-all.log, $log"
  fi
}

# finish: the last line, and the exit code.
finish() {
  if [ $((passed + failed)) = 0 ]; then failed=1; fi
  printf '%d passed, %d failed' $passed $failed
  [ $skipped = 0 ] || printf ', %d skipped' $skipped
  echo
  [ $failed = 0 ]
  exit
}

source_files() { find "$root"/{core,gst,python,tests} \( -name '*.cpp' -o -name '*.c' -o -name '*.h' \) "$@"; }

# build_tree DIR COMPILER [MESON OPTIONS] [-- TARGETS]: sets the folder up and builds it. No cache of a compiler's: what it
# takes is the same everywhere.
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
  check 'the plugin links neither windows nor image files, and nothing that opens sockets or starts programs' plugin_links
}

plugin_links() {
  local plugin=$root/build/gst/libgstcsdtrack.so
  [ -f "$plugin" ] || { echo "error: no $plugin"; return 1; }
  ! readelf -d "$plugin" | grep -E 'NEEDED.*(opencv_highgui|opencv_imgcodecs|libgio|libsoup|libcurl)' &&
    ! nm -D --undefined-only "$plugin" |
      grep -wE '(socket|connect|bind|getaddrinfo|system|popen|v?fork|exec[lv]p?e?|fexecve|posix_spawnp?|g_spawn_[a-z_]*|gst_uri_handler_[a-z_]*)(@.*)?$'
}

step_tests() { meson_tests tests "$root/build" --no-suite=quickstart --no-suite=experiments; }
step_quickstart() { meson_tests quickstart "$root/build" --suite=quickstart; }

step_leaks() {
  check_build 'build for leaks' build_tree build gcc -Dtests=enabled || return
  meson_tests leaks "$root/build" --setup=leaks --suite=check
}

step_experiments() {
  check_build 'build for experiments' build_tree build gcc -Dtests=enabled -Dbenchmarks=enabled || return
  meson_tests experiments "$root/build" --suite=experiments
}

# Of a file's processor time a compiler spends more than half on -O2 and on variables' places for a debugger.
instrumented=(-Dtests=enabled -Dbenchmarks=disabled -Dpython=disabled -Db_lundef=false -Dbuildtype=custom -Doptimization=1
  -Ddebug=true -Dcpp_args=-g1 -Dc_args=-g1)

# One tree for the tests and for libFuzzer's targets, by clang, which alone has it.
asan_build() { check_build 'build with ASan, UBSan and libFuzzer' build_tree build-asan clang "${instrumented[@]}" -Dfuzz=true -Db_sanitize=address,undefined; }

# The programs, the simulator's whole pictures and larger sizes of csdtrack_states are tests/long's: each a good part of the time.
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

# The tests' own sources are compiled by clang with ASan.
step_clang() { check_build 'clang' clang_syntax core gst python; }

# clang_syntax [FOLDER...]: compiles without writing anything: the warnings are what we want, and it takes a third of the
# time. Of all sources, or of those below the folders. Without precompiled headers: a file that misses an #include is found here.
clang_syntax() {
  CC=clang CXX=clang++ configure "$root/build-clang" -Dtests=enabled -Dbenchmarks=enabled -Db_pch=false || return
  "$root/tests/lib/syntax.py" "$root/build-clang" "$jobs" "${@/#/$root/}"
}

step_format() {
  check 'format' bash -c "$(declare -f source_files); root=$root; source_files -print0 | xargs -0 clang-format --dry-run -Werror"
}

step_rules() {
  check 'rule: at most 450 lines a file, 700 an element' rule_lines
  check 'rule: core/ knows no GStreamer and no GLib' rule_core
  check 'rule: the rooms of core/ know what they may' rule_rooms
  check 'rule: every source names its licence' rule_spdx
  check 'rule: scripts parse' rule_scripts
  check 'rule: every core file has its test at the mirrored path' rule_mirrored
  check 'rule: docs/method.md names what is there' "$root/tests/lib/method_names.py"
  check 'rule: links of the documentation lead somewhere' "$root/tests/lib/links.py"
  check 'rule: tests/bench/ablation finds what it takes out' "$root/tests/bench/ablation" --check
}

rule_lines() {
  local file lines most bad=0
  while read -r file; do
    lines=$(wc -l <"$file") most=450
    case $file in "$root"/gst/csd*.cpp) most=700 ;; esac
    [ "$lines" -le $most ] || { echo "error: $file has $lines lines, $most are allowed"; bad=1; }
  done < <(source_files)
  return $bad
}

rule_core() {
  ! grep -rnE '#include *[<"](gst|glib|gio|gobject)[/.-]' "$root/core" --include='*.h' --include='*.cpp' \
    --exclude-dir=programs
}

# CONTRIBUTING.md has the same as a table, with what each room is for.
rule_rooms() {
  local bad=0 room other
  local -A may=(
    [image]='' [content]='image' [detect]='image' [patch]='image content' [track]='image content detect'
    [csd]='image content detect patch track' [csd2012]='image content detect patch track' [baselines]='image track csd2012'
    [algorithms]='track csd csd2012 baselines' [sim]='image content detect track' [score]='track' [motion]='score' [text]='track'
    [programs]='image track score motion text')
  for room in "$root"/core/*/; do
    room=$(basename "$room")
    [ "$room" != precompiled ] || continue
    [ -n "${may[$room]+known}" ] || { echo "error: core/$room has no line in rule_rooms"; bad=1; continue; }
    while read -r other; do
      [[ " $room ${may[$room]} " == *" $other "* ]] || { echo "error: core/$room includes $other/, which it may not know"; bad=1; }
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

# What a header or a source of the core does is tested in a file of its own, and a test names a file of the core.
rule_mirrored() {
  local bad=0 name
  while read -r name; do
    case $name in
      # Nothing but types, constants and interfaces.
      image/frame_view | csd/frame | track/algorithm | track/executor | precompiled/*) continue ;;
      # A program's parts are tested through the program (csd_X_test.py), by themselves where that reaches more.
      programs/*) continue ;;
      # Parts of text/read_line, tested through it.
      text/json | text/feature_state) continue ;;
    esac
    [ -f "$root/tests/core/${name}_test.cpp" ] || { echo "error: core/$name has no tests/core/${name}_test.cpp"; bad=1; }
  done < <(cd "$root/core" && find . \( -name '*.cpp' -o -name '*.h' \) -printf '%P\n' | sed 's/\.[a-z]*$//' | sort -u)
  while read -r name; do
    case $name in
      # The simulator as a whole: what its truth says against what its pictures show.
      sim/truth | sim/visibility) ;;
      # The tracker where something fails; csd as a whole on each kind of simulated tissue.
      track/tracker_faults | csd/csd_scenes) ;;
      *)
        [ -f "$root/core/$name.h" ] || [ -f "$root/core/$name.cpp" ] ||
          { echo "error: tests/core/${name}_test.cpp is the test of no file of the core"; bad=1; } ;;
    esac
    grep -qw "${name##*/}" "$root/tests/core/${name%/*}/meson.build" ||
      { echo "error: tests/core/${name}_test.cpp is not built"; bad=1; }
  done < <(cd "$root/tests/core" && find . -name '*_test.cpp' -printf '%P\n' | sed 's/_test\.cpp$//')
  return $bad
}

# Every bash or Python script of ours.
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
