#!/usr/bin/env bash
# demo_broadcast.sh LOCKSTONE DEMO: two demos play over UDP, `lockstone broadcast` shows the match, and three demos watch it with one code. The
# script kills the host during the match. The broadcast continues from the second machine, and its three watchers get all ticks that this machine
# has confirmed. A second broadcast has the host as its only source: its watcher ends with an error.
set -euo pipefail
here=$(dirname "${BASH_SOURCE[0]}")
source "$here/cli.sh"
lockstone=$1 demo=$2 ticks=${LOCKSTONE_ONLINE_TICKS:-600}
work=$(mktemp -d)
children=()
trap 'kill "${children[@]}" 2>/dev/null || true; wait 2>/dev/null || true; rm -rf "$work"' EXIT
cd "$work"
unset DISPLAY WAYLAND_DISPLAY
patience=$((ticks / 60 + 110)) # [s], long enough for a busy machine
view=(--offscreen --script --width 320 --height 200 --frame-every 100000)

# said WORDS FILE [NTH]: sets words to the text after WORDS in the NTH (first) line that begins with WORDS; fails after 30 s without such a line.
said() {
    for _ in $(seq 300); do
        words=$(sed -n "s/^$1 //p" "$2" | sed -n "${3:-1}p")
        [ -z "$words" ] || return 0
        sleep 0.1
    done
    fail "'$1' is not said in $2: $(cat "$2")"
}
ends() { # STATUS NAME PROCESS: fails if the process ends with another status
    local status=0
    wait "$3" || status=$?
    [ $status -eq "$1" ] || fail "$2 ends with $status instead of $1: $(cat "$2")"
}
shows() { # NAME CODE...: starts a broadcast of a match that these codes show; sets process, and watching to the code of the broadcast
    local name=$1
    shift
    begin "$name" "$lockstone" broadcast "$@" --key "$name.key" --new-key --port 0 --address 127.0.0.1
    local broadcasts=$process
    said 'to watch: lockstone-demo --watch' "$name"
    watching=$words process=$broadcasts
}
watches() { # NAME: starts a demo that watches the broadcast $watching; sets process
    begin "$1" "$demo" --watch "$watching" "${view[@]}" --frames "$1-frames" --record "$1.lsr"
}
last_hash() { sed -n 's/.* ticks confirmed, hash \([0-9a-f ]*\),.*/\1/p' "$1"; }
agree() { [ -n "$(last_hash "$1")" ] && [ "$(last_hash "$1")" = "$(last_hash "$2")" ] && cmp -s "$1.lsr" "$2.lsr"; }

begin relay "$lockstone" relay --key relay.key --new-key --port 0 --address 127.0.0.1
said port relay
at=127.0.0.1:${words%%,*}#${words##* }
begin a "$demo" cars --host --relay "$at" --players 2 --ticks "$ticks" "${view[@]}" --frames a-frames
host=$process
said 'to join: lockstone-demo --join' a
begin b "$demo" --join "$words" "${view[@]}" --frames b-frames --record b.lsr
second=$process
said 'to watch: lockstone-demo --watch' a
first_shows=$words
said 'to watch: lockstone-demo --watch' b
shows d "$first_shows" "$words"
broadcast=$process
for each in 1 2 3; do
    watches w$each
    watchers[each]=$process
done
# Planted fault: this broadcast has the host as its only source, so its watcher does not see the end.
said 'to watch: lockstone-demo --watch' a 2
shows e "$words"
watches v
alone=$process
for _ in $(seq 40); do
    [ ! -s w3 ] || break
    sleep 0.1
done
sleep 2
pkill -KILL -P "$host" || fail "the host has ended before it was killed: $(cat a)"
ends 0 b $second
for each in 1 2 3; do
    ends 0 w$each "${watchers[each]}"
    agree b w$each || fail "who watches has seen another match: $(cat b w$each)"
    grep -q "$ticks of $ticks ticks bit-exact" w$each || fail "what was watched is not verified: $(cat w$each)"
done
ends 0 d $broadcast
grep -q "^showed $ticks of $ticks ticks to at most 3 at one time" d || fail "the broadcast tells something else: $(cat d)"
ends 2 v $alone
grep -q 'the host has sent nothing for 20 seconds' v || fail "who is shown the host alone is told something else: $(cat v)"
expect 0 verify v.lsr # the recording of the ticks that the watcher saw
echo "broadcast: $(tail -n 1 d)"

refused() { # WORDS ARGUMENT...: checks for status 2 and one error sentence that contains WORDS
    local words=$1 status=0
    shift
    "$lockstone" broadcast "$@" --port 0 >out 2>err || status=$?
    [ $status -eq 2 ] && [ "$(grep -c . err)" -eq 1 ] && grep -qF -- "$words" err || fail "broadcast $*: not refused with '$words': $(cat out err)"
}
refused "is no invitation" ABC --key relay.key
refused 'needs the code too' "$at" --key relay.key
refused 'exists already' "ABCDEFGH@$at" --key relay.key --new-key
refused 'the lobby knows no such code' "ABCDEFGH@$at" --key relay.key
echo ok
