#!/usr/bin/env bash
# cli_compare.sh LOCKSTONE: `compare` runs both engines in its scenes and draws its pictures; a request that it cannot do ends with an error sentence.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/cli.sh"
lockstone=$1
own_folder

refused() { # SENTENCE ARGUMENT...: checks for status 2 and one line on stderr that contains SENTENCE
    local sentence=$1
    shift
    expect 2 "$@"
    [ "$(wc -l <err)" -eq 1 ] || fail "'$*' did not print one line: $(cat err)"
    grep -qF -- "$sentence" err || fail "'$*' does not say '$sentence' but: $(cat err)"
}

cat >shape.py <<'PYTHON'
import json, math, sys
scene, found = sys.argv[1], json.load(open(sys.argv[2]))
finite = lambda x: isinstance(x, (int, float)) and math.isfinite(x)
assert found["scene"] == scene and found["bodies"] > 0, "which scene"
assert [t["tick"] for t in found["ticks"]] == list(range(1, 25)), "ticks"
for tick in found["ticks"]:
    assert finite(tick["separation_max_m"]) and tick["ours_us"] > 0 and tick["thesis_us"] > 0, tick
    for whose in ("ours", "thesis"):
        assert all(finite(tick[whose][key]) for key in ("kinetic_j", "potential_j", "penetration_m")), tick
        assert all(map(finite, tick[whose]["momentum_ns"])), tick
names = [line["name"] for line in found["drift"]]
assert names[-1] == "Lockstone" and "float, -ffast-math" in names and "float, again" in names, names
for line in found["drift"]:
    assert len(line["apart_m"]) == 24
    assert line["parts_at"] is None or line["name"] not in ("Lockstone", "float, again"), f"{line['name']} parts"
PYTHON
for scene in two-blocks stack pile domino orbit top pyramid; do
    expect 0 compare "$scene" --ticks 24 --json
    python3 shape.py "$scene" out || fail "compare $scene --json has another shape"
done
python3 - <<'PYTHON'
import json
found = json.load(open("out"))
found["drift"][-1]["parts_at"] = 3
json.dump(found, open("broken.json", "w"))
PYTHON
! python3 shape.py pyramid broken.json 2>/dev/null || fail "that ours parted was not noticed"

expect 0 compare two-blocks --ticks 60
grep -q '^first contact: ours tick' out && grep -q '^built twice: Lockstone .* first difference: never' out || fail "compare prints no summary"
if command -v gnuplot >/dev/null; then
    expect 0 compare two-blocks --ticks 60 --plot six.svg
    expect 0 compare two-blocks --ticks 60 --drift --plot drift.svg
    grep -q '<svg' six.svg && grep -q 'momentum' six.svg && grep -q '<svg' drift.svg || fail "--plot draws nothing"
else
    echo "gnuplot is not here: no picture was drawn" >&2
fi
for integrator in verlet velocity-verlet runge-kutta-4; do expect 0 compare orbit --ticks 5 --integrator $integrator; done

refused "there is no scene 'orbitt' to compare in: two-blocks, stack" compare orbitt
refused 'FCL has no rounded' compare convex-pile
refused "the thesis' engine has no joints" compare bridge
refused "--iterations: '0' is not a whole number from 1 to 1000000" compare stack --iterations 0
refused "--substeps: '65' is not a whole number from 0 to 64" compare stack --substeps 65
refused "--substeps: '5000' is not" compare stack --substeps 5000
# If the picture cannot be written, the command computes and prints no results.
refused 'nowhere/p.svg: cannot write: No such file' compare two-blocks --ticks 3 --json --plot nowhere/p.svg
[ ! -s out ] || fail "a picture that cannot be written is printed: $(head -c 300 out)"
mkdir empty && for tool in bash cat env sh; do ln -s "$(command -v $tool)" empty/; done
status=0
PATH=$PWD/empty "$lockstone" compare two-blocks --ticks 3 --json --plot p.svg >out 2>err || status=$?
[ $status -eq 2 ] && [ "$(wc -l <err)" -eq 1 ] && grep -q 'gnuplot is missing; install it' err || fail "a missing gnuplot is told otherwise: $(cat err)"
python3 -c 'import json; json.load(open("out"))' || fail "what was found is not printed without gnuplot"
printf '#!/bin/sh\necho noise\nexit 3\n' >empty/gnuplot && chmod +x empty/gnuplot
PATH=$PWD/empty "$lockstone" compare two-blocks --ticks 3 --json --plot p.svg >out 2>err || status=$?
[ $status -eq 2 ] && grep -q 'gnuplot failed with status 3' err && ! grep -q noise out || fail "a gnuplot that fails is told otherwise: $(cat err out)"
refused '--integrator' compare stack --integrator euler
refused 'orbit: comes in one size' compare orbit --size 3
echo "ok"
