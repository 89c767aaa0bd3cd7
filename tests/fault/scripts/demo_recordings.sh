#!/usr/bin/env bash
# demo_recordings.sh LOCKSTONE DEMO: a recording that a signal ends is complete, and the demo plays the incomplete recording of a crash.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/cli.sh"
lockstone=$1 demo=$2
samples=$(cd "$(dirname "${BASH_SOURCE[0]}")/../../../tools/cook/samples" && pwd)
own_folder
unset DISPLAY WAYLAND_DISPLAY

# record FILE SIGNAL: starts the demo, sends it the signal when the file has 12,000 bytes, and checks that the signal ends the demo.
record() {
    python3 - "$demo" "$1" "$2" <<'PYTHON'
import os, signal, subprocess, sys, time
demo, path, number = sys.argv[1], sys.argv[2], getattr(signal, "SIG" + sys.argv[3])
signal.signal(signal.SIGINT, signal.SIG_DFL)  # the shell may have set SIGINT to be ignored
run = subprocess.Popen([demo, "stack", "--offscreen", "--script", "--ticks", "1000000", "--frame-every", "1000000", "--record", path],
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
end = time.time() + 60
while not os.path.exists(path) or os.path.getsize(path) < 12000:
    if run.poll() is not None or time.time() > end: sys.exit("the recording does not grow")
    time.sleep(0.02)
run.send_signal(number)
sys.exit(0 if run.wait(60) == -number else f"the demo ends with {run.returncode}")
PYTHON
}
# shows STATUS FILE: plays the recording with the demo and fails if the demo ends with another status.
shows() {
    local status=0
    "$demo" "$2" --offscreen --script --frame-every 1000000 >out 2>err || status=$?
    [ $status -eq "$1" ] || fail "showing $2 ends with $status instead of $1: $(cat out err)"
}

for signal in TERM INT HUP; do
    record "$signal.lsr" "$signal" || fail "SIG$signal does not end the recording"
    expect 0 verify "$signal.lsr"
done
shows 0 TERM.lsr
! grep -q incomplete out err || fail "a whole recording is called incomplete"

# Counter-check: a killed demo leaves an incomplete recording, and both the command line and the demo report it.
record killed.lsr KILL || fail "a killed demo ends otherwise"
expect 2 verify killed.lsr
shows 0 killed.lsr
grep -q 'the recording is incomplete' err || fail "what is missing is not said: $(cat err)"
expect 0 repair killed.lsr -o whole.lsr
expect 0 verify whole.lsr

cp whole.lsr damaged.lsr
flip damaged.lsr $(($(stat -c %s damaged.lsr) / 2))
shows 2 damaged.lsr

# The demo does not write to a file that it reads, under any of the file's names. If it cannot write a recording, it ends before it plays.
keeps() { # WORDS FILE ARGUMENT...: checks for status 2, an error that contains WORDS, and an unchanged file
    local words=$1 file=$2 before status=0
    before=$(sha256sum "$2")
    shift 2
    "$demo" rollback-arena --offscreen --script --ticks 50 --frame-every 1000000 "$@" >out 2>err || status=$?
    [ $status -eq 2 ] && grep -qF -- "$words" err || fail "'$*' is not refused with '$words' ($status): $(cat out err)"
    [ "$(sha256sum "$file")" = "$before" ] || fail "'$*' has written over $file"
}
printf '0 0 7f0000\n' >same.txt
keeps '--machines goes with --host' same.txt --machines 3
keeps '--latency and --loss go with --netplay' same.txt --latency 100
keeps '--latency and --loss go with --netplay' same.txt --host --loss 1
keeps '--plant goes with --host or --join' same.txt --watch x --plant 60
keeps "'-1' is not a whole number" same.txt --seed -1
keeps 'is not a whole number from 0 to 18446744073709551615' same.txt --seed 99999999999999999999
keeps "'-1' is not a whole number" same.txt --size -1
expect 0 run rollback-arena --ticks 60 --record same.lsr
ln same.lsr link.lsr
expect 0 run stack --ticks 0 --record nothing.lsr
shows 1 nothing.lsr
grep -q 'no tick was compared' out || fail "a recording of no tick is called: $(cat out)"
if [ -f "$samples/gem.stl" ] && "$lockstone" cook "$samples/gem.stl" -o gem.lsa >/dev/null 2>&1; then
    sum=$(sha256sum gem.lsa) status=0
    "$demo" --asset gem.lsa --record gem.lsa --offscreen --script --ticks 5 >out 2>err || status=$?
    [ $status -eq 2 ] && [ "$(sha256sum gem.lsa)" = "$sum" ] || fail "an asset is written over by its recording: $(cat out err)"
fi
for way in "" --netplay; do
    # shellcheck disable=SC2086
    {
        keeps 'is also an input file' same.txt $way --input same.txt --record same.txt
        keeps 'is also an input file' same.lsr $way --input same.lsr --record ./same.lsr
        keeps 'is also an input file' same.lsr $way --input same.lsr --record link.lsr
        keeps 'nowhere/x.lsr: cannot write' same.lsr $way --record nowhere/x.lsr
    }
done
echo "ok"
