#!/usr/bin/env bash
# cli_crash.sh LOCKSTONE: incomplete recordings can be opened and repaired, a recording that a signal ends is complete, memory limits hold.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/cli.sh"
lockstone=$1
own_folder

says() { grep -qF -- "$1" out err || fail "'$1' is not said: $(cat out err)"; }

# ---- a signal: the recording is complete, and the process ends with the signal's status ----
wait_for() { # FILE BYTES: returns when FILE has BYTES; fails after 30 s
    for _ in $(seq 600); do
        [ "$(stat -c %s "$1" 2>/dev/null || echo 0)" -lt "$2" ] || return 0
        sleep 0.05
    done
    fail "$1 does not grow"
}
for signal in TERM INT HUP; do
    # Python starts the run, because a process that this shell starts in the background ignores SIGINT.
    python3 - "$lockstone" $signal <<'PYTHON' || fail "SIG$signal does not end the run as it should"
import os, signal, subprocess, sys, time
number = getattr(signal, "SIG" + sys.argv[2])
signal.signal(signal.SIGINT, signal.SIG_DFL)
run = subprocess.Popen([sys.argv[1], "run", "stack", "--ticks", "100000000", "--record", "signal.lsr"], stdout=subprocess.DEVNULL)
while not os.path.exists("signal.lsr") or os.path.getsize("signal.lsr") < 12000: time.sleep(0.02)
run.send_signal(number)
sys.exit(0 if run.wait(60) == -number else 1)
PYTHON
    expect 0 verify signal.lsr --memory 64
    rm signal.lsr
done

# ---- a crash: the incomplete recording can be opened, with a message ----
"$lockstone" run stack --ticks 100000000 --record killed.lsr >/dev/null &
pid=$!
wait_for killed.lsr 12000
expect 0 info killed.lsr
says 'it is being written'
expect 2 run stack --ticks 10 --record killed.lsr
says 'another recorder is writing it'
kill -KILL $pid
wait $pid 2>/dev/null || true
expect 0 info killed.lsr --json
says '"complete": false'
says 'lockstone repair'
expect 0 replay killed.lsr --to 100
says 'the recording is incomplete'
expect 0 branch killed.lsr --at 50 --ticks 5 -o branch.lsr
expect 0 verify branch.lsr
expect 0 diff killed.lsr killed.lsr
expect 2 verify killed.lsr
says 'all agree'
expect 0 repair killed.lsr -o whole.lsr
expect 0 verify whole.lsr
expect 2 repair whole.lsr -o again.lsr
says 'is complete'
expect 2 repair killed.lsr -o ./killed.lsr

# ---- a damaged recording is refused; repair recovers its undamaged start ----
cp whole.lsr damaged.lsr
flip damaged.lsr $(($(stat -c %s damaged.lsr) * 3 / 4))
expect 2 replay damaged.lsr
expect 0 repair damaged.lsr -o mended.lsr
expect 0 verify mended.lsr

# ---- a file that is removed while the recorder writes it ----
"$lockstone" run stack --ticks 100000000 --record gone.lsr >out 2>err &
pid=$!
wait_for gone.lsr 9000
rm gone.lsr
status=0
wait $pid || status=$?
[ $status -eq 2 ] || fail "a removed file ends the run with $status"
says 'was removed'

# ---- limits ----
expect 0 verify whole.lsr --memory 16 --jobs 16
expect 0 run pile --size 1000 --ticks 3 --record pile.lsr
expect 0 verify pile.lsr --memory 512 --jobs 16
# For each command with the option --memory: 16 MB are enough to read the recording, but not to play it.
limited=0
for command in $("$lockstone" --help | sed -n '/^Subcommands/,$s/^  \([a-z-]*\)  .*/\1/p'); do
    [[ $("$lockstone" "$command" --help) == *--memory* ]] || continue
    limited=$((limited + 1))
    expect 2 "$command" pile.lsr --memory 15
    case $command in
        verify | replay) expect 2 "$command" pile.lsr --memory 16 ;;
        branch) expect 2 branch pile.lsr --memory 16 --at 1 -o branched.lsr ;;
        diff) # diff plays differing states again to find the phase in which they differ
            expect 0 run pile --size 1000 --seed 2 --ticks 3 --record other.lsr
            expect 2 diff pile.lsr other.lsr --memory 16
            ;;
        info | repair | cook) continue ;; # these commands play no recording; cook_end_to_end.sh checks the limit of cook
        *) fail "no case here for --memory of '$command'" ;;
    esac
    says '--memory'
done
[ $limited -eq 7 ] || fail "$limited commands have --memory"

# ---- a long run prints each result at once, so a killed run has printed its results so far ----
"$lockstone" match --seeds 1..1000000 --ticks 30 >lines &
pid=$!
wait_for lines 1
kill -KILL $pid
wait $pid 2>/dev/null || true
grep -q 'peers agree' lines || fail "match printed nothing until it was killed"
echo "ok"
