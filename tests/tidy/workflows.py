"""Every script that a workflow runs exists, and has each option that the workflow passes."""
import re

from tree import numbered

OURS = r"(?:tests|tools|demo|\.ci)/[\w./-]+"


def options_of(text):
    """Returns the options in a script's code: words like `--long`, or `--long)` for a case of a shell script. Without comments and docstrings."""
    code = "\n".join(re.sub(r"(^|\s)#.*", "", line) for line in text.splitlines())
    code = re.sub(r'"""(?:.|\n)*?"""', "", code)
    return set(re.findall(r"(?<![\w-])--?[a-z][\w-]*(?=[)\s|'\",]|$)", code, re.MULTILINE))


def check(tree):
    complaints = []
    for path in sorted((tree.root / ".github/workflows").glob("*.y*ml")):
        for number, line in numbered(path.read_text()):
            line = re.sub(r"(^|\s)#.*", "", line)
            for script, options in re.findall(rf"({OURS})((?: --?[\w-]+)*)", line):
                place = f"{tree.name(path)}:{number}"
                if not (tree.root / script).is_file():
                    complaints.append(f"{place}: there is no {script}")
                    continue
                known = options_of((tree.root / script).read_text())
                complaints += [f"{place}: {script} does not know {o}" for o in options.split() if o not in known]
    return complaints


def workflow(command, script="print('--long')"):
    return {".github/workflows/a.yml": f"jobs:\n  a:\n    # tests/never\n    steps:\n      - run: {command}\n", "tests/run": script}


PLANTED = [
    ("a script that is gone", workflow("tests/ran --long")),
    ("an option that is gone", workflow("tests/run --quick")),
    ("one that is a word of a comment", workflow("tests/run --quick", "# --quick was here\nprint('--long')")),
    ("one that is a word of the description", workflow("tests/run --quick", '"""a --quick run"""\nprint(\'--long\')')),
    ("one that is another word", workflow("tests/run --quick", "quick=1\nprint('--quicker')")),
    ("one behind an interpreter, in a table", workflow('{name: a, command: "python3 tools/gone --here"}')),
]
GOOD = [
    ("what exists, with an option that it knows", workflow("tests/run --long")),
    ("other programs", workflow("cmake --build build/release && brew install xxhash")),
]
