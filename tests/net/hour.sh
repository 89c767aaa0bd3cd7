#!/usr/bin/env bash
# hour.sh NET_PEER [SECONDS [LEAK]]: two processes play for SECONDS (default: an hour) over UDP on 127.0.0.1, at 5 % loss and 80 to 120 ms each way.
# Both must confirm all ticks with the same hashes. The memory of each may grow by at most 1 MiB and 16 bytes for each of nine tenths of the ticks;
# the 16 bytes are the process's own list of hashes. The growth counts from a tenth of the time on, but not before 8 s: after 8 s even the slowest
# process has connected and has filled its log of 256 ticks. LEAK: bytes that each process loses in every frame, a planted fault.
set -euo pipefail
peer=$1 seconds=${2:-3600} leak=${3:-0}
ticks=$((seconds * 60)) slack_kb=1024
warm=$((seconds / 10 > 8 ? seconds / 10 : 8))
work=$(mktemp -d)
children=()
trap 'kill "${children[@]}" 2>/dev/null || true; rm -rf "$work"' EXIT
seed=$(od -An -N32 -tx1 /dev/urandom | tr -d ' \n')
source "$(dirname "$0")/free_ports.sh"
read -r a b way < <(free_ports 3)
python3 "$(dirname "$0")/slow_way.py" --between $a $b --at $way 80 40 5 >"$work/way" &
children+=($!)
"$peer" --tokens 127.0.0.1:$a 127.0.0.1:$way --slot 0 --seed "$seed" --port $a --ticks $ticks --leak "$leak" >"$work/a" &
children+=($!)
"$peer" --tokens 127.0.0.1:$way 127.0.0.1:$b --slot 1 --seed "$seed" --port $b --ticks $ticks --leak "$leak" >"$work/b" &
children+=($!)

kilobytes() { awk '$1 == "VmRSS:" { print $2 }' "/proc/$1/status" 2>/dev/null || true; }
first=() last=()
begin=$SECONDS
while kill -0 "${children[1]}" 2>/dev/null && kill -0 "${children[2]}" 2>/dev/null; do
    for k in 1 2; do
        now=$(kilobytes "${children[$k]}")
        [ -n "$now" ] || continue
        [ $((SECONDS - begin)) -ge $warm ] && [ -z "${first[$k]:-}" ] && first[$k]=$now
        last[$k]=$now
    done
    sleep 1
done
good=0
for k in 1 2; do wait "${children[$k]}" || good=1; done
cat "$work/a" "$work/b"
[ "$good" -eq 0 ] || { echo "FAILED: not all ticks were confirmed"; exit 1; }
[ "$(grep '^confirmed' "$work/a")" = "$(grep '^confirmed' "$work/b")" ] || { echo "FAILED: the hashes differ"; exit 1; }
for k in 1 2; do
    most=$((16 * ticks * 9 / 10 / 1024 + slack_kb))
    echo "process $k: ${first[$k]} kB after $warm s, ${last[$k]} kB at the end; it may grow by $most kB"
    [ $((last[k] - first[k])) -le "$most" ] || good=1
done
[ "$good" -eq 0 ] || echo "FAILED: memory grows"
exit $good
