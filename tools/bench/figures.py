#!/usr/bin/env python3
"""Writes the results of the benchmark into the READMEs: the figures into tools/bench/README.md, the cost card into README.md.

    tools/bench/figures.py RESULTS.json...        reads the output of `lockstone bench --json` and `--instructions --json`; lists of several
                                                  files are joined, other values of later files replace those of earlier ones
    tools/bench/figures.py --run [LOCKSTONE]      runs all benchmarks first, and draws tools/bench/front.svg; takes half an hour on an idle machine

Each part replaces the text between two lines, <!-- NAME --> and <!-- end of NAME -->.
"""
import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
CARD = {"S1": "wall of 820 boxes", "S2": "heap of 1,000 bodies", "S4": "50 ragdolls", "S6": "game of 72 bodies"}


def row(*cells):
    return "| " + " | ".join(str(c) for c in cells) + " |"


def head(*cells):
    return [row(*cells), "|---" * len(cells) + "|"]


def number(x):
    """Returns x with three digits, or as an integer from 100 on: measurements are not more precise."""
    if x == 0:
        return "0"
    return f"{x:,.0f}" if abs(x) >= 100 else f"{x:.3g}"


def engine(scene, name):
    return next((run for run in scene["engines"] if run["engine"] == name), None)


def shown(scene):
    """Returns the run of Lockstone and the runs of its peers, without runs of Lockstone with other instruction sets."""
    return [run for i, run in enumerate(scene["engines"]) if i == 0 or not run["engine"].startswith("Lockstone")]


def by_other_sets(scene):
    bullet = engine(scene, "Bullet")
    others = [run for run in scene["engines"][1:] if run["engine"].startswith("Lockstone")]
    return "; ".join(f"{run['engine'].split()[-1]} {bullet['mean_ms'] / run['mean_ms']:.2f}" for run in others) if bullet else ""


def millions(results, name):
    return next((r for r in results.get("instructions", []) if r["scene"] == name), None)


# ---- tables of tools/bench/README.md ---------------------------------------------------------------------------------


def times(results):
    lines = head("", "ours ms, mean / p99", "Bullet", "ODE", "Bullet / ours", "must, goal", "by other sets", "M instructions a tick", "must, goal")
    for scene in results.get("scenes", []):
        ours, peers = scene["engines"][0], [engine(scene, name) for name in ("Bullet", "ODE")]
        asked = next((v for v in scene["verdicts"] if "goal" in v), None)
        counted = millions(results, scene["scene"])
        lines.append(row(
            f"{scene['scene']}: {scene['about']}", f"{number(ours['mean_ms'])} / {number(ours['p99_ms'])}",
            *[f"{number(p['mean_ms'])} / {number(p['p99_ms'])}" if p else "" for p in peers],
            f"{scene['bullet_per_ours']['mean']:.2f}" if scene["bullet_per_ours"] else "",
            f"{asked['must']:.3g}, {asked['goal']:.3g}" if asked else "", by_other_sets(scene),
            number(counted["millions_per_tick"]) if counted else "",
            f"{counted['must']:.4g}, {counted['goal']:.4g}" if counted and counted["must"] else ""))
    return lines


def worth(results):
    lines = head("ours; Bullet; ODE", "overlap mm", "of static", "sway mm", "fallen", "widest joint, at worst", "lost", "heap MB")
    for scene in results.get("scenes", []):
        def each(key, stands=True):
            return "; ".join(number(run[key]) for run in shown(scene)) if stands else ""
        lines.append(row(scene["scene"], each("overlap_mm"), each("overlap_static_mm"), each("sway_mm", scene["stands"]),
                         each("fallen", scene["stands"]), each("joint_worst_mm", scene["joints"] > 0), each("lost"), each("heap_mb")))
    return lines


def states(results):
    lines = head("us", "bytes a body", "save", "restore", "hash", "memcpy", "rollback of 8, / its ticks", "of 60, / its ticks")
    for state in results.get("state", []):
        rollbacks = [f"{number(r['rollback_us'])}, {r['ratio']:.3f}" for r in state["rollbacks"]]
        lines.append(row(state["scene"], number(state["bytes_per_body"]),
                         *[number(state[f"{verb}_us"]) for verb in ("save", "restore", "hash", "memcpy")], *rollbacks))
    return lines


def scaling(results):
    names = [name for name, cost in results["scaling"][0].items() if isinstance(cost, dict)] if results.get("scaling") else []
    lines = head("boxes at rest", *[f"{name}: us a body, heap bytes a body" for name in names])
    for entry in results.get("scaling", []):
        lines.append(row(f"{entry['bodies']:,}", *[f"{number(entry[n]['us_per_body'])}, {number(entry[n]['heap_bytes_per_body'])}" for n in names]))
    return lines


def awake(results):
    lines = head("awake of 2,000 boxes", "tick us", "save", "restore", "hash")
    for entry in results.get("awake", []):
        lines.append(row(f"{entry['awake']:,}", *[number(entry[f"{verb}_us"]) for verb in ("tick", "save", "restore", "hash")]))
    return lines


def threads(results):
    lines = head("by the wall", "one thread, ms", "two threads", "times faster", "must")
    for entry in results.get("threads", []):
        lines.append(row(entry["scene"], number(entry["one_ms"]), number(entry["two_ms"]), f"{entry['times_faster']:.2f}", entry["must"]))
    return lines


def games(results):
    lines = []
    if verify := results.get("verify"):
        lines.append(f"* Verifying a recording of rollback-arena with four players: {number(verify['times_real_time'])} times real time "
                     f"(must {verify['must']}, goal {verify['goal']}).")
    if arena := results.get("arena"):
        lines.append(f"* Four cars and a ball in an arena at 120 ticks a second: {number(arena['mean_us'])} us a tick, p99 "
                     f"{number(arena['p99_us'])} (must {arena['must']}).")
    return lines


def verdicts(results):
    """Yields (where, verdict) of each figure that has a limit."""
    for part in ("scenes", "state", "scaling"):
        for entry in results.get(part, []):
            for verdict in entry.get("verdicts", []):
                yield entry.get("scene", f"{entry['bodies']:,} boxes" if part == "scaling" else part), verdict
    for entry in results.get("threads", []):
        yield entry["scene"], {"what": "two threads, times faster", "found": entry["times_faster"], "must": entry["must"],
                               "good": entry["times_faster"] >= entry["must"]}
    for counted in results.get("instructions", []):
        if counted["must"]:
            yield counted["scene"], {"what": "M instructions a tick", "found": counted["millions_per_tick"], "must": counted["must"], "good": counted["good"]}
    for key, what, found in (("verify", "times real time", "times_real_time"), ("arena", "us a tick", "mean_us")):
        if entry := results.get(key):
            good = entry[found] >= entry["must"] if key == "verify" else entry[found] <= entry["must"]
            yield key, {"what": what, "found": entry[found], "must": entry["must"], "good": good}


def missed(results):
    every = list(verdicts(results))
    bad = [(where, v) for where, v in every if not v["good"]]
    lines = [f"{len(every) - len(bad)} of {len(every)} figures that are asked for are there. Missed:", ""] if bad else [f"All {len(every)} figures that are asked for are there."]
    return lines + (head("where", "what", "found", "must") if bad else []) + [row(where, v["what"], f"{v['found']:,.4g}", f"{v['must']:,.4g}") for where, v in bad]


def counts(results):
    """Returns a table of the scenes whose instructions were counted, and that have no times."""
    timed = {scene["scene"] for scene in results.get("scenes", [])}
    lines = head("M instructions a tick", "counted", "must", "goal")
    for counted in results.get("instructions", []):
        if counted["scene"] not in timed:
            lines.append(row(counted["scene"], f"{counted['millions_per_tick']:.4g}", f"{counted['must']:.4g}", f"{counted['goal']:.4g}" if counted["goal"] else ""))
    return lines


def bench_page(results):
    settings = results.get("settings")
    page = []
    if settings:
        page = [f"{settings['cpu']}, g++ {settings['compiler']}, load {settings['load']:.0f} when it began, of each tick the least of {settings['runs']} run(s).", ""]
    for table in (times, counts, worth, states, scaling, awake, threads):
        lines = table(results)
        if len(lines) > 2:
            page += lines + [""]
    return page + games(results) + [""] + missed(results)


# ---- the cost card of README.md --------------------------------------------------------------------------------------


def cost_card(results):
    steps = {scene["scene"]: scene["engines"][0]["mean_ms"] * 1e3 for scene in results.get("scenes", [])}
    found = {state["scene"]: state for state in results.get("state", [])}
    names = [name for name in CARD if name in steps and name in found]
    if not names:
        return []

    def per_body(microseconds, name):
        return f"{1e3 * microseconds / found[name]['bodies']:,.0f}"

    def eight(name):
        return next(r for r in found[name]["rollbacks"] if r["depth"] == 8)
    lines = head("ns a body", *[CARD[n] for n in names])
    lines.append(row("step", *[per_body(steps[n], n) for n in names]))
    for verb in ("save", "restore", "hash", "memcpy"):
        what = "memcpy of the same bytes" if verb == "memcpy" else verb
        lines.append(row(what, *[per_body(found[n][f"{verb}_us"], n) for n in names]))
    lines.append(row("rollback of 8 ticks", *[per_body(eight(n)["rollback_us"], n) for n in names]))
    lines.append(row("that / its 8 ticks alone", *[f"{eight(n)['ratio']:.3f}" for n in names]))
    lines.append(row("snapshot, bytes a body", *[number(found[n]["bytes_per_body"]) for n in names]))
    settings, simd = results["settings"], results["scenes"][0]["engines"][0]["engine"].removeprefix("Lockstone").strip()
    return lines + ["", f"{settings['cpu']}, g++ {settings['compiler']}, one thread, {simd + ', ' if simd else ''}default settings, every body awake."]


# ---- the files -------------------------------------------------------------------------------------------------------


def replace(path, name, lines):
    begin, end = f"<!-- {name} -->", f"<!-- end of {name} -->"
    text = path.read_text()
    if begin not in text or end not in text:
        sys.exit(f"figures.py: {path} lacks the lines {begin} and {end}")
    before, rest = text.split(begin, 1)
    path.write_text(before + begin + "\n" + "\n".join(lines) + "\n" + end + rest.split(end, 1)[1])


def read(path):
    found = json.loads(pathlib.Path(path).read_text())
    return {"instructions": found} if isinstance(found, list) else found


def run_all(program):
    folder = ROOT / "build/bench"
    folder.mkdir(parents=True, exist_ok=True)
    commands = {"all": [], "threads": ["threads"], "instructions": ["S1", "S2", "S3", "S4", "S5", "S6", "grid", "--instructions"],
                "front": ["front", "--plot", ROOT / "tools/bench/front.svg"]}
    for name, arguments in commands.items():
        with open(folder / f"{name}.json", "w") as out:
            subprocess.run([program, "bench", "--json", *map(str, arguments)], stdout=out, check=True)
    return [folder / "instructions.json", folder / "threads.json", folder / "all.json"]


def main():
    arguments = sys.argv[1:]
    if not arguments:
        sys.exit(__doc__)
    if arguments[0] == "--run":
        arguments = run_all(arguments[1] if len(arguments) > 1 else ROOT / "build/release/bin/lockstone")
    results: dict = {}
    for path in arguments:
        for key, value in read(path).items():
            both_lists = isinstance(value, list) and isinstance(results.get(key), list)
            results[key] = results[key] + value if both_lists else value
    for part in ("scenes", "instructions"):
        results.get(part, []).sort(key=lambda entry: (len(entry["scene"]), entry["scene"]))
    replace(ROOT / "tools/bench/README.md", "figures", bench_page(results))
    if card := cost_card(results):
        replace(ROOT / "README.md", "cost card", card)
    else:
        print("figures.py: the cost card stays: it needs the results of bench S1 S2 S4 S6 state", file=sys.stderr)


if __name__ == "__main__":
    main()
