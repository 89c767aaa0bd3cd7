# What the scripts that drive the command line share. Expects: lockstone. Leaves the last command's output in out and err.
# shellcheck shell=bash disable=SC2154

# Everything happens in a folder of its own, which is gone at the end.
own_folder() {
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
    cd "$work"
}

fail() {
    echo "FAILED: $1" >&2
    exit 1
}

# expect STATUS ARGUMENT...
expect() {
    local wanted=$1 status=0
    shift
    "$lockstone" "$@" >out 2>err || status=$?
    [ "$status" -eq "$wanted" ] || fail "'lockstone $*' ended with $status instead of $wanted; it printed: $(cat out err)"
}

# begin NAME COMMAND...: in the background, at most $patience seconds; sets process, and adds it to children. All that it says goes into the file NAME,
# which is empty before it starts: whoever waits for words in it does not find those of an earlier process.
begin() {
    local name=$1
    shift
    : >"$name"
    timeout "$patience" "$@" >"$name" 2>&1 &
    process=$!
    children+=("$process")
}

# flip FILE BYTE: turns one bit round.
flip() {
    python3 - "$1" "$2" <<'PYTHON'
import sys
with open(sys.argv[1], "r+b") as file:
    file.seek(int(sys.argv[2]))
    byte = file.read(1)[0]
    file.seek(int(sys.argv[2]))
    file.write(bytes([byte ^ 0x10]))
PYTHON
}
