#!/usr/bin/env bash
# cook_end_to_end.sh LOCKSTONE: the sample models are cooked into every kind of asset; bad models and options end with an error sentence.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
source "$here/cli.sh"
samples=$here/../../../tools/cook/samples
lockstone=$1
own_folder

# value KEY: prints a value of the JSON report in the file out.
value() { python3 -c 'import json, sys; print(json.load(open("out"))[sys.argv[1]])' "$1"; }

# cooked KIND DEVIATION MODEL ARGUMENT...: cooks the model and checks that the asset is of KIND and deviates by at most DEVIATION [m].
cooked() {
    local kind=$1 deviation=$2 model=$3
    shift 3
    expect 0 cook "$samples/$model" -o asset.lsa --json "$@"
    [ "$(value kind)" = "$kind" ] || fail "$model: became a $(value kind), not a $kind"
    python3 -c 'import sys; sys.exit(float(sys.argv[1]) > float(sys.argv[2]))' "$(value deviation_m)" "$deviation" ||
        fail "$model as $kind deviates by $(value deviation_m) m"
    [ "$(stat -c %s asset.lsa)" -ge "$(value bytes)" ] || fail "$model: the file is shorter than its assets"
}

# refused STATUS WORDS ARGUMENT...: checks for the status, one line on stderr that contains WORDS, and no output file.
refused() {
    local status=$1 words=$2
    shift 2
    rm -f none.lsa
    expect "$status" cook "$@" -o none.lsa
    [ "$(wc -l <err)" -eq 1 ] || fail "'cook $*' did not print one line: $(cat err)"
    grep -qF -- "$words" err || fail "'cook $*' does not say '$words': $(cat err)"
    [ ! -e none.lsa ] || fail "'cook $*' left a file behind"
}

# ---- every kind of file, every kind of asset ----
cooked hull 1e-6 gem.stl
cooked hull 1e-7 bracket.obj
cooked hull 1e-7 bracket.fbx
cooked hull 1e-7 chair.gltf
cooked hull 1e-7 hill.ply --vertices 255
cooked compound 1e-7 bracket.obj --as convex
cp asset.lsa obj.lsa
cooked compound 1e-7 bracket.fbx --as convex
cmp asset.lsa obj.lsa || fail "the same bracket from OBJ and FBX gave other bytes"
# This copy of bracket.fbx has its lengths in centimetres.
sed 's/UnitScaleFactor", "double", "Number", "", 100/UnitScaleFactor", "double", "Number", "", 1/' "$samples/bracket.fbx" >centimetres.fbx
expect 0 cook centimetres.fbx -o asset.lsa --as mesh --json
python3 -c 'import sys; sys.exit(abs(float(sys.argv[1]) - 8e-5) > 1e-9)' "$(value deviation_aimed_m)" || fail "a bracket of 0.8 cm is allowed $(value deviation_aimed_m) m"
cooked compound 0.005 chair.gltf --as convex --deviation 0.005
cooked hull 1e-6 gem.stl --as convex
cooked mesh 1e-7 hill.ply --as mesh
cooked mesh 1e-7 chair.gltf --as mesh --two-sided --flat 5
cooked height_field 1e-7 hill.ply --as height-field --spacing 1
cooked height_field 0.02 hill.ply --as height-field --deviation 0.02
cooked hull 1e-7 bracket.obj --scale 0.1
cooked hull 1e-7 bracket.obj --z-up
cp asset.lsa once.lsa
cooked hull 1e-7 bracket.obj --z-up
cmp asset.lsa once.lsa || fail "cooking twice gave other bytes"
expect 0 cook "$samples/gem.stl" -o asset.lsa
grep -q 'deviation' out || fail "the report names no deviation: $(cat out)"
expect 0 cook "$samples/bracket.obj" -o asset.lsa
grep -q 'concave' out || fail "nobody is told that an L is concave: $(cat out)"

printf 'v 0 0 0\nv 1 0 0\nv 0 0 1\nv 0 1 0\nf 1 2 3\nf 1 4 2\nf 2 4 3\nf 3 4 1\n' >tetrahedron.obj
expect 0 cook tetrahedron.obj -o asset.lsa --deviation 0
! grep -q 'concave' out || fail "a tetrahedron is called concave: $(cat out)"

# ---- an asset that deviates too far from the model: status 1 and no file ----
refused 1 'deviates by' "$samples/gem.stl" --vertices 6 --deviation 0.01
refused 1 'deviates by' "$samples/chair.gltf" --as convex --parts 2
refused 1 'deviates by' "$samples/hill.ply" --as height-field --spacing 5

# ---- bad input: status 2, and a sentence with the file and the reason ----
refused 2 'missing.obj: there is no such file' missing.obj
refused 2 "$PWD: is a directory" "$PWD"
refused 2 '/dev/null: is no regular file' /dev/null
refused 2 'no-such' "$samples/gem.stl" --as no-such
refused 2 "'nan' is not a number" "$samples/gem.stl" --scale nan
refused 2 "'0' is not a number" "$samples/gem.stl" --scale 0
refused 2 "'300' is not a whole number from 4 to 255" "$samples/gem.stl" --vertices 300
refused 2 'gem.stl' "$samples/gem.stl" --scale 1e-5
refused 2 'gem.stl: ' "$samples/gem.stl" --scale 1e5
# This model, a grid of 28,000 triangles, needs more memory than the 64 MB that the command below allows.
python3 - >grid.obj <<'PYTHON'
side = 120
for x in range(side):
    for z in range(side):
        print("v", x, (x * z) % 7, z)
for x in range(side - 1):
    for z in range(side - 1):
        a = x * side + z + 1
        print("f", a, a + 1, a + side)
        print("f", a + 1, a + side + 1, a + side)
PYTHON
refused 2 '(--memory allows more)' grid.obj --as mesh --memory 64
# Counter-check of the limit: with the default limit, which is higher, the command cooks the model.
expect 0 cook grid.obj --as mesh -o grid.lsa
refused 2 "'63' is not a whole number from 64" grid.obj --memory 63
cp "$samples/gem.stl" gem.stl
expect 2 cook gem.stl -o ./gem.stl
grep -q 'is also an input file' err || fail "the model may be overwritten: $(cat err)"
expect 2 cook gem.stl -o nowhere/gem.lsa
grep -q 'nowhere/gem.lsa' err || fail "the sentence does not name the output: $(cat err)"
: >empty.obj
refused 2 'empty.obj' empty.obj
echo 'not a model' >text.gltf
refused 2 'text.gltf' text.gltf
printf 'v 0 0 0\nv 1 0 0\nv 0 0 1\nl 1 2\nl 2 3\n' >lines.obj
refused 2 'lines.obj: it has no triangles; it is empty, or holds only points or lines' lines.obj
printf 'v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n' >flat.obj
refused 2 'flat.obj: as hull: ' flat.obj
printf 'v 0 0 0\nv 1 0 0\nv nan 0 1\nv 0 1 0\nf 1 2 3\nf 1 2 4\n' >nan.obj
expect 2 cook nan.obj -o none.lsa
head -c 900 "$samples/chair.gltf" >cut.gltf
refused 2 'cut.gltf' cut.gltf
head -c 5000 "$samples/hill.ply" >cut.ply
"$lockstone" cook cut.ply -o none.lsa >out 2>err || [ $? -eq 2 ] || fail "a cut file ended with another status: $(cat err)"
head -c 300 /dev/urandom >noise.fbx
refused 2 'noise.fbx' noise.fbx
echo "ok"
