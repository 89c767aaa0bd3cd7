"""tests/metamorphic/worlds/thresholds.txt lists each compile-time integer of the engine with its kind. For a constant that chooses an execution path
it names the paths on both sides, so the author of such a constant also defines how a test detects that a world reaches them. The names of the paths
are those of src/base/paths.h."""
import re

from tree import without_comments

LIST = "tests/metamorphic/worlds/thresholds.txt"
PATHS = "src/base/paths.h"
FOLDERS = tuple(f"src/{layer}" for layer in ("base", "model", "tick", "scene", "collide", "solve", "shapes", "play", "world", "state"))
KINDS = {"format", "number", "limit", "room", "prefetch", "local"}
DEFINED = re.compile(r"\bconstexpr\s+(?:(?:inline|static)\s+)*(?:std::)?(?:u?int(?:8|16|32|64)_t|size_t|int|unsigned(?: int)?|long|char)\s+(\w+\s*(?:=|\{)[^;]*);")
DECLARED = re.compile(r"\s*(\w+)\s*(?:=|\{)")


def parts(text):
    """Yields the parts of the text between commas outside of all brackets."""
    depth, first = 0, 0
    for at, letter in enumerate(text):
        depth += (letter in "([{") - (letter in ")]}")
        if letter == "," and depth == 0:
            yield text[first:at]
            first = at + 1
    yield text[first:]


def defined(tree):
    """Returns {(path, name): line}."""
    found = {}
    for path in tree.files(FOLDERS):
        text = without_comments(path.read_text())
        for match in DEFINED.finditer(text):
            for part in parts(match.group(1)):
                if name := DECLARED.match(part):
                    found.setdefault((tree.name(path), name.group(1)), text.count("\n", 0, match.start()) + 1)
    return found


def listed(text):
    """Yields (line, path, name, kind) of each entry. The path is None if the entry does not have three words."""
    for number, line in enumerate(text.split("\n"), start=1):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        yield (number, *words) if len(words) == 3 else (number, None, line.strip(), None)


def kind_complaint(kind, paths):
    if not kind.startswith("path:"):
        return "" if kind in KINDS else f"'{kind}' is no kind; there are path:, {', '.join(sorted(KINDS))}"
    names = kind.removeprefix("path:").split(",")
    if missing := [name for name in names if name not in paths]:
        return f"no path is named {', '.join(missing)}"
    return "" if len(names) > 1 else "a choice has two sides, and one path is named"


def check(tree):
    if not (tree.root / LIST).exists():
        return [f"{LIST}:1: the list is missing"]
    there, complaints, seen = defined(tree), [], set()
    header = tree.root / PATHS
    paths = set(re.findall(r"\bX\((\w+)\)", without_comments(header.read_text()))) if header.exists() else set()
    for line, path, name, kind in listed((tree.root / LIST).read_text()):
        if path is None:
            complaints.append(f"{LIST}:{line}: no line of a file, a name and a kind: {name}")
            continue
        if (path, name) in seen:
            complaints.append(f"{LIST}:{line}: {path} {name} stands twice")
        seen.add((path, name))
        if (path, name) not in there:
            complaints.append(f"{LIST}:{line}: {path} defines no constant {name}")
        if wrong := kind_complaint(kind, paths):
            complaints.append(f"{LIST}:{line}: {path} {name}: {wrong}")
    complaints += [f"{path}:{line}: {name} is not in {LIST}" for (path, name), line in sorted(there.items()) if (path, name) not in seen]
    return complaints


SAYS_WHICH = True
TWO_PATHS = "#define LOCKSTONE_PATHS(X) X(by_one) X(by_workers)\n"
CHUNK = "constexpr std::uint32_t chunk = 16, most = f(1, 2);\n"
BOTH = "# kinds\nsrc/tick/x.cpp chunk path:by_one,by_workers\nsrc/tick/x.cpp most number\n"


def with_list(entries, source=CHUNK, paths=TWO_PATHS):
    return {"src/tick/x.cpp": source, PATHS: paths, LIST: entries}


PLANTED = [
    ("chunk, which is not in the list", with_list("src/tick/x.cpp most number\n")),
    ("most, the second of a definition, which is not in the list", with_list("src/tick/x.cpp chunk path:by_one,by_workers\n")),
    ("inside, which stands in a class and is not in the list", with_list(BOTH, CHUNK + "struct S { static constexpr int inside{3}; };\n")),
    ("gone, which no source defines any more", with_list(BOTH + "src/tick/x.cpp gone number\n")),
    ("y.cpp, a file that is gone", with_list(BOTH + "src/tick/y.cpp chunk number\n")),
    ("by_nobody, a path that is no more", with_list(BOTH.replace("by_workers", "by_nobody"))),
    ("two, where one side of a choice is left out", with_list(BOTH.replace(",by_workers", ""))),
    ("guess, a kind that does not exist", with_list(BOTH.replace("number", "guess"))),
    ("twice, an entry that is repeated", with_list(BOTH + "src/tick/x.cpp most number\n")),
    ("kind, an entry without one", with_list(BOTH.replace(" number", ""))),
    ("missing, the list itself", {"src/tick/x.cpp": CHUNK}),
]
GOOD = [
    ("a list that is complete", with_list(BOTH)),
    ("constants of other kinds, tables and functions", with_list(BOTH, CHUNK + "constexpr Real far = 3_r;\nconstexpr int at[2] = {1, 2};\n"
                                                                        "constexpr int twice(int x) { return 2 * x; }\n// constexpr int old = 3;\n")),
]
