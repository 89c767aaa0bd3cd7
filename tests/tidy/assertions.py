"""tests/attack/assertions.txt lists every assertion of the library, with the reason why data from a file, a state or a packet cannot break it:
data from outside must not end the program."""
import collections
import re

from tree import without_comments

LIST = "tests/attack/assertions.txt"
FOLDERS = ("src", "include", "replay")
KINDS = {"caller", "checked", "library"}
PLACED = re.compile(r"(#\s*define\s+)?\bLOCKSTONE_ASSERT\(")


def condition_at(text, at):
    """Returns the first argument of the call whose opening parenthesis is right before `at`, as one line."""
    depth, end = 1, at
    while end < len(text):
        letter = text[end]
        depth += (letter in "([{") - (letter in ")]}")
        if depth == 0 or (letter == "," and depth == 1):
            break
        end += 1
    return " ".join(text[at:end].split())


def placed(tree):
    """Returns {(path, condition): count} and {(path, condition): line of the first}."""
    counts, lines = collections.Counter(), {}
    for path in tree.files(FOLDERS):
        text = without_comments(path.read_text())
        for match in PLACED.finditer(text):
            if match.group(1):
                continue
            key = (tree.name(path), condition_at(text, match.end()))
            counts[key] += 1
            lines.setdefault(key, text.count("\n", 0, match.start()) + 1)
    return counts, lines


def listed(text):
    """Yields (line, path, condition, kind, reason) of each entry. The path is None if the entry does not have four fields."""
    for number, line in enumerate(text.split("\n"), start=1):
        if not line.strip() or line.startswith("#"):
            continue
        fields = [field.strip() for field in line.split(" | ")]
        yield (number, *fields) if len(fields) == 4 else (number, None, line.strip(), None, None)


def check(tree):
    if not (tree.root / LIST).exists():
        return [f"{LIST}:1: the list is missing"]
    counts, lines = placed(tree)
    complaints, seen = [], collections.Counter()
    for line, path, condition, kind, reason in listed((tree.root / LIST).read_text()):
        if path is None:
            complaints.append(f"{LIST}:{line}: no line of a file, a condition, a kind and a reason: {condition}")
            continue
        seen[path, condition] += 1
        if seen[path, condition] > counts[path, condition]:
            complaints.append(f"{LIST}:{line}: {path} has {counts[path, condition]} assertions of {condition}")
        if kind not in KINDS:
            complaints.append(f"{LIST}:{line}: '{kind}' is no kind; there are {', '.join(sorted(KINDS))}")
        if not reason:
            complaints.append(f"{LIST}:{line}: {condition}: the reason is missing")
    complaints += [f"{path}:{lines[path, condition]}: the assertion of {condition} is not in {LIST}, or not as often as it stands there"
                   for (path, condition), count in sorted(counts.items()) if seen[path, condition] < count]
    return complaints


SAYS_WHICH = True
SOURCE = "void f() {\n    LOCKSTONE_ASSERT(a < size(b, c), \"a \", a);\n    LOCKSTONE_ASSERT(good\n                     .ok());\n}\n"
BOTH = "# kinds\nsrc/x.cpp | a < size(b, c) | caller | an argument\nsrc/x.cpp | good .ok() | checked | check_state()\n"


def with_list(entries, source=SOURCE):
    return {"src/x.cpp": source, LIST: entries}


PLANTED = [
    ("size, which is not in the list", with_list("src/x.cpp | good .ok() | checked | check_state()\n")),
    ("good, a second one like it", with_list(BOTH, SOURCE + "void g() { LOCKSTONE_ASSERT(good .ok()); }\n")),
    ("gone, which no source has any more", with_list(BOTH + "src/x.cpp | gone | caller | an argument\n")),
    ("guess, a kind that does not exist", with_list(BOTH.replace("caller", "guess"))),
    ("reason, which is left out", with_list(BOTH.replace("an argument", " "))),
    ("line, an entry without a kind", with_list(BOTH.replace(" | caller", ""))),
    ("missing, the list itself", {"src/x.cpp": SOURCE}),
]
GOOD = [
    ("a list that is complete", with_list(BOTH)),
    ("a definition and a comment", with_list(BOTH, SOURCE + "#define LOCKSTONE_ASSERT(condition, ...) f(condition)\n// LOCKSTONE_ASSERT(old);\n")),
]
