"""Every Markdown file names only files that exist. A README has no table of files: the first comment of each file says what the file is.
In other documents a table of files names only files of the document's folder."""
import re

from tree import CODE_FOLDERS, numbered

ENDINGS = (".h", ".cpp", ".md", ".py", ".sh", ".txt", ".cmake", ".vert", ".frag", ".glsl", ".tsv", ".ttf", ".json")
# Folders that a name may be relative to, besides the folder of the document.
BASES = ("", "include", "src", "tools", "tests", "demo", "replay")
MADE_BY_RUNNING = ("build/",)
PLACEHOLDER = re.compile(r"(^|/)(NAME|FILE|SCENE|MESH|ASSET)\b")
FOREIGN = ("xxhash.h",)
FILE_COLUMNS = ("file", "files", "header")  # titles of the first column of a table of files
NAME = re.compile(r"[\w.\-/*]+")


def is_name(word, root):
    """Returns true for names of files like `src/math`, `tick.cpp` or `tests/run`, and false for `n/a`, `world.save` and `0.5`."""
    if not NAME.fullmatch(word) or word.startswith(MADE_BY_RUNNING + ("/", "-", "http")):
        return False
    if PLACEHOLDER.search(word) or word in FOREIGN:
        return False
    return word.endswith(ENDINGS) or re.match(r"[\w.]*\w/", word) is not None and (root / word.split("/")[0]).is_dir()


def exists(word, folder, root):
    if "/" not in word and any(any((root / top).rglob(word)) for top in CODE_FOLDERS if (root / top).is_dir()):
        return True
    places = [folder] + [root / base for base in BASES]
    if "*" in word:
        return any(any(place.glob(word)) for place in places)
    return any((place / word).exists() for place in places)


def is_table_of_files(line):
    return line.startswith("|") and line.split("|")[1].strip() in FILE_COLUMNS


def misplaced(lines, folder):
    """Yields (line number, name) of each name in the first column of a table of files that is not in the folder."""
    in_table = False
    for number, line in lines:
        cell = line.split("|")[1].strip() if line.startswith("|") else None
        in_table = cell is not None and (in_table or cell in FILE_COLUMNS)
        for name in re.findall(r"`([^`\s*]+)`", cell or "") if in_table else []:
            if name.endswith(ENDINGS) and not (folder / name).exists():
                yield number, name


def check(tree):
    complaints = []
    for path in sorted(tree.root.rglob("*.md")):
        if tree.name(path).startswith(("build", ".git")) or "node_modules" in path.parts:
            continue
        complaints += [f"{tree.name(path)}:{number}: {name} is not in this folder"
                       for number, name in misplaced(numbered(path.read_text()), path.parent)]
        fenced = False
        for number, line in numbered(path.read_text()):
            if path.name == "README.md" and is_table_of_files(line):
                complaints.append(f"{tree.name(path)}:{number}: a table of files; the first comment of each file says what it is")
            if line.lstrip().startswith("```"):
                fenced = not fenced
            words = re.findall(r"\]\(([^)#\s]+)", line)
            # In a fenced block each word counts, in other lines only words that are quoted as code.
            for code in [line] if fenced else re.findall(r"`([^`]+)`", line):
                words += [w.removeprefix("./").rstrip(",;:") for w in code.split()]
            for word in dict.fromkeys(words):
                if is_name(word, tree.root) and not exists(word, path.parent, tree.root):
                    if not (fenced and not (tree.root / word.split("/")[0]).is_dir()):
                        complaints.append(f"{tree.name(path)}:{number}: there is no {word}")
    return complaints


PLANTED = [
    ("a file that is gone", {"README.md": "Start at `src/tick/tick.cpp`.\n", "src/world/world.cpp": ""}),
    ("a script that is gone", {"README.md": "```\ntests/run --long\n```\n", "tests/main.cpp": ""}),
    ("a link to nowhere", {"docs/a.md": "See [the spec](FORMAT.md).\n"}),
    ("a table of files in a README", {"src/prove/README.md": "| file | what |\n|---|---|\n| `prove.cpp` | the proof |\n", "src/prove/prove.cpp": ""}),
    ("a row of a file that moved away", {"src/session/walk.md": "| file | what |\n|---|---|\n| `prove.cpp` | the proof |\n", "src/prove/prove.cpp": ""}),
    ("a pattern without a match", {"tests/README.md": "`law/*.cpp` hold the algebra.\n"}),
]
GOOD = [
    ("files that exist, and words that are not files", {
        "README.md": "`src/tick/tick.cpp`, `lockstone/math/vec.h`, `world.save()`, `0.5`, `n/a`, `build/release/bin/lockstone`\n",
        "src/tick/tick.cpp": "", "include/lockstone/math/vec.h": ""}),
    ("a table of files, and one of other things", {
        "src/a/walk.md": "| file | what |\n|---|---|\n| `b/c.h` | `src/a/b/c.h` |\n\n| tool | what |\n|---|---|\n| `d.cpp` | |\n",
        "src/a/b/c.h": "", "src/d.cpp": ""}),
    ("code that names what the reader will write", {"README.md": '```\n#include "game.h"\ncc my_game.cpp\n```\n'}),
]
