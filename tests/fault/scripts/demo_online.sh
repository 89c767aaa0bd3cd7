#!/usr/bin/env bash
# demo_online.sh LOCKSTONE DEMO: demos play each other over UDP, controlled by bots: their hashes are equal and their recordings verify. A planted
# difference of the worlds is reported, and each error has its own sentence.
set -euo pipefail
here=$(dirname "${BASH_SOURCE[0]}")
source "$here/cli.sh"
lockstone=$1 demo=$2 ticks=${LOCKSTONE_ONLINE_TICKS:-600}
slow_way=$(realpath "$here/../../net/slow_way.py")
work=$(mktemp -d)
children=()
trap 'kill "${children[@]}" 2>/dev/null || true; wait 2>/dev/null || true; rm -rf "$work"' EXIT
cd "$work"
unset DISPLAY WAYLAND_DISPLAY
patience=$((ticks / 60 + 110)) # [s], long enough for a busy machine
view=(--offscreen --script --width 640 --height 400 --frame-every 300)

# wait_for WORDS FILE PROCESS: returns when FILE contains WORDS; fails after 30 s, or when the process has ended
wait_for() {
    for _ in $(seq 300); do
        grep -q "$1" "$2" && return
        kill -0 "$3" 2>/dev/null || break
        sleep 0.1
    done
    fail "'$1' is not said in $2: $(tail -n 20 [a-z] 2>/dev/null)"
}
# host NAME ARGUMENT...: starts a demo that hosts a match in the background; sets hosted, its process, and invitation.
host() {
    local name=$1
    shift
    begin "$name" "$demo" "$@" --host "${view[@]}" --frames "$name-frames" --record "$name.lsr"
    hosted=$process
    wait_for '^to join' "$name" $hosted
    invitation=$(sed -n 's/^to join: lockstone-demo --join //p' "$name")
}
# join NAME ARGUMENT...: starts a demo that joins by the invitation in the background; sets joined, its process.
join() {
    local name=$1
    shift
    begin "$name" "$demo" --join "$invitation" "$@" "${view[@]}" --frames "$name-frames" --record "$name.lsr"
    joined=$process
}
# ends STATUS NAME PROCESS: fails if the process ends with another status
ends() {
    local status=0
    wait "$3" || status=$?
    [ $status -eq "$1" ] || fail "$2 ends with $status instead of $1: $(cat "$2")"
}
last_hash() { sed -n 's/.* ticks confirmed, hash \([0-9a-f ]*\),.*/\1/p' "$1"; }
# agree NAME NAME: succeeds if both have confirmed the same hash and their recordings are equal.
agree() { [ -n "$(last_hash "$1")" ] && [ "$(last_hash "$1")" = "$(last_hash "$2")" ] && cmp -s "$1.lsr" "$2.lsr"; }
# through_slow_way: changes the invitation, so that later joins go through a proxy that delays packets by 40 to 60 ms each way.
through_slow_way() {
    local port=${invitation%#*}
    port=${port##*:}
    python3 "$slow_way" "$port" 40 20 >way &
    children+=($!)
    wait_for '^[0-9]' way $!
    invitation=${invitation/:$port#/:$(cat way)#}
}

# Two machines, three players: the third player is a bot. The joining machine has a delay of 40 to 60 ms each way.
host a rollback-arena --players 3 --ticks "$ticks"
through_slow_way
join b
ends 0 a $hosted
ends 0 b $joined
agree a b || fail "two machines do not agree: $(cat a b)"
grep -q "$ticks of $ticks ticks bit-exact" a || fail "the host's recording is not verified: $(cat a)"
grep -q "$ticks of $ticks ticks bit-exact" b || fail "the other recording is not verified: $(cat b)"
expect 0 verify a.lsr b.lsr
rollbacks=$(sed -n 's/.*, \([0-9]*\) rollbacks.*/\1/p' b)
[ "$rollbacks" -gt 0 ] || fail "nothing was rolled back in spite of the way: $(cat b)"
echo "two machines: $(grep confirmed b)"
# Planted faults of the comparison: another hash, and another recording.
sed 's/hash [0-9a-f]*/hash 0000/' b >c
cp b.lsr c.lsr
! agree a c || fail "another hash agrees"
cp b c
flip c.lsr 100
! agree a c || fail "another recording agrees"

# Three machines, four cars, and a watcher. The demos draw the smallest pictures, and only the last of them.
large=("${view[@]}")
view=(--offscreen --script --width 64 --height 64 --frame-every 100000)
host a cars --machines 3 --players 4 --ticks "$ticks"
join b
second=$joined
join c
third=$joined
wait_for '^to watch' a $hosted
watching=$(sed -n 's/^to watch: lockstone-demo --watch //p' a | head -n 1)
begin w "$demo" --watch "$watching" "${view[@]}" --frames w-frames --record w.lsr
watcher=$process
ends 0 a $hosted
ends 0 b $second
ends 0 c $third
ends 0 w $watcher
agree a b && agree a c || fail "three machines do not agree: $(cat a b c)"
agree a w || fail "who watches has seen another match: $(cat a w)"
grep -q "$ticks of $ticks ticks bit-exact" w || fail "what was watched is not verified: $(cat w)"
echo "three machines: $(grep confirmed c)"
view=("${large[@]}")

# Planted fault: the world of one machine is changed. Both machines must print tick, column and row, and must not report the match as bit-exact.
host a rollback-arena --ticks 300
join b --plant 60
ends 1 a $hosted
ends 1 b $joined
for each in a b; do
    grep -Eq 'the worlds differ: tick 60, machine [12]: phase [a-z_]+, (column .*, row [0-9]+|row count of).* against' $each || fail "where the worlds differ is not told: $(cat $each)"
    ! grep -q 'bit-exact' $each || fail "a match with a desync is called bit-exact: $(cat $each)"
    grep -Eq '^  tick 60: lower half of the hash [0-9a-f]{8} against [0-9a-f]{8}, inputs' $each || fail "the ticks are not told: $(cat $each)"
done
# Each machine has recorded its own match. The host's recording verifies; the recording of the changed machine differs from tick 60 on.
expect 0 verify a.lsr
expect 1 verify b.lsr
grep -q 'tick 60' out || fail "the planted tick is not the first that is wrong: $(cat out)"
echo "planted: $(tail -n 1 b)"

# refused STATUS WORDS ARGUMENT...: checks for the status and one error sentence that contains WORDS.
refused() {
    local wanted=$1 words=$2 status=0
    shift 2
    timeout "$patience" "$demo" "$@" "${view[@]}" --frames refused-frames >out 2>err || status=$?
    [ $status -eq "$wanted" ] || fail "'$*' ends with $status instead of $wanted: $(cat out err)"
    [ "$(grep -c . err)" -eq 1 ] && grep -q -- "$words" err || fail "about '$*' this is not said alone: $words, but: $(cat err)"
}
refused 2 'is no invitation: write CODE@ADDRESS:PORT#KEY' --join ABCDEFGH
refused 2 'is no invitation: .* is no address' --join "ABCDEFGH@somewhere#${invitation#*#}"
refused 2 '64 hexadecimal digits' --join 'ABCDEFGH@127.0.0.1:7700#12'
refused 2 'needs the code too' --join "${invitation#*@}"
refused 2 'nowhere/x.lsr: cannot write: No such file' --host --record nowhere/x.lsr
refused 2 'only one can be shown' --host --join "$invitation"
refused 2 'pyramid has 0 players, and 2 machines need one each' pyramid --host
refused 2 "the relay at 127.0.0.1:9 does not answer" --join "ABCDEFGH@127.0.0.1:9#${invitation#*#}"

host a rollback-arena --ticks 3000
refused 2 'refuses the code ABCDEFGH: the lobby knows no such code' --join "ABCDEFGH@${invitation#*@}"
refused 2 'the host plays rollback-arena, and this machine was asked to play cars' cars --join "$invitation"
refused 2 'all players of this code are there already' --join "$invitation"
# The relay ends while the host waits in its lobby: the host ends with an error after ten seconds without an answer, before the room would close.
# While the relay runs, the host keeps waiting, also longer than ten seconds.
begin relay "$lockstone" relay --key relay.key --new-key --port 0 --address 127.0.0.1
relay=$process
wait_for '^port' relay $relay
at=$(sed -n 's/^port \([0-9]*\), key \(.*\)/127.0.0.1:\1#\2/p' relay)
host a rollback-arena --ticks 60 --relay "$at"
sleep 11
kill -0 $hosted 2>/dev/null || fail "the host gave up while its relay runs: $(cat a)"
kill $relay
ends 2 a $hosted
grep -q 'has not answered for 10 seconds' a || fail "a relay that ended is not told: $(cat a)"

[ "$(find a-frames refused-frames -name '*.png' 2>/dev/null | wc -l)" -gt 0 ] || echo "no pictures: OpenGL is not there"
echo ok
