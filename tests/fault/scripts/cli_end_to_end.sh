#!/usr/bin/env bash
# cli_end_to_end.sh LOCKSTONE: every scene is recorded, replayed and verified; recordings of two scenes are branched; damaged ones are refused.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/cli.sh"
lockstone=$1
own_folder

small() { # SCENE: prints the option of a size that runs quickly
    case $1 in
        pyramid) echo --size 8 ;;
        pile) echo --size 60 ;;
        convex-pile | washer) echo --size 40 ;;
        terrain) echo --size 20 ;;
        domino | bridge) echo --size 30 ;;
        ragdolls) echo --size 3 ;;
        wrecking-ball) echo --size 8 ;;
        water) echo --size 12 ;;
        blast) echo --size 3 ;;
    esac
}

# ---- every scene: recorded; a second run and a replay give the same bits ----
mapfile -t scenes < <("$lockstone" scenes | awk '{ print $1 }')
[ ${#scenes[@]} -ge 6 ] || fail "scenes lists ${#scenes[@]} scenes"
for scene in "${scenes[@]}"; do
    mapfile -t size < <(small "$scene" | tr ' ' '\n')
    expect 0 run "$scene" "${size[@]}" --ticks 150 --seed 3 --keyframes 50 --record "$scene.lsr" --hashes "$scene.tsv" --report "$scene.json"
    [ "$(wc -l <"$scene.tsv")" -eq 150 ] || fail "$scene.tsv does not hold 150 ticks"
    grep -qP '^149\t[0-9a-f]{16}$' "$scene.tsv" || fail "$scene.tsv does not end with tick 149 and its hash"
    [ "$(tail -n 1 "$scene.tsv" | cut -f 2)" = "$(python3 -c 'import json, sys; print(json.load(open(sys.argv[1]))["hash"])' "$scene.json")" ] ||
        fail "$scene: the report's hash is not the last of the hashes"
    expect 0 run "$scene" "${size[@]}" --ticks 150 --seed 3 --hashes again.tsv
    cmp "$scene.tsv" again.tsv || fail "$scene: two runs differ"
    expect 0 replay "$scene.lsr" --hashes replayed.tsv
    cmp "$scene.tsv" replayed.tsv || fail "$scene: the replay's hashes differ"
    expect 0 replay "$scene.lsr" --from 70 --to 120
    expect 0 verify "$scene.lsr" --jobs 2
    expect 0 info "$scene.lsr" --json
    expect 0 synctest "$scene" "${size[@]}" --ticks 40 --depth 5
done
expect 0 verify ./*.lsr
for shard in 0 1 2; do expect 0 verify pile.lsr --shard $shard/3; done

# ---- the report's keys ----
for key in bodies awake contacts penetration_max_m drift_max_m displacement_max_m kinetic_energy_j tick_us_median tick_us_p99 \
    snapshot_bytes save_us restore_us hash; do
    grep -q "\"$key\":" stack.json || fail "the report lacks $key"
done

# ---- inputs from a recording and from a text file; other seeds and inputs give other hashes ----
expect 0 run rollback-arena --seed 3 --ticks 150 --input rollback-arena.lsr --hashes again.tsv
cmp rollback-arena.tsv again.tsv || fail "the inputs of a recording do not repeat its run"
printf '# tick player bytes\n0 0 7f0000\n30 0 -\n30 1 008102\n' >inputs.txt
expect 0 run rollback-arena --seed 3 --ticks 150 --input inputs.txt --hashes typed.tsv
! cmp -s rollback-arena.tsv typed.tsv || fail "other inputs gave the same hashes"
expect 0 run rollback-arena --seed 4 --ticks 150 --hashes seed4.tsv
! cmp -s rollback-arena.tsv seed4.tsv || fail "another seed gave the same hashes"

# ---- branches and differences ----
expect 0 branch rollback-arena.lsr --at 100 --input inputs.txt -o branch.lsr
expect 0 verify branch.lsr
expect 1 diff rollback-arena.lsr branch.lsr
grep -q 'tick 10[0-9]' out || fail "diff does not name the tick where the branch leaves: $(cat out)"
expect 0 diff rollback-arena.lsr rollback-arena.lsr
expect 0 branch pile.lsr --at 60 --ticks 20 -o branch.lsr
expect 0 verify branch.lsr

# ---- a file with an inverted bit is refused, wherever the bit is ----
bytes=$(stat -c %s rollback-arena.lsr)
for at in 3 20 200 $((bytes / 2)) $((bytes - 100)) $((bytes - 1)); do
    cp rollback-arena.lsr damaged.lsr
    flip damaged.lsr "$at"
    expect 2 verify damaged.lsr
    grep -q 'damaged.lsr' err || fail "the sentence does not name the file: $(cat err)"
    expect 2 replay damaged.lsr
    expect 2 info damaged.lsr
done
head -c $((bytes - 500)) rollback-arena.lsr >cut.lsr
expect 2 verify cut.lsr
expect 2 verify rollback-arena.lsr cut.lsr # one bad file beside a good one

# ---- diff finds tick and phase of the first difference, and prints only the first 8 columns ----
expect 0 branch rollback-arena.lsr --at 20 --ticks 30 -o other.lsr
expect 1 diff rollback-arena.lsr other.lsr
grep -Eq '^first differing tick: 2[0-9]' out && grep -q '^first differing phase' out || fail "a branch is not told by tick and phase: $(cat out)"
for seed in 1 2; do expect 0 run pile --size 20 --ticks 5 --seed $seed --record pile$seed.lsr; done
expect 1 diff pile1.lsr pile2.lsr # the 20 boxes have other positions
[ "$(grep -c '^  column' out)" -eq 8 ] && grep -q '^  and more: these are the first 8$' out || fail "diff ends after 8 and does not say so: $(cat out)"

# ---- a command prints how much it compared; without any comparison it is refused or prints a note ----
expect 0 synctest rollback-arena --ticks 20 --depth 4
grep -q ': 20 ticks, 16 times rolled back 4 ticks and run again, 64 hashes compared: bit-exact, hash' out || fail "synctest tells something else: $(cat out)"
expect 0 self-test
grep -q '^20 worlds, 3 ticks each, agree with the stored hashes: scalar' out || fail "self-test tells something else: $(cat out)"
expect 0 self-test --hashes
[ "$(grep -cE '^[0-9a-f]{16}$' out)" -eq 60 ] || fail "self-test --hashes prints something else: $(head -n 3 out)"
for few in "0 --depth 1" "7" "20 --depth 64"; do
    # shellcheck disable=SC2086
    expect 2 synctest rollback-arena --ticks $few
    grep -q 'nothing would be compared' err && ! grep -q 'bit-exact' out || fail "synctest --ticks $few compares nothing, and says: $(cat out err)"
done
expect 0 replay rollback-arena.lsr --from 5 --to 5
grep -q 'the range contains no tick; the state at time 5 has the recorded hash' out || fail "replay of no tick says: $(cat out)"
! grep -q 'bit-exact' out || fail "replay of no tick calls it bit-exact"

# ---- planted faults: snapshots lack one column ----
for column in body.velocity game.match contact.memory; do
    "$lockstone" synctest rollback-arena --ticks 8 --plant "$column" >/dev/null 2>&1 || [ $? -ne 2 ] || continue # status 2: this scene has no such column
    expect 1 synctest rollback-arena --ticks 200 --plant "$column"
    grep -q "$column" out || fail "synctest does not name $column: $(cat out)"
done

# ---- matches ----
expect 0 match --seeds 1..2 --peers 3 --loss 10 --latency 70 --ticks 120 --record-prefix m
expect 0 verify m-1-1.lsr m-1-2.lsr m-1-3.lsr m-2-1.lsr
expect 0 diff m-1-1.lsr m-1-3.lsr
expect 0 info m-1-3.lsr
grep -qF '"match.peer":"3"' out || fail "the file of machine 3 names another one: $(grep options out)"
expect 0 match --peers 2 --mode lockstep --ticks 60
grep -q ' 0 rollbacks' out || fail "lockstep rolled back: $(cat out)"
expect 0 match --seeds 18446744073709551615 --ticks 30 # the largest seed: the loop must not continue at 0
[ "$(wc -l <out)" -eq 1 ] || fail "the last seed is not the only one: $(cat out)"
# A packet contains the lower half of a hash, and the message calls it so. The whole hashes in the recordings must end with these digits.
expect 1 match --plant --ticks 60 --record-prefix planted
ours=$(sed -n 's/^machine 1 and machine 2 differ after tick 30: lower half of the hash \([0-9a-f]\{8\}\) against .*/\1/p' out)
theirs=$(sed -n 's/^machine 1 and machine 2 differ after tick 30: lower half of the hash .* against \([0-9a-f]\{8\}\)$/\1/p' out)
[ -n "$ours" ] && [ -n "$theirs" ] || fail "half a hash is not told as half: $(cat out)"
expect 0 replay planted-1-1.lsr --from 30 --to 31 --hashes planted.tsv
grep -Eq "^30[[:space:]][0-9a-f]{8}$ours$" planted.tsv || fail "machine 1 has another hash than was told, $ours: $(cat planted.tsv)"
expect 1 replay planted-1-2.lsr --from 30 --to 31
grep -Eq "against [0-9a-f]{8}$theirs$" out || fail "machine 2 has recorded another hash than was told, $theirs: $(cat out)"
# A lost connection is reported as a loss, with the number of the machine, and not as a difference.
expect 1 match --latency 10000 --ticks 60
grep -q 'machine 2: lost the connection to machine 1; from tick' out && grep -q 'machine 1: player 2 left at tick' out || fail "a loss is not told: $(cat out)"
! grep -q 'differs from' out || fail "a loss is called a difference: $(cat out)"
echo "ok"
