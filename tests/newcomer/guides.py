#!/usr/bin/env python3
"""Tests the guides of tools/guides. Their blocks of C++ are files: the script compiles them with each compiler, with -Wall -Wextra -Werror, with and
without NDEBUG. Then two processes play the guide's match over UDP, through a relay, where they meet by a code. The first build plays one process
and the last build the other; a packet needs 40 to 60 ms to the relay, and as long back.

  guides.py GUIDE --libraries BUILD --lockstone CLI [--cxx CXX]...
  guides.py --planted GUIDE --libraries BUILD --lockstone CLI       checks that the script notices guides with one fault each"""
import argparse
import pathlib
import re
import subprocess
import sys
import tempfile
import threading

import readme

sys.path.insert(0, str(readme.ROOT / "tests/net"))
from slow_way import SlowWay  # noqa: E402

FOLDER = readme.ROOT / "tools/guides"
FILE = re.compile(r"^```cpp (\S+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
SOURCES = [f"-I{readme.ROOT}", f"-I{readme.ROOT}/src"]
LINES_BELOW = 100  # a match must need fewer lines, without empty lines
SECONDS = 90  # limit for a match of 10 seconds, on a machine with other load


def files_of(text):
    return {m.group(1): m.group(2) for m in FILE.finditer(text)}


def needed_by(program, files):
    """Returns the program and the headers of the guides that it includes, directly or through other headers."""
    found, waiting = [], [program]
    while waiting:
        name = waiting.pop()
        if name in files and name not in found:
            found.append(name)
            waiting += re.findall(r'^#include "(.+)"$', files[name], re.MULTILINE)
    return found


def lines_of(program, files):
    return sum(bool(line.strip()) for name in needed_by(program, files) for line in files[name].splitlines())


class Match:
    """A match of two processes: their output, exit status and recordings."""

    def __init__(self, programs, folder, lockstone, extra=((), ())):
        relay = subprocess.Popen([lockstone, "relay", "--key", folder / "relay.key", "--new-key", "--port", "0", "--address", "127.0.0.1",
                                  "--seconds", str(2 * SECONDS)], stdout=subprocess.PIPE, text=True)
        try:
            port, key = re.fullmatch(r"port (\d+), key (\w+)\n", relay.stdout.readline()).groups()
            with SlowWay(delay_ms=40, jitter_ms=20, server=int(port)) as way:
                self.play(programs, folder, [f"127.0.0.1:{way.port}", key], extra)
        finally:
            relay.kill()
            relay.wait()
            (folder / "relay.key").unlink(missing_ok=True)

    def play(self, programs, folder, meeting, extra):
        self.recordings = [folder / "a.lsr", folder / "b.lsr"]
        begin = lambda i, code: subprocess.Popen([programs[i], self.recordings[i], *meeting, code, *extra[i]], cwd=folder,
                                                 stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        first = begin(0, "")
        ended = threading.Timer(SECONDS, first.kill)
        ended.start()
        said = first.stdout.readline()
        both = [first]
        if said.startswith("code "):
            both.append(begin(1, said.split()[1]))
        self.printed, self.status = [], []
        for process in both:
            try:
                out, _ = process.communicate(timeout=SECONDS)
            except subprocess.TimeoutExpired:
                process.kill()
                out, _ = process.communicate()
                out += "\n(was not done in time)"
            self.printed.append(out)
            self.status.append(process.returncode)
        ended.cancel()
        if len(both) == 1:
            self.printed.append("")
            self.status.append(None)
            self.printed[0] = said + self.printed[0]

    def lines(self, pattern):
        """Returns the first match of the pattern in the output of each process, or None."""
        return [m.group(0) if (m := re.search(pattern, text, re.MULTILINE)) else None for text in self.printed]


def faults_of_match(match, rollbacks):
    """Returns the faults of a match that has to be right. `rollbacks`: true if it must have rollbacks, false if it must have none."""
    told = " | ".join(text.strip() for text in match.printed)
    if match.status != [0, 0]:
        return [f"the processes end with {match.status}: {told}"]
    complaints, hashes = [], match.lines(r"^tick 600, hash \w{16}$")
    if hashes[0] is None or hashes[0] != hashes[1]:
        complaints.append(f"the last hashes differ: {told}")
    for counted in match.lines(r"^\d+ rollbacks$"):
        if counted is None or (int(counted.split()[0]) > 0) != rollbacks:
            complaints.append(f"{counted} in a match that has {'some' if rollbacks else 'none'}: {told}")
    if match.recordings[0].read_bytes() != match.recordings[1].read_bytes():
        complaints.append("the recordings differ")
    if None in match.lines(r"600 ticks"):
        complaints.append(f"nobody says that 600 ticks were verified: {told}")
    return complaints


def check_rollback(programs, folder, lockstone):
    return faults_of_match(Match(programs["match.cpp"], folder, lockstone), rollbacks=True)


def check_lockstep(programs, folder, lockstone):
    return faults_of_match(Match(programs["lockstep.cpp"], folder, lockstone), rollbacks=False)


def printed_lines(text):
    """Returns the lines of the guide's blocks of text, which the programs must print exactly."""
    return [line for block in readme.blocks(text, "text") for line in block[1].splitlines() if line.strip()]


def check_desync(programs, folder, lockstone, lucky=("yes", "no")):
    match = Match(programs["desync.cpp"], folder, lockstone, [(each,) for each in lucky])
    told = " | ".join(text.strip()[:300] for text in match.printed)
    if match.status != [1, 1]:
        return [f"the processes end with {match.status} instead of two reports of a desync: {told}"]
    place = r"phase \w+, column [\w.]+, row \d+, [\w.]+: .+ against .+"
    complaints = [] if None not in match.lines(r"^tick 200, machine [12]: " + place) else [f"where they part is not told: {told}"]
    commands = [folder / "a-commands.lsr", folder / "b-commands.lsr"]
    for recorded, to, each, program in zip(match.recordings, commands, lucky, programs["export.cpp"]):
        subprocess.run([program, recorded, to, each], check=True)
    verified = subprocess.run([lockstone, "verify", *commands], capture_output=True, text=True)
    if verified.returncode != 0:
        complaints.append(f"lockstone verify ends with {verified.returncode}: {verified.stdout}{verified.stderr}")
    differs = subprocess.run([lockstone, "diff", *commands], capture_output=True, text=True)
    if differs.returncode != 1:
        complaints.append(f"lockstone diff ends with {differs.returncode}: {differs.stdout}{differs.stderr}")
    everything = match.printed[0] + differs.stdout
    for line in printed_lines((FOLDER / "desync.md").read_text()):
        if line.strip() not in everything:
            complaints.append(f"desync.md shows what nobody prints: {line!r}; they print {everything}")
    return complaints


# For each guide: the program of its match, the function that checks the match, and faults: (fault, text, text in its place).
GUIDES = {
    "rollback": ("match.cpp", check_rollback, [("one machine pushes harder", "20_r", "21_r")]),
    "desync": ("desync.cpp", check_desync, []),
    "lockstep": ("lockstep.cpp", check_lockstep, [("one machine pushes harder", "20_r", "21_r")]),
}


def written(files, names, folder):
    folder.mkdir(exist_ok=True)
    for name in names:
        (folder / name).write_text(files[name])
    return folder


def compiled(files, guide, compilers, build, folder, complaints):
    """Compiles the programs of the guide. Returns {program: [its first build, its last build]}, which play together later."""
    programs = {}
    for program in [n for n in files_of((FOLDER / f"{guide}.md").read_text()) if n.endswith(".cpp")]:
        source = written(files, needed_by(program, files), folder / "source") / program
        for cxx in compilers:
            for flags in readme.FLAGS:
                out = folder / f"{program}-{cxx}{''.join(flags)}"
                if fault := readme.compile_fault(source, out, cxx, [*flags, *SOURCES], build):
                    complaints.append(f"{guide}.md: {program}: by {cxx} {' '.join(flags)}: {fault}")
                programs.setdefault(program, []).append(out)
        programs[program] = [programs[program][0], programs[program][-1]]
    return programs


def all_files():
    return {name: text for guide in GUIDES for name, text in files_of((FOLDER / f"{guide}.md").read_text()).items()}


def line_fault(guide, files):
    program = GUIDES[guide][0]
    count = lines_of(program, files)
    return [] if count < LINES_BELOW else [f"{guide}.md: a match takes {count} lines, and has to take less than {LINES_BELOW}"]


def check(guide, arguments, folder):
    files, complaints = all_files(), []
    complaints += line_fault(guide, files)
    programs = compiled(files, guide, arguments.cxx, arguments.libraries, folder, complaints)
    if not complaints:
        complaints += GUIDES[guide][1](programs, folder, arguments.lockstone)
    if not complaints:
        print(f"{guide}: {lines_of(GUIDES[guide][0], files)} lines, {len(programs)} programs, {len(arguments.cxx)} compilers, {len(readme.FLAGS)} builds each")
    return complaints


def planted_desync(files, folder, arguments):
    """Returns the faults that check_desync() misses: a match without a desync, and a report that the guide does not show."""
    programs = {}
    for program in ("desync.cpp", "export.cpp"):
        source = written(files, needed_by(program, files), folder / "whole") / program
        programs[program] = [folder / f"whole-{program}"] * 2
        wrong = readme.compile_fault(source, programs[program][0], arguments.cxx[0], [*readme.FLAGS[0], *SOURCES], arguments.libraries)
        assert not wrong, wrong
    missed = [] if check_desync(programs, folder, arguments.lockstone, ("no", "no")) else ["a match without a desync"]
    others = check_desync(programs, folder, arguments.lockstone, ("no", "yes"))  # the two machines swap their values
    return missed + ([] if any("shows what nobody prints" in each for each in others) else ["a report that the guide does not show"])


def check_planted(guide, arguments, folder):
    program, match_check, faults = GUIDES[guide]
    files, missed = all_files(), []
    longer = dict(files)
    longer[program] += "// one line more\n" * (LINES_BELOW - lines_of(program, files))
    if not line_fault(guide, longer):
        missed.append(f"a guide of {lines_of(program, longer)} lines")
    if not readme.compile_fault(written({"x.cpp": files[program] + "int unused() { int x; }\n"} | files, ["x.cpp", *needed_by(program, files)],
                                        folder / "source") / "x.cpp", folder / "x", arguments.cxx[0], [*readme.FLAGS[0], *SOURCES], arguments.libraries):
        missed.append("a program with a warning")
    for number, (fault, text, other) in enumerate(faults):
        complaints, pair = [], []
        for name, change in (("well", {}), (f"fault-{number}", {n: t.replace(text, other) for n, t in files.items()})):
            source = written(files | change, needed_by(program, files), folder / name) / program
            pair.append(folder / name / "program")
            if wrong := readme.compile_fault(source, pair[-1], arguments.cxx[0], [*readme.FLAGS[0], *SOURCES], arguments.libraries):
                complaints.append(wrong)
        assert not complaints, complaints  # a planted fault that does not compile proves nothing
        noticed = match_check({program: pair}, folder, arguments.lockstone)
        print(f"{fault}: {noticed[:1]}")
        if not any("desync" in each for each in noticed):
            missed.append(fault)
    if guide == "desync":
        missed += planted_desync(files, folder, arguments)
    return [f"missed a planted fault: {each}" for each in missed]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("guide", choices=GUIDES)
    parser.add_argument("--libraries", type=pathlib.Path, required=True)
    parser.add_argument("--lockstone", type=pathlib.Path, required=True)
    parser.add_argument("--cxx", action="append")
    parser.add_argument("--planted", action="store_true")
    arguments = parser.parse_args()
    arguments.cxx = arguments.cxx or ["g++"]
    with tempfile.TemporaryDirectory(prefix="lockstone-guides-") as folder:
        complaints = (check_planted if arguments.planted else check)(arguments.guide, arguments, pathlib.Path(folder))
    print("\n".join(complaints), end="\n" if complaints else "")
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
