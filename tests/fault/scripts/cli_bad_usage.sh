#!/usr/bin/env bash
# cli_bad_usage.sh LOCKSTONE: bad usage and bad input end with status 2 and one sentence that names the error.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/cli.sh"
lockstone=$1
own_folder

# refused WORDS ARGUMENT...: checks for status 2, an empty stdout, and one line on stderr that contains WORDS.
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
for seeds in 99999999999999999999 18446744073709551616 1..-1 -1 ' 1' +1 1.. ..2 1...2 ''; do refused '--seeds' match --seeds="$seeds"; done
refused 'nowhere/m-3-1.lsr: cannot write' match --seeds 3..4 --ticks 1000000 --record-prefix nowhere/m
refused '--ticks' match --ticks 18446744073709551615
refused 'pyramid: has no players; choose a scene with players: ' match pyramid
refused 'lockstone run --help' run stack --ticks many
refused 'lockstone match --help' match --nonsense
refused 'lockstone --help' --nonsense
refused '--relayed: there are no watchers' match --relayed
refused '--mode' match --mode telepathy
refused 'must be 2 to 4' match --peers 9

: >empty.lsr
refused 'empty.lsr' verify empty.lsr
echo 'not a recording' >text.lsr
refused 'text.lsr' verify text.lsr

input_line() { # LINE WORDS: an input file with one good line and the bad LINE must be refused with WORDS
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

# An error sentence shows bytes of a file as text without control characters, and shows only the beginning of a long word.
input_line $'\033[31mred 0 7f0000' "'\x1b[31mred' is not a tick"
input_line $'5 \302\233m 7f0000' "'\xc2\x9bm' is not a player"
input_line $'5 0 \377\303\274\300\257' "'\xff"$'\303\274'"\xc0\xaf' is not an input"
input_line "$(head -c 2000000 /dev/zero | tr '\0' x) 0 7f0000" "'$(head -c 40 /dev/zero | tr '\0' x)...' is not a tick"
printf '0 0 7f0000\n\000tick 0 7f0000\n' >inputs.txt
refused "line 2: '\x00tick' is not a tick" run rollback-arena --ticks 1 --input inputs.txt
refused "there is no command '\x1b[31m'" $'\033[31m'

"$lockstone" run stack --ticks 30 --record s.lsr >/dev/null
refused 'holds ticks 0 to 30' replay s.lsr --from 40
refused 'holds ticks 0 to 30' replay s.lsr --from 20 --to 10
refused 'holds ticks 0 to 30' branch s.lsr --at 31 -o b.lsr
refused 'is also an input file' branch s.lsr --at 3 -o ./s.lsr
refused 'is also an input file' run stack --input s.lsr --record s.lsr

# Existing files are safe: an output must not be an input, two outputs must not be one file, and no output changes before all can be written.
printf '0 0 7f0000\n' >good.txt
printf '0 0 7f00\n' >bad.txt
"$lockstone" run rollback-arena --ticks 30 --record r.lsr >/dev/null
cp r.lsr precious.lsr
ln precious.lsr link.lsr
sum=$(sha256sum <precious.lsr)
keeps() { # like refused; also checks that precious.lsr is unchanged
    refused "$@"
    [ "$(sha256sum <precious.lsr)" = "$sum" ] || fail "'lockstone ${*:2}' has changed precious.lsr"
}
keeps 'missing.txt' branch r.lsr --at 5 --input missing.txt -o precious.lsr
keeps 'bad.txt: line 1' branch r.lsr --at 5 --input bad.txt -o precious.lsr
keeps 'does not hold inputs of 2 players' branch r.lsr --at 5 --input s.lsr -o precious.lsr
keeps 'holds ticks 0 to 30' branch r.lsr --at 31 -o precious.lsr
keeps 'is also an input file' branch r.lsr --at 5 --input precious.lsr -o link.lsr
keeps 'is also an input file' replay precious.lsr --hashes precious.lsr
keeps 'is given for two outputs' run rollback-arena --ticks 3 --record precious.lsr --hashes precious.lsr
keeps 'is given for two outputs' run rollback-arena --ticks 3 --record precious.lsr --hashes link.lsr
keeps 'is given for two outputs' run rollback-arena --ticks 3 --hashes precious.lsr --report precious.lsr
keeps 'is given for two outputs' run rollback-arena --ticks 3 --record new.lsr --report ./new.lsr
keeps 'nowhere/x.lsr' run rollback-arena --ticks 3 --record nowhere/x.lsr --hashes precious.lsr
keeps 'nowhere/x.lsr' run rollback-arena --ticks 3 --record nowhere/x.lsr --report precious.lsr
keeps 'missing.txt' run rollback-arena --ticks 3 --input missing.txt --record precious.lsr
keeps 'nowhere/x.tsv' replay r.lsr --hashes nowhere/x.tsv
[ ! -e new.lsr ] || fail "what is refused has made a file"

# The command line prints names and contents of files without control characters.
is_plain() { # FILE...: succeeds if the files are UTF-8 without control characters
    python3 - "$@" <<'PYTHON'
import sys
text = "".join(open(name, "rb").read().decode() for name in sys.argv[1:])
sys.exit(any(ord(c) < 32 or 127 <= ord(c) < 160 for c in text if c != "\n"))
PYTHON
}
for raw in '\033[31m' '\302\233' '\177'; do
    # shellcheck disable=SC2059
    printf "$raw" >planted
    ! is_plain planted || fail "the check does not find $raw"
done
odd=$'odd\033[31m\302\23331m\377\nend.lsr'
cp s.lsr "$odd"
head -c $(($(stat -c %s s.lsr) - 200)) s.lsr >"cut$odd"
shows() { # STATUS ARGUMENT...: like expect; also checks that lockstone prints text without control characters
    expect "$@"
    [ -s out ] || [ -s err ] || fail "'lockstone ${*:2}' prints nothing"
    is_plain out err || fail "'lockstone ${*:2}' prints control characters"
}
shows 0 info "$odd"
shows 0 info --json "$odd"
shows 0 info "cut$odd"
shows 0 verify "$odd"
shows 0 verify --json "$odd"
shows 2 verify "cut$odd"
shows 0 replay "$odd"
shows 0 diff "$odd" s.lsr
shows 0 branch "$odd" --at 5 -o "branch$odd"
shows 0 repair "cut$odd" -o "whole$odd"
shows 2 replay "none$odd"
[ "$(wc -l <err)" -eq 1 ] || fail "an error takes $(wc -l <err) lines: $(cat err)"

refused '/dev/zero: holds more than 67108864 bytes' run rollback-arena --ticks 3 --input /dev/zero

refused '--shard' verify s.lsr --shard 3/3
refused '--shard' verify s.lsr --shard all
for shard in 0/-1 0/4294967297 -1/2 4294967296/4294967297 0/ /1 0/0 0/1/1 '0 /1'; do refused '--shard' verify s.lsr --shard="$shard"; done
expect 0 verify s.lsr --shard 0/1
refused 's.lsr' run rollback-arena --ticks 1 --input s.lsr

# If lockstone cannot write its output, it ends with an error. If the reader closes the pipe after the first line, lockstone prints no error.
lost() { # ARGUMENT...: the command must fail if stdout is full or closed
    local status=0
    "$lockstone" "$@" >/dev/full 2>err || status=$?
    [ $status -eq 2 ] && grep -q 'standard output: cannot write' err || fail "'$* >/dev/full' ends with $status: $(cat err)"
    status=0
    "$lockstone" "$@" >&- 2>err || status=$?
    [ $status -eq 2 ] && grep -q 'standard output: cannot write' err || fail "'$* >&-' ends with $status: $(cat err)"
}
lost verify s.lsr
lost scenes
lost scenes --json
lost info s.lsr
lost format
lost diff s.lsr s.lsr
lost run --help
lost run stack --ticks 30 --record closed.lsr
cmp closed.lsr s.lsr || fail "what is printed went into the recording"
"$lockstone" format 2>err | head -n 1 >out || true
[ -s out ] && [ ! -s err ] || fail "a reader that leaves is complained about: $(cat err)"

for command in scenes run replay verify info diff branch repair self-test synctest match bench; do
    expect 0 "$command" --help
    grep -q "$command" out || fail "$command --help does not name the command"
done
echo "ok"
