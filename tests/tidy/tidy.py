#!/usr/bin/env python3
"""Checks of the sources, each with planted faults that it has to find.

    tests/tidy/tidy.py words                      prints the faults and exits with 1; prints nothing and exits with 0 if there are none
    tests/tidy/tidy.py --planted words            makes small trees with one fault each; exits with 1 if the check misses a fault, or
                                                  complains about a good tree
    tests/tidy/tidy.py                            runs all checks that need no build and take less than a minute

A check is a module with three names. `check(tree)` returns sentences that start with file:line. `PLANTED` is a list of
(fault, {path: text}): `check` must complain about each of these trees. `GOOD` has trees that it must accept. If a module sets `SAYS_WHICH`,
each fault begins with a word and a comma, and a complaint must contain that word: other complaints do not count.
"""
import argparse
import importlib
import pathlib
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from tree import Tree  # noqa: E402

WITHOUT_BUILD = ["words", "compilers", "layers", "headers", "includes", "sizes", "readmes", "dead_headers", "misuse", "diagram", "workflows", "format", "tables", "cost_card", "thresholds", "assertions", "english"]
OF_RELEASE = ["instructions", "optimised"]
SLOW = ["lint"]  # takes a minute
OF_PROGRAM = ["stored_hashes"]  # needs bin/lockstone in the build folder, of any build type
OF_TOOL = ["winsock", "documented"]  # skipped unless mingw-w64 or doxygen is installed
CHECKS = WITHOUT_BUILD + SLOW + OF_RELEASE + OF_PROGRAM + OF_TOOL
SKIPPED = 77  # the exit status by which ctest recognises a skipped test


def run(name, tree):
    complaints = importlib.import_module(name).check(tree)
    for complaint in complaints:
        print(f"{name}: {complaint}")
    return not complaints


def verdict_on(module, files, arguments):
    with tempfile.TemporaryDirectory(prefix="lockstone-tidy-") as folder:
        tree = Tree(pathlib.Path(folder), pathlib.Path(folder) / "build", arguments.cxx)
        for path, text in files.items():
            target = tree.root / path
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(text.replace("ROOT/", f"{folder}/"))
            if text.startswith("#!"):
                target.chmod(0o755)
        return module.check(tree)


def run_planted(name, arguments):
    module = importlib.import_module(name)
    good = True
    for fault, files in module.PLANTED:
        word = fault.split(",")[0] if getattr(module, "SAYS_WHICH", False) else ""
        if not any(word in complaint for complaint in verdict_on(module, files, arguments)):
            print(f"{name}: missed a planted fault: {fault}")
            good = False
    for claim, files in module.GOOD:
        for complaint in verdict_on(module, files, arguments):
            print(f"{name}: complains about {claim}: {complaint}")
            good = False
    return good


def main():
    here = pathlib.Path(__file__).resolve()
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("check", nargs="*", metavar="CHECK", help=", ".join(CHECKS))
    parser.add_argument("--root", type=pathlib.Path, default=here.parents[2])
    parser.add_argument("--build", type=pathlib.Path, help="of the checks that read objects")
    parser.add_argument("--cxx", default="c++")
    parser.add_argument("--build-type", default="Release", help="of the build")
    parser.add_argument("--planted", action="store_true", help="check the checks")
    arguments = parser.parse_args()
    tree = Tree(arguments.root, arguments.build or arguments.root / "build/release", arguments.cxx)
    names = arguments.check or WITHOUT_BUILD
    if unknown := set(names) - set(CHECKS):
        parser.error(f"there is no check {', '.join(sorted(unknown))}; there are {', '.join(CHECKS)}")
    if not arguments.planted and arguments.build_type != "Release" and set(names) & set(OF_RELEASE):
        print(f"{', '.join(names)}: is about the release build, and this build's type is {arguments.build_type or 'none'}")
        sys.exit(SKIPPED)
    for name in set(names) & set(OF_TOOL):
        if reason := importlib.import_module(name).missing():
            print(f"{name}: {reason}")
            sys.exit(SKIPPED)
    results = [run_planted(n, arguments) if arguments.planted else run(n, tree) for n in names]
    sys.exit(0 if all(results) else 1)


if __name__ == "__main__":
    main()
