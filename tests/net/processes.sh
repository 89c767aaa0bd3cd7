#!/usr/bin/env bash
# processes.sh NET_PEER [LOCKSTONE]: two processes play over UDP on 127.0.0.1, first through a proxy that loses, delays and reorders packets, then
# by a code through the relay of the command line. Both must confirm every tick with the same hashes.
set -euo pipefail
peer=$1 lockstone=${2:-} ticks=${LOCKSTONE_NET_TICKS:-600}
work=$(mktemp -d)
children=()
trap 'kill "${children[@]}" 2>/dev/null || true; rm -rf "$work"' EXIT
fail() {
    echo "FAILED: $1" >&2
    tail -n 5 "$work"/* >&2
    exit 1
}
agree() { # WHAT: checks that both processes printed the same hash
    local a b
    a=$(grep '^confirmed' "$work/a") && b=$(grep '^confirmed' "$work/b") || fail "$1: somebody said nothing"
    [ "$a" = "$b" ] || fail "$1: '$a' against '$b'"
    echo "$1: $a; $(grep '^rollbacks' "$work/a")"
}
seed=$(od -An -N32 -tx1 /dev/urandom | tr -d ' \n')
source "$(dirname "$0")/free_ports.sh"
read -r a b way c d < <(free_ports 5)

python3 "$(dirname "$0")/slow_way.py" --between $a $b --at $way 40 20 10 >"$work/way" &
children+=($!)
# Both processes send to the proxy, which distinguishes them by their ports.
"$peer" --tokens 127.0.0.1:$a 127.0.0.1:$way --slot 0 --seed "$seed" --port $a --ticks "$ticks" >"$work/a" &
one=$!
"$peer" --tokens 127.0.0.1:$way 127.0.0.1:$b --slot 1 --seed "$seed" --port $b --ticks "$ticks" >"$work/b" &
other=$!
children+=($one $other)
wait $one || fail "10 % loss, 40 to 60 ms: the first did not confirm all"
wait $other || fail "10 % loss, 40 to 60 ms: the second did not confirm all"
agree "10 % loss, 40 to 60 ms each way"

# Planted fault: the second process has keys from another seed. Neither process may connect.
wrong=$(od -An -N32 -tx1 /dev/urandom | tr -d ' \n')
"$peer" --tokens 127.0.0.1:$c 127.0.0.1:$d --slot 0 --seed "$seed" --ticks 30 --patience 120 >"$work/c" &
one=$!
"$peer" --tokens 127.0.0.1:$c 127.0.0.1:$d --slot 1 --seed "$wrong" --ticks 30 --patience 120 >"$work/d" &
other=$!
children+=($one $other)
! wait $one || fail "a peer with other keys was let in"
! wait $other || fail "a peer with other keys was let in"

[ -n "$lockstone" ] || exit 0
refused() { # WORDS ARGUMENT...: checks that the relay ends with status 2 and prints one line to stderr that contains WORDS
    local words=$1 status=0
    shift
    "$lockstone" relay "$@" >/dev/null 2>"$work/err" || status=$?
    [ $status -eq 2 ] && [ "$(wc -l <"$work/err")" -eq 1 ] && grep -qF -- "$words" "$work/err" || fail "relay $*: not refused with '$words'"
}
echo 12 >"$work/short"
refused "none" --key "$work/none"
refused "a key is 64 hexadecimal digits" --key "$work/short"
refused "exists already" --key "$work/short" --new-key
refused "is no address" --key "$work/new" --new-key --address everywhere
refused "give both, or neither" --key "$work/new1" --new-key --second 127.0.0.1:9
refused "has no port" --key "$work/new2" --new-key --second 127.0.0.1:0 --second-key "$work/short"
wait_for() { # WORD NAME: returns when the output of process NAME has a line that begins with WORD, or after 30 s
    for _ in $(seq 300); do
        ! grep -qs "^$1" "$work/$2" || return 0
        sleep 0.1
    done
}
relay_at() { # NAME ARGUMENT...: starts a relay; sets port, key and process
    local name=$1
    shift
    "$lockstone" relay --key "$work/$name.key" --new-key --port 0 --address 127.0.0.1 --seconds $((ticks / 60 + 40)) "$@" >"$work/$name" &
    process=$!
    children+=($process)
    wait_for port "$name"
    read -r _ port _ key < <(tr -d ',' <"$work/$name") || fail "the relay did not say its port"
}
by_code() { # WHAT: two processes connect by a code through the relay at $port and must agree; kills process $lost, if set, during the match
    local what=$1 one other code
    : >"$work/a" # removes the output of an earlier process
    "$peer" --relay "127.0.0.1:$port" --key "$key" --ticks "$ticks" >"$work/a" &
    one=$!
    children+=($one)
    wait_for code a
    code=$(sed -n 's/^code //p' "$work/a")
    [ -n "$code" ] || fail "the lobby gave no code"
    "$peer" --relay "127.0.0.1:$port" --key "$key" --code "$code" --ticks "$ticks" >"$work/b" &
    other=$!
    children+=($other)
    if [ -n "${lost:-}" ]; then
        wait_for playing a
        kill -KILL "$lost"
    fi
    wait $other || fail "$what: who entered by the code did not confirm all"
    wait $one || fail "$what: who opened the room did not confirm all"
    agree "$what"
}
relay_at first
by_code "by a code, through the relay"
relay_at second
second=127.0.0.1:$port
relay_at third --second "$second" --second-key "$work/second.key"
lost=$process
by_code "by a code, through a relay that is lost, and then through the second one"
