#!/usr/bin/env python3
"""Writes the cost card: what a body costs by step, save, restore, hash and rollback, in nanoseconds and bytes.

    build/release/bin/lockstone bench S1 S2 S4 S6 state --json > results.json
    tools/bench/cost_card.py results.json               prints the table
    tools/bench/cost_card.py results.json README.md     puts it between the two marks in the file

The marks are the lines <!-- cost card --> and <!-- end of the cost card -->.
"""
import json
import pathlib
import sys

BEGIN, END = "<!-- cost card -->", "<!-- end of the cost card -->"
SCENES = {"S1": "wall of 820 boxes", "S2": "heap of 1000 bodies", "S4": "50 ragdolls", "S6": "game of 72 bodies"}


def nanoseconds(microseconds, bodies):
    return f"{1e3 * microseconds / bodies:,.0f}"


def card(results):
    """The table, a column a scene."""
    steps = {scene["scene"]: scene["engines"][0]["mean_ms"] * 1e3 for scene in results["scenes"]}
    states = {row["scene"]: row for row in results["state"]}
    names = [name for name in SCENES if name in steps and name in states]
    if not names:
        sys.exit("cost_card.py: the results hold no scene with both its step and its state; run bench S1 S2 S4 S6 state")
    rollback = {name: next(r for r in states[name]["rollbacks"] if r["depth"] == 8) for name in names}
    bodies = {name: states[name]["bodies"] for name in names}
    rows = [("step", lambda n: nanoseconds(steps[n], bodies[n]))]
    rows += [(verb, lambda n, verb=verb: nanoseconds(states[n][f"{verb}_us"], bodies[n])) for verb in ("save", "restore", "hash")]
    rows += [
        ("memcpy of the same bytes", lambda n: nanoseconds(states[n]["memcpy_us"], bodies[n])),
        ("rollback of 8 ticks", lambda n: nanoseconds(rollback[n]["rollback_us"], bodies[n])),
        ("rollback / its 8 ticks alone", lambda n: f"{rollback[n]['ratio']:.3f}"),
        ("snapshot, bytes", lambda n: f"{states[n]['bytes_per_body']:,.0f}"),
    ]
    lines = ["| ns a body | " + " | ".join(SCENES[n] for n in names) + " |", "|---" * (len(names) + 1) + "|"]
    lines += [f"| {what} | " + " | ".join(value(n) for n in names) + " |" for what, value in rows]
    settings = results["settings"]
    return "\n".join(lines) + f"\n\n{settings['cpu']}, g++ {settings['compiler']}, one thread, default settings, nobody asleep.\n"


def replace(path, table):
    text = path.read_text()
    if BEGIN not in text or END not in text:
        sys.exit(f"cost_card.py: {path} lacks the lines {BEGIN} and {END}")
    head, rest = text.split(BEGIN, 1)
    path.write_text(head + BEGIN + "\n" + table + END + rest.split(END, 1)[1])


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    table = card(json.loads(pathlib.Path(sys.argv[1]).read_text()))
    if len(sys.argv) == 3:
        replace(pathlib.Path(sys.argv[2]), table)
    else:
        print(table, end="")


if __name__ == "__main__":
    main()
