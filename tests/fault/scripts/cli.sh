# Functions of the scripts that test the command line. The caller sets lockstone. The output of the last command is in the files out and err.
# shellcheck shell=bash disable=SC2154

# Makes a temporary folder, changes into it, and deletes it when the script ends.
own_folder() {
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
    cd "$work"
}

fail() {
    echo "FAILED: $1" >&2
    exit 1
}

# expect STATUS ARGUMENT...: runs lockstone and fails if it ends with another status
expect() {
    local wanted=$1 status=0
    shift
    "$lockstone" "$@" >out 2>err || status=$?
    [ "$status" -eq "$wanted" ] || fail "'lockstone $*' ended with $status instead of $wanted; it printed: $(cat out err)"
}

# begin NAME COMMAND...: starts the command in the background, for at most $patience seconds; sets process, and adds it to children. The output goes
# to the file NAME. The function empties this file first, so that a search in it does not find output of an earlier process.
begin() {
    local name=$1
    shift
    : >"$name"
    timeout "$patience" "$@" >"$name" 2>&1 &
    process=$!
    children+=("$process")
}

# flip FILE BYTE: inverts one bit of this byte.
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
