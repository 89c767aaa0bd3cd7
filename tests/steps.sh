# The functions of tests/run, which sets logs, jobs, mode, only, hash_ticks, test_seconds and step_seconds before it calls them.
# shellcheck shell=bash disable=SC2154

hash_scenes=("two-blocks" "stack" "pyramid --size 12" "pile --size 150" "convex-pile --size 60" "terrain --size 40" "washer --size 60" "domino --size 60" "ragdolls --size 4" "joint-grid" "bridge --size 40" "wrecking-ball --size 12" "water --size 30" "blast --size 6" "character --players 2" "cars --players 2" "rollback-arena" "rollback-arena --players 4 --seed 9")

log_of() { printf '%s/%s.log' "$logs" "$(tr -cs 'a-zA-Z0-9' '-' <<<"$1")"; }

# side_by_side [MORE] ... one_by_one: the checks between these calls do not depend on each other. The run starts $jobs of them at once, and MORE
# if some checks are idle most of the time. The longest checks come first.
width=1
side_by_side() { width=$((jobs + ${1:-0})); }
one_by_one() {
    wait
    width=1
}
start_check() { # FUNCTION NAME ARGUMENT...
    is_wanted "$2" || return 0
    if [ -n "$only" ] && [ -n "$needs" ] && [ -n "${builds[$needs]:-}" ]; then
        eval "${builds[$needs]}"
        unset "builds[$needs]"
    fi
    if [ -n "$needs" ] && [[ " $broken " == *" $needs "* ]]; then
        count 0 1
        report_failure "$2" "not run: $needs does not build" "$(again "$2")"
        return
    fi
    if [ "$width" -eq 1 ]; then
        "$@"
        return
    fi
    while [ "$(jobs -rp | wc -l)" -ge "$width" ]; do wait -n || true; done
    "$@" &
}

# needs=PRESET: the build of the programs that the next checks run. If that build failed, these checks are not started and count as failed.
needs='' broken='' found=''

# tests/run --only NAME builds the programs of one check and runs it: `builds` maps each preset to the command that builds it.
declare -A builds=()
is_wanted() {
    [ -n "$only" ] || return 0
    [ "$1" = "$only" ] && found=1
}

# again NAME: prints the command that repeats one check alone.
again() { printf 'tests/run%s --only "%s"' "$([ "$mode" = default ] || echo " --$mode")" "$1"; }

# report_failure NAME REASON COMMAND [LOG]: prints the name, the command that repeats the check alone, and the last lines of the log. `finish` prints
# name and command again.
report_failure() {
    printf '%s\t%s\n' "$1" "$3" >>"$logs/failed"
    printf 'FAILED  %s (%s)\n        repeat it alone: %s\n' "$1" "$2" "$3"
    [ $# -lt 4 ] || printf '        log: %s; its last lines:\n%s\n' "$4" "$(tail -n 40 "$4" | sed 's/^/        /')"
}

# count PASSED FAILED: adds to the numbers of passed and failed tests.
count() { echo "$1 $2" >>"$logs/tally"; }

# until_limit: returns after $step_seconds of an idle machine. While the load average is above $jobs, a second counts as a fraction, at least an
# eighth, because each check then gets only a share of a core. So a loaded machine does not turn a slow check into a failed one.
until_limit() {
    local passed=0 load pause=$((step_seconds < 100 ? 1 : 5)) full=$((jobs * 100)) # passed, load and full count in hundredths
    while [ "$passed" -lt $((step_seconds * 100)) ]; do
        sleep "$pause"
        load=$(sed 's/ .*//; s/[.]//; s/^0*//' /proc/loadavg 2>/dev/null) || load=0
        [ "${load:-0}" -gt "$full" ] || load=$full
        [ "$load" -lt $((8 * full)) ] || load=$((8 * full))
        passed=$((passed + pause * 100 * full / load))
    done
}

# within_limit COMMAND...: runs the command. At the limit it kills the command with all processes that the command started, and prints a message.
# So a program that never ends fails its check, and the run continues.
within_limit() (
    set -m # each background command gets its own process group
    "$@" &
    command=$!
    { until_limit && echo "stopped: it ran for over $step_seconds s of an idle machine" && kill -KILL -- "-$command"; } &
    guard=$!
    trap 'kill -KILL -- "-$command" "-$guard" 2>/dev/null' EXIT
    trap 'exit 130' INT TERM
    status=0
    wait "$command" || status=$?
    exit "$status"
)

# At the limit, within_limit must kill a command that never ends, together with its child process, and must print a message.
planted_hang_is_stopped() {
    local report name=planted-hang-$$
    if report=$(step_seconds=1 within_limit bash -c "bash -c 'exec -a $name sleep 600' & wait"); then
        echo "the hang was not noticed"
        return 1
    fi
    echo "$report"
    ! pgrep -f "^$name" && grep -q '^stopped: it ran for over 1 s' <<<"$report"
}

# Stub scripts replace dpkg-query, dpkg and apt-get. They refuse to install until an installation that was killed halfway is
# finished; tools/packages must finish it. It must report an error if the package manager stays broken.
interrupted_installation_is_finished() {
    local folder
    folder=$(mktemp -d)
    printf '#!/bin/sh\nexit 1\n' >"$folder/dpkg-query"
    printf '#!/bin/sh\n[ ! -e %q/hopeless ] && echo "$*" >%q/finished\n' "$folder" "$folder" >"$folder/dpkg"
    printf '#!/bin/sh\ncase "$*" in update*) ;; *) grep -q -- "--configure -a" %q/finished && echo "$*" >>%q/calls ;; esac\n' "$folder" "$folder" >"$folder/apt-get"
    printf '#!/bin/sh\nexec "$@"\n' >"$folder/sudo"
    chmod +x "$folder"/*
    PATH=$folder:$PATH tools/packages one two && cat "$folder/calls" && tail -n 1 "$folder/calls" | grep -q '^install .* one two$' || return 1
    rm "$folder/finished" && touch "$folder/hopeless"
    if PATH=$folder:$PATH tools/packages one two 2>"$folder/error"; then
        echo "a package manager that stays broken was not noticed"
        return 1
    fi
    cat "$folder/error"
    grep -q 'could not install: one two' "$folder/error" || return 1
    rm -r "$folder"
}

# timed NAME COMMAND...: runs the command, and sets seconds and processors. Adds a line to the table that `finish` prints: seconds, processor
# seconds, name.
timed() {
    local name=$1 status=0 took=$logs/took.$BASHPID TIMEFORMAT='%0R %0U %0S'
    shift
    { time within_limit "$@" 2>&3; } 3>&2 2>"$took" || status=$?
    read -r real user system <"$took"
    rm -f "$took"
    seconds=$real processors=$((user + system))
    printf '%d\t%d\t%s\n' "$seconds" "$processors" "$name" >>"$logs/times"
    return $status
}

# check NAME COMMAND...: runs the command and prints one line; after a failure it also prints the end of the log.
check() { start_check check_now "$@"; }
check_now() {
    local name=$1 log seconds processors
    shift
    log=$(log_of "$name")
    if timed "$name" "$@" >"$log" 2>&1 </dev/null; then
        count 1 0
        printf 'ok      %s (%d s)\n' "$name" "$seconds"
    else
        count 0 1
        report_failure "$name" "$seconds s" "$(again "$name")" "$log"
    fi
}

# check_or_skip NAME COMMAND...: like check. Status 3 means that the command lacks a program or the network: the check then prints the last line of
# the log and counts neither as passed nor as failed.
check_or_skip() { start_check check_or_skip_now "$@"; }
check_or_skip_now() {
    local name=$1 log seconds processors status=0
    shift
    log=$(log_of "$name")
    timed "$name" "$@" >"$log" 2>&1 </dev/null || status=$?
    case $status in
        0) count 1 0 && printf 'ok      %s (%d s)\n' "$name" "$seconds" ;;
        3) printf 'skipped %s: %s\n' "$name" "$(tail -n 1 "$log")" ;;
        *) count 0 1 && report_failure "$name" "$seconds s" "$(again "$name")" "$log" ;;
    esac
}

# check_build PRESET NAME COMMAND...: runs a build. If it fails, checks with needs=PRESET are not started and count as failed. If --only names
# another check, the function only stores the command in `builds`.
check_build() {
    local preset=$1
    shift
    if ! is_wanted "$1"; then
        builds[$preset]="${builds[$preset]:+${builds[$preset]}; }build_now $preset $(printf '%q ' "$@")"
        return
    fi
    build_now "$preset" "$@"
}
build_now() {
    local preset=$1 before
    shift
    before=$(wc -l <"$logs/failed")
    check_now "$@"
    [ "$(wc -l <"$logs/failed")" -eq "$before" ] || broken+=" $preset"
}

# build PRESET [ARGUMENT...] [-- TARGET...]: configures and builds the folder build/PRESET.
build() {
    local preset=$1 arguments=() targets=()
    shift
    while [ $# -gt 0 ] && [ "$1" != -- ]; do
        arguments+=("$1")
        shift
    done
    [ $# -eq 0 ] || targets=(--target "${@:2}")
    tools/configure "$preset" "${arguments[@]}" && cmake --build "build/$preset" -j "$jobs" "${targets[@]}"
}

# tally LOG: prints the numbers of passed and failed tests in a log of ctest -V or of a doctest program. It counts each case of a doctest program,
# and one for each other test.
tally() {
    awk '
        match($0, /\[doctest\] test cases: +[0-9]+ \| +[0-9]+ passed \| +[0-9]+ failed/) {
            split(substr($0, RSTART, RLENGTH), field, "|")
            split(field[2], p, " "); split(field[3], f, " ")
            good += p[1]; bad += f[1]
            test = $0; sub(/:.*/, "", test); counted[test] = f[1] + 0; has[test] = 1
        }
        match($0, /Test +#[0-9]+: /) {
            test = substr($0, RSTART, RLENGTH); gsub(/[^0-9]/, "", test)
            if ($0 ~ / Passed /) { if (!has[test]) good++ }
            else if (!has[test] || counted[test] == 0) bad++
        }
        END { print good + 0, bad + 0 }' "$1"
}

add_tally() { # NAME LOG STATUS SECONDS COMMAND
    local good bad
    read -r good bad < <(tally "$2")
    [ "$3" -eq 0 ] || [ "$bad" -gt 0 ] || bad=1
    [ "$good" -gt 0 ] || [ "$bad" -gt 0 ] || bad=1 # no test ran
    count "$good" "$bad"
    if [ "$bad" -eq 0 ]; then
        printf 'ok      %s: %d tests (%d s)\n' "$1" "$good" "$4"
    else
        report_failure "$1" "$bad of $((good + bad)) tests, $4 s; log: $2" "$5"
    fi
}

# check_suite FOLDER [OPTION...]: runs the tests of build/FOLDER that ctest selects by the options, and counts each case. A test that cannot run
# counts as failed, and the check prints its name.
check_suite() { start_check check_suite_now "$1: tests" "$@"; }
check_suite_now() {
    local name=$1 folder=$2 log status=0 seconds processors
    shift 2
    log=$(log_of "$name")
    # ctest runs $jobs + 1 tests at once, because tests that play over UDP are idle most of the time.
    timed "$name" ctest --test-dir "build/$folder" -V -j "$((jobs + 1))" --timeout "$test_seconds" "$@" >"$log" 2>&1 || status=$?
    ! grep -q '[*]Skipped' "$log" || status=1
    add_tally "$name" "$log" "$status" "$seconds" "ctest --test-dir build/$folder --rerun-failed --output-on-failure"
    grep '[*]Skipped' "$log" | sed 's/^/        cannot run: /' || true
    [ "$status" -eq 0 ] || last_words_of_failed "$log" "build/$folder"
}

# last_words_of_failed LOG FOLDER: reads a log of ctest -V, and prints for each failed test the command that repeats it and the end of its output.
# A second run may pass, so its output would not explain the failure of the first.
last_words_of_failed() {
    local number name
    while read -r number name; do
        printf '        repeat it alone: ctest --test-dir %s -R "^%s$" --output-on-failure\n' "$2" "$name"
        grep -m 1 -E "Test +#$number: " "$1"
        grep "^$number: " "$1" | tail -n 40
    done < <(sed -nE '/Passed/!s/^ *[0-9]+\/[0-9]+ Test +#([0-9]+): +([^ ]+) .*/\1 \2/p' "$1")
}

# The log has one passed and one failed test: the report must show the output of the failed test only.
planted_failure_is_shown() {
    local report log=$logs/planted-failure
    printf '%s\n' '1: all is well' '2: the reason' '1/2 Test #1: good ....   Passed    0.02 sec' '2/2 Test #2: bad .....***Failed    0.02 sec' >"$log"
    report=$(last_words_of_failed "$log" build/x)
    echo "$report"
    grep -q '^2: the reason$' <<<"$report" && grep -q 'ctest --test-dir build/x -R "^bad\$"' <<<"$report" && ! grep -q 'all is well' <<<"$report"
}

# Three checks fail or are not started: the run must continue, and must print their names, the command that repeats them, and the last lines of a log.
planted_failure_is_reported() {
    local report logs=$logs/planted only='' mode=full needs='' broken='' found='' width=1
    mkdir -p "$logs" && : >"$logs/tally" && : >"$logs/times" && : >"$logs/failed"
    report=$(
        check "a good one" true
        check "a bad one" bash -c 'echo the reason; exit 1'
        check_build nothing "a build" false
        needs=nothing
        check "one without a build" true
        (finish) || echo "status $?"
    )
    echo "$report"
    grep -q 'FAILED  a bad one' <<<"$report" && grep -q 'repeat it alone: tests/run --full --only "a bad one"' <<<"$report" &&
        grep -q 'the reason' <<<"$report" && grep -q 'FAILED  one without a build (not run: nothing does not build)' <<<"$report" &&
        grep -q '^1 passed, 3 failed$' <<<"$report" && grep -q '^status 1$' <<<"$report"
}

# check_program NAME PROGRAM [ARGUMENT...]: runs a doctest program and counts each case.
check_program() { start_check check_program_now "$@"; }
check_program_now() {
    local name=$1 log status=0 seconds processors
    shift
    log=$(log_of "$name")
    timed "$name" "$@" >"$log" 2>&1 </dev/null || status=$?
    add_tally "$name" "$log" "$status" "$seconds" "$(again "$name")"
    [ "$status" -eq 0 ] || tail -n 40 "$log" | sed 's/^/        /'
}

# ---- hashes across builds ----

hash_file() { printf 'build/hashes/%s/%s.tsv' "$1" "${2// /}"; }

# write_hashes NAME PROGRAM [ARGUMENT...]: runs every scene with the command line of one build and writes the hash after every tick.
write_hashes() {
    local name=$1 program=$2 scene words
    shift 2
    rm -rf "build/hashes/$name"
    mkdir -p "build/hashes/$name"
    for scene in "${hash_scenes[@]}"; do
        read -ra words <<<"$scene"
        "$program" run "${words[@]}" --ticks "$hash_ticks" --hashes "$(hash_file "$name" "$scene")" "$@" || return 1
    done
}

# write_hashes must fail if the program fails at the first scene and succeeds at all others.
planted_failure_of_hashes_is_noticed() {
    local program=build/hashes/planted-program
    mkdir -p build/hashes
    printf '#!/bin/sh\n[ -e %s.ran ] || { touch %s.ran; exit 1; }\n' "$program" "$program" >"$program"
    chmod +x "$program"
    rm -f "$program.ran"
    ! write_hashes planted "$program"
}

# compare_hashes NAME: compares the hashes byte by byte with those of the release build; prints the first differing line of each scene.
compare_hashes() {
    local name=$1 scene good=0
    for scene in "${hash_scenes[@]}"; do
        local expected found
        expected=$(hash_file release "$scene")
        found=$(hash_file "$name" "$scene")
        if [ "$(wc -l <"$expected")" -ne "$hash_ticks" ]; then
            echo "$scene: $expected does not hold $hash_ticks ticks"
            good=1
        elif ! cmp -s "$expected" "$found"; then
            echo "$scene: differs from the release build at tick, hash (release first):"
            diff "$expected" "$found" | sed -n '2p;/^>/{p;q}'
            good=1
        fi
    done
    return $good
}

# run_on_workers MATRIX_HASH TICKS: runs every game of the golden table on three workers, so that a sanitizer can check it, and three games that are
# large enough for workers to share their passes. Two workers share some work in another way than three, so two of these games run again on two.
run_on_workers() {
    local games
    mapfile -t games < <(sed '/^#/d' tests/golden/hashes.tsv | cut -f1 | sort -u)
    [ "${#games[@]}" -gt 10 ] && "$1" --ticks "$2" --powers --workers 3 "${games[@]}" \
        "pile size=600 seed=1 players=0" "pyramid size=30 seed=1 players=0" "ragdolls size=25 seed=1 players=0" &&
        "$1" --ticks "$2" --powers --workers 2 "pyramid size=30 seed=1 players=0" "ragdolls size=25 seed=1 players=0"
}

# Two threads add to one number many times, because the sanitizer may miss a single pair of simultaneous accesses.
planted_race_is_noticed() {
    local report
    g++ -x c++ -std=c++20 -O1 -fsanitize=thread -o build/tsan/race - <<<'#include <thread>
volatile int sum;
void add() { for (int i = 0; i < 10000; ++i) sum = sum + 1; }
int main() { std::thread other(add); add(); other.join(); }' || return 1
    if report=$(build/tsan/race 2>&1); then
        echo "the race was not noticed"
        return 1
    fi
    grep -q 'data race' <<<"$report"
}

# The comparison must fail if the hash of one tick is changed, and must print the number of that tick.
planted_hash_is_noticed() {
    local scene=${hash_scenes[0]} file report tick=$((hash_ticks / 2))
    mkdir -p build/hashes/planted
    for s in "${hash_scenes[@]}"; do cp "$(hash_file release "$s")" "$(hash_file planted "$s")"; done
    compare_hashes planted || return 1
    file=$(hash_file planted "$scene")
    sed -i "$((tick + 1))y/0123456789abcdef/123456789abcdef0/" "$file"
    sed -i "$((tick + 1))s/^[0-9]*/$tick/" "$file"
    if report=$(compare_hashes planted); then
        echo "the changed hash was not noticed"
        return 1
    fi
    grep -q "^< $tick	" <<<"$report"
}

# ---- fuzzing ----

# fuzz TARGET CORPUS RUNS [OPTION...]: runs a fuzzer on tests/fuzz/corpus/CORPUS; it writes new inputs and crashes to build/fuzz-corpus.
fuzz() {
    local target=$1 kept=tests/fuzz/corpus/$2 runs=$3
    shift 3
    mkdir -p "build/fuzz-corpus/$target" "build/fuzz-corpus/none"
    [ -d "$kept" ] || kept=build/fuzz-corpus/none
    build/asan/bin/fuzz_"$target" -runs="$runs" -seed=1 -max_len=4096 -timeout=20 -rss_limit_mb=3000 -print_final_stats=1 \
        "$@" -artifact_prefix="build/fuzz-corpus/$target-" "build/fuzz-corpus/$target" "$kept"
}

# fuzz_import RUNS: fuzzes model files, and continues after an input that breaks the library that reads them. Errors that our own code reports are
# failures. Stacks have no names of functions (symbolize=0): a broken process would start another process to find them, and some would hang there.
fuzz_import() {
    local report
    report=$(ASAN_OPTIONS=detect_leaks=0:symbolize=0 fuzz cook_import cook_import "$1" -fork=1 -ignore_crashes=1 -ignore_timeouts=1 -ignore_ooms=1 \
        -timeout=2 -max_len=1024 2>&1) || true
    echo "$report"
    ! grep -qE 'ERROR: cook import|runtime error:' <<<"$report" && grep -q 'fuzzed for' <<<"$report"
}

# Succeeds if a sanitizer's stack, on standard input, begins in our code. The function skips frames of the sanitizers and of the fuzzer, which are
# linked into our program, and frames of the C and C++ libraries. A frame of our program without a name, as without llvm-symbolizer, counts as ours.
is_broken_by_us() {
    local frame
    frame=$(grep -E '^ *#[0-9]+ ' | grep -vP ' in (__|abort|raise|mem|str|malloc|calloc|realloc|free|operator |([^( ]+ )?std::)| in (?!.*lockstone::|LLVMFuzzerTestOneInput).*/fuzz_cook_import\+0x|/(libc|libm|libgcc_s|libstdc\+\+)\.so' | head -n 1) || true
    grep -qE ' in .*lockstone::| in LLVMFuzzerTestOneInput| 0x[0-9a-f]+ +\(.*/fuzz_cook_import\+0x' <<<"$frame"
}
planted_stack_is_told() {
    local stack
    local ours=(
        '#0 0x1 in memcpy (/x/fuzz_cook_import+0x1)|#1 0x2 in void std::copy<int>(int) x.h:1|#2 0x3 in lockstone::cook(int) x.cpp:1|#3 0x4 (/x/libassimp.so.5+0x1)'
        '#0 0x1 in fuzzer::MallocHook(int) (/x/fuzz_cook_import+0x1)|#1 0x2 in operator new(int) (/x/fuzz_cook_import+0x2)|#2 0x3 in int lockstone::cook<int>(int) x.cpp:1'
        '#0 0x1 in __sanitizer_print_stack_trace (/x/fuzz_cook_import+0x1)|#1 0x2  (/x/libc.so.6+0x1)|#2 0x3 in abort stdlib/abort.c:79|#3 0x4 in LLVMFuzzerTestOneInput x.cpp:1'
        '#0 0x1  (/x/bin/fuzz_cook_import+0x12)|#1 0x2 (/x/libassimp.so.5+0x1)'
    )
    local others=(
        '#0 0x1 in strlen (/x/fuzz_cook_import+0x1)|#1 0x2  (/x/libassimp.so.5+0x1)|#2 0x3 in lockstone::cook(int) x.cpp:1'
        '#0 0x1 in fuzzer::Fuzzer::HandleMalloc(int) (/x/fuzz_cook_import+0x1)|#1 0x2  (/x/libassimp.so.5+0x1)|#2 0x3 in lockstone::cook(int) x.cpp:1'
        '#0 0x1 in fuzzer::PrintStackTrace() (/x/fuzz_cook_import+0x1)|#1 0x2  (/x/libc.so.6+0x3c04f)|#2 0x3 in Assimp::read(int) (/x/libassimp.so.5+0x1)|#3 0x4 in lockstone::cook(int) x.cpp:1'
        'no stack'
    )
    for stack in "${ours[@]}"; do
        is_broken_by_us <<<"${stack//|/$'\n'}" || return 1
    done
    for stack in "${others[@]}"; do
        ! is_broken_by_us <<<"${stack//|/$'\n'}" || return 1
    done
}

# Inputs that break the library in the fuzzer's process. For each kept one, `lockstone cook` must print an error sentence and end with status 2. For
# each new one it must end without a crash, and the stack in the fuzzer must not begin in our code.
broken_imports_are_contained() {
    local input path kind status report count=0 extensions=(stl ply obj gltf glb fbx off)
    for input in tests/fuzz/corpus/broken/*; do
        status=0
        report=$(build/release/bin/lockstone cook "$input" --seconds 2 -o build/fuzz-corpus/broken.lsa 2>&1) || status=$?
        echo "$report"
        [ "$status" -eq 2 ] && grep -qF "$input: the importer " <<<"$report" || return 1
    done
    for input in build/fuzz-corpus/cook_import-crash-*; do
        [ -e "$input" ] || continue
        kind=$(od -An -tu1 -N1 "$input")
        path=build/fuzz-corpus/broken.${extensions[$((kind % 7))]}
        tail -c +2 "$input" >"$path"
        status=0
        build/release/bin/lockstone cook "$path" -o build/fuzz-corpus/broken.lsa || status=$?
        [ "$status" -le 2 ] || return 1
        report=$(ASAN_OPTIONS=detect_leaks=0 timeout -k 5 60 build/asan/bin/fuzz_cook_import -timeout=2 "$input" 2>&1) || true
        if is_broken_by_us <<<"$report"; then
            echo "$report"
            return 1
        fi
        count=$((count + 1))
    done
    echo "$count inputs broke the importer in this run; those in tests/fuzz/corpus/broken are asked in every run"
}

# The sync test must fail with status 1 and print the column that its snapshots lack.
planted_column_is_named() {
    local report status=0
    report=$(build/release/bin/lockstone synctest rollback-arena --ticks 600 --depth 8 --plant body.velocity) || status=$?
    echo "$report"
    [ "$status" -eq 1 ] && grep -q 'column body.velocity' <<<"$report"
}

planted_leak_is_noticed() {
    local report status=0
    report=$(tests/net/hour.sh build/release/bin/net_peer 20 4096) || status=$?
    echo "$report"
    [ "$status" -eq 1 ] && grep -q '^FAILED: memory grows' <<<"$report"
}

# Every match must fail, print the column that differs, and print a smaller match that still fails. The report runs the tick again in a copy of the
# world. The copy has no planted change, so the report must say that the tick now has another result.
planted_machine_is_found() {
    local report status=0
    report=$(build/release/bin/lockstone match --chaos --plant --seeds 1..8 --ticks 200) || status=$?
    echo "$report"
    [ "$status" -eq 1 ] && [ "$(grep -c 'still fails with: lockstone match' <<<"$report")" -eq 8 ] &&
        [ "$(grep -c 'column body.velocity, row 0' <<<"$report")" -ge 8 ] &&
        [ "$(grep -c 'run again, the tick comes out differently' <<<"$report")" -ge 8 ] && ! grep -q 'ticks of . peers agree' <<<"$report"
}

finish() {
    local passed failed
    wait
    read -r passed failed < <(awk '{ p += $1; f += $2 } END { print p + 0, f + 0 }' "$logs/tally")
    printf '\nwhere the time went (steps of 5 s and more; steps side by side share the clock):\n'
    sort -rn "$logs/times" | awk -F '\t' '{ if ($1 >= 5) printf "%6d s  %6d s of processors  %s\n", $1, $2, $3; all += $2 }
        END { printf "%6d minutes of processors in all\n", all / 60 }'
    printf '%d minutes\n' $((SECONDS / 60))
    if [ -s "$logs/failed" ]; then
        printf '\nfailed:\n'
        awk -F '\t' '{ printf "  %s\n      %s\n", $1, $2 }' "$logs/failed"
        printf '\n'
    fi
    if [ -n "$only" ] && [ -z "$found" ]; then
        echo "tests/run: this tier has no check with the name: $only" >&2
        exit 2
    fi
    printf '%d passed, %d failed\n' "$passed" "$failed"
    [ "$failed" -eq 0 ] && [ "$passed" -gt 0 ] && exit 0
    exit 1
}
