#!/usr/bin/env bash
# cli_bench.sh LOCKSTONE: the benchmark runs, prints all of its figures, and refuses bad options. No check here depends on the speed of the machine.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/cli.sh"
lockstone=$1
own_folder

refused() { # SENTENCE ARGUMENT...: checks for status 2 and an error that contains SENTENCE
    local sentence=$1
    shift
    expect 2 "$@"
    grep -qF -- "$sentence" err || fail "'lockstone $*' does not say '$sentence' but: $(cat err)"
}

expect 0 bench --quick --json
cp out all.json
cat >shape.py <<'PYTHON'
import json, math, sys
all = json.load(open(sys.argv[1]))
finite = lambda x: isinstance(x, (int, float)) and math.isfinite(x)
rows = ["trees", "logs", "bullets", "kinematic-drum", "kinematic-drum-unswept", "ragdoll-rain", "ragdolls-50", "spring-chains", "tower", "large-pyramid",
        "characters", "vehicles", "explosions", "churn", "static-first", "static-creation", "creation", "rays-bodies", "rays-mesh", "ball-cast-mesh",
        "box-cast-mesh", "ball-overlap-mesh", "box-overlap-mesh", "casts-bodies", "overlaps-bodies"]
assert [s["scene"] for s in all["scenes"]] == ["S1", "S2", "S3", "S4", "S5", "S6", "pyramids", "grid", "drum", "S4-plane"] + rows, "scenes"
for scene in all["scenes"]:
    engines = [run["engine"] for run in scene["engines"]]
    assert engines[0] == "Lockstone", f"{scene['scene']}: who runs: {engines}"
    peers = [name for key, name in (("bullet", "Bullet"), ("ode", "ODE")) if all["settings"][key] and (key == "bullet" or scene["scene"] not in rows)]
    assert engines[1:] == peers, f"{scene['scene']}: who runs: {engines}"
    for run in scene["engines"]:
        for key in ("mean_ms", "median_ms", "p99_ms", "heap_mb", "overlap_mm", "overlap_static_mm", "sway_mm", "fallen", "joint_mm", "joint_worst_mm", "lost", "figure"):
            assert finite(run[key]), f"{scene['scene']}, {run['engine']}: {key} is {run[key]}"
        assert run["mean_ms"] > 0 and run["lost"] == 0, f"{scene['scene']}, {run['engine']}: {run}"
    if all["settings"]["bullet"]:
        assert finite(scene["bullet_per_ours"]["mean"]), f"{scene['scene']}: no ratio"
for row in all["state"]:
    for key in ("save_us", "restore_us", "hash_us", "memcpy_us", "bytes_per_body"):
        assert finite(row[key]) and row[key] > 0, f"state of {row['scene']}: {key} is {row[key]}"
    for rollback in row["rollbacks"]:
        assert rollback["is_exact"], f"{row['scene']}: a rollback gave other bits"
assert [row["scene"] for row in all["state"]] == ["S1", "S2", "S4", "S6"], "state"
awake = [row["awake"] for row in all["awake"]]
assert awake == sorted(awake, reverse=True) and awake[-1] == 0 and awake[0] > 0, f"awake: {awake}"
assert all["scaling"][0]["bodies"] == 100 and finite(all["scaling"][0]["Lockstone"]["us_per_body"]), "scaling"
assert finite(all["verify"]["times_real_time"]) and all["verify"]["players"] == 4, "verify"
assert finite(all["arena"]["mean_us"]), "arena"
PYTHON
python3 shape.py all.json || fail "bench --quick --json has another shape"
python3 - <<'PYTHON'
import json
all = json.load(open("all.json"))
all["scenes"][0]["engines"][0]["overlap_mm"] = None
json.dump(all, open("broken.json", "w"))
PYTHON
python3 shape.py broken.json 2>/dev/null && fail "a figure that is none was not noticed"

expect 0 bench --quick S6 --substeps 2,4
grep -q 'Lockstone 2 ' out && grep -q 'Lockstone 4 ' out || fail "--substeps 2,4 does not run both"
if command -v gnuplot >/dev/null; then
    expect 0 bench --quick S1 S6 --plot ratios.svg
    expect 0 bench --quick front --plot front.svg
    grep -q '<svg' ratios.svg && grep -q '<svg' front.svg || fail "--plot draws nothing"
    refused 'nothing to draw' bench --quick verify --plot none.svg
fi
expect 0 bench --quick S6 S4 --profile trace.json --json
python3 - <<'PYTHON' || fail "--profile does not tell the phases"
import json
scenes, events = json.load(open("out")), json.load(open("trace.json"))["traceEvents"]
assert [s["scene"] for s in scenes] == ["S6", "S4"]
for scene in scenes:
    assert {"update_bounds", "find_pairs", "collide", "prepare", "solve_contacts", "finish"} <= set(scene["phases"])
assert all(e["dur"] >= 0 for e in events if e["ph"] == "X") and len(events) > 100
PYTHON
expect 0 bench --quick stack
grep -q '^stack ' out || fail "a built-in scene is not measured"
refused 'nowhere/x.json: cannot write: No such file' bench --quick S6 --profile nowhere/x.json
refused 'nowhere/x.svg: cannot write: No such file' bench --quick S6 --plot nowhere/x.svg
[ ! -s out ] || fail "a picture that cannot be written is noticed after the work: $(cat out)"
expect 0 bench --help
grep -q 'S4-plane' out && grep -q 'overlaps-bodies' out && grep -q 'wasm128' out || fail "bench --help leaves something out"
tr -s ' \n' ' ' <out >help
for name in $(python3 -c 'import json; print(*(s["scene"] for s in json.load(open("all.json"))["scenes"] if s["scene"] > "T"))'); do
    grep -q -- "$name" help || fail "bench --help leaves $name out"
done
refused "there is no part 'S7'" bench S7
refused '--substeps' bench --substeps 17
echo "ok"
