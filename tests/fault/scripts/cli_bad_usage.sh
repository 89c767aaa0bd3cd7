#!/usr/bin/env bash
# cli_bad_usage.sh LOCKSTONE: bad usage and bad input end with status 2 and one sentence that names what is wrong.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/cli.sh"
lockstone=$1
own_folder

# refused WORDS ARGUMENT...: status 2, nothing on stdout, one line on stderr that holds WORDS.
refused() {
    local words=$1
    shift
    expect 2 "$@"
    [ ! -s out ] || fail "'$*' printed to stdout: $(cat out)"
    [ "$(wc -l <err)" -eq 1 ] || fail "'$*' did not print one line: $(cat err)"
    grep -qF -- "$words" err || fail "'$*' does not say '$words': $(cat err)"
}

refused 'command'
refused "no command 'rnu'" rnu pile
refused "did you mean 'pyramid'?" run pyramyd
refused 'rollback-arena' run nothing-like-it
refused 'SCENE' run
refused 'must be 1 to 100' run pyramid --size 5000
refused 'must be 2 to 4' run rollback-arena --players 7
refused 'players is not an option' run pile --players 2
refused '--threads' run stack --threads 65
refused 'scalar, sse41, avx2, avx512, neon and wasm128' run stack --simd avx1024
refused '--ticks' run stack --ticks many
refused "'-1' is not a whole number" run stack --ticks -1
refused '--size' run stack --size 1e3
refused '--seed' run stack --seed 18446744073709551616
refused 'nowhere/x.tsv' run stack --ticks 1 --hashes nowhere/x.tsv
refused 'nowhere/x.lsr' run stack --ticks 1 --record nowhere/x.lsr
refused 'nowhere/x.json' run stack --ticks 1 --report nowhere/x.json
refused 'missing.lsr' verify missing.lsr
refused 'missing.lsr' replay missing.lsr
refused 'missing.lsr' info missing.lsr
refused 'missing.txt' run stack --ticks 1 --input missing.txt
refused 'directory' run stack --ticks 1 --input .
refused '/dev/full' run stack --ticks 1 --hashes /dev/full
refused '/dev/full' run stack --ticks 1 --record /dev/full
refused '--plant' synctest stack --plant body.nonsense
refused 'body.' synctest stack --plant body.nonsense
refused '--depth' synctest stack --depth 0
refused '--seeds' match --seeds 5..2
refused '--mode' match --mode telepathy
refused 'must be 2 to 4' match --peers 9

: >empty.lsr
refused 'empty.lsr' verify empty.lsr
echo 'not a recording' >text.lsr
refused 'text.lsr' verify text.lsr

input_line() { # a text file with one good and one bad line
    printf '0 0 7f0000\n%s\n' "$1" >inputs.txt
    refused "inputs.txt: line 2" run rollback-arena --ticks 1 --input inputs.txt
    grep -qF -- "$2" err || fail "the sentence does not say '$2': $(cat err)"
}
input_line '5 0' 'tick, player and bytes'
input_line '5 0 7f0000 more' 'tick, player and bytes'
input_line 'x 0 7f0000' "'x' is not a tick"
input_line '5 2 7f0000' "'2' is not a player"
input_line '5 0 7f00' 'not an input of 3 bytes'
input_line '5 0 7g0000' 'not an input of 3 bytes'
input_line '0 0 7f0000' 'does not come after'

"$lockstone" run stack --ticks 30 --record s.lsr >/dev/null
refused 'holds ticks 0 to 30' replay s.lsr --from 40
refused 'holds ticks 0 to 30' replay s.lsr --from 20 --to 10
refused 'holds ticks 0 to 30' branch s.lsr --at 31 -o b.lsr
refused 'is what is read from' branch s.lsr --at 3 -o ./s.lsr
refused 'is what is read from' run stack --input s.lsr --record s.lsr
refused '--shard' verify s.lsr --shard 3/3
refused '--shard' verify s.lsr --shard all
refused 's.lsr' run rollback-arena --ticks 1 --input s.lsr

for command in scenes run replay verify info diff branch repair synctest match bench; do
    expect 0 "$command" --help
    grep -q "$command" out || fail "$command --help does not name the command"
done
echo "ok"
