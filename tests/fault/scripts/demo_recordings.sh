#!/usr/bin/env bash
# demo_recordings.sh LOCKSTONE DEMO: a signal ends what the demo records properly, and what a crash left of a recording is shown.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/cli.sh"
lockstone=$1 demo=$2
own_folder
unset DISPLAY WAYLAND_DISPLAY

# record FILE SIGNAL: the demo plays until the file has grown, and is sent the signal. Its status is that of the signal.
record() {
    python3 - "$demo" "$1" "$2" <<'PYTHON'
import os, signal, subprocess, sys, time
demo, path, number = sys.argv[1], sys.argv[2], getattr(signal, "SIG" + sys.argv[3])
signal.signal(signal.SIGINT, signal.SIG_DFL)  # this shell may ignore Ctrl-C
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
# shows STATUS FILE: the demo plays the recording.
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

# The planted twin of a signal: a crash leaves no end, and both notice.
record killed.lsr KILL || fail "a killed demo ends otherwise"
expect 2 verify killed.lsr
shows 0 killed.lsr
grep -q 'the recording is incomplete' err || fail "what is missing is not said: $(cat err)"
expect 0 repair killed.lsr -o whole.lsr
expect 0 verify whole.lsr

cp whole.lsr damaged.lsr
flip damaged.lsr $(($(stat -c %s damaged.lsr) / 2))
shows 2 damaged.lsr
echo "ok"
