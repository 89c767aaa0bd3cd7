"""The diagram of src/README.md shows the includes of the sources, and no lower layer includes a higher one. tools/refresh rewrites it."""
import re

from layers import INCLUDE, LINKS, layer_of, target_of
from tree import numbered, without_comments

README = "src/README.md"
BEGIN, END = "<!-- includes -->\n", "<!-- end of includes -->\n"


def arrows(tree):
    """Returns {(layer, layer): number of files of the first that include the second} and {(layer, layer): place of the first such include}."""
    counts, places = {}, {}
    for path in tree.files(("include", "src", "replay")):
        name, seen = tree.name(path), set()
        layer = layer_of(name)
        if layer not in LINKS:
            continue
        for number, line in numbered(without_comments(path.read_text(), keep_strings=True)):
            found = INCLUDE.match(line)
            target = found and target_of(found.group(2))
            if target in LINKS and target != layer:
                seen.add(target)
                places.setdefault((layer, target), f"{name}:{number}")
        for target in seen:
            counts[layer, target] = counts.get((layer, target), 0) + 1
    return counts, places


def drawn(counts):
    """Returns the diagram: a row for each layer, from the lowest up, with the number of its files that include the layer of each column."""
    names = list(LINKS)
    width = max(map(len, names)) + 1
    lines = [" " * width + "".join(f"{n:>{len(n) + 2}}" for n in names[:-1])]
    for row in names:
        cells = "".join(f"{counts.get((row, n), '.' if names.index(n) < names.index(row) else ''):>{len(n) + 2}}" for n in names[:-1])
        lines.append(f"{row:<{width}}{cells}".rstrip())
    return "```\n" + "\n".join(lines) + "\n```\n"


def check(tree):
    path = tree.root / README
    counts, places = arrows(tree)
    order = list(LINKS)
    complaints = [f"{place}: an arrow upwards, from {a} to {b}" for (a, b), place in places.items() if order.index(b) > order.index(a)]
    text = path.read_text() if path.exists() else ""
    found = re.search(re.escape(BEGIN) + "(.*?)" + re.escape(END), text, re.DOTALL)
    if not found:
        complaints.append(f"{README}:1: has no diagram between {BEGIN.strip()} and {END.strip()}")
    elif found.group(1) != drawn(counts):
        complaints.append(f"{README}:1: the diagram is not that of the includes; tools/refresh rewrites it")
    return complaints


def refresh(tree):
    """Writes the diagram into the README. Returns true if the README changed."""
    counts, _ = arrows(tree)
    path = tree.root / README
    before = path.read_text()
    after = re.sub(re.escape(BEGIN) + ".*?" + re.escape(END), lambda _: BEGIN + drawn(counts) + END, before, flags=re.DOTALL)
    path.write_text(after)
    return after != before


def readme_of(counts):
    return "# The layers\n\n" + BEGIN + drawn(counts) + END


MATH = {"src/math/x.cpp": '#include "base/x.h"\n'}
PLANTED = [
    ("no diagram", {**MATH, README: "# The layers\n"}),
    ("an include that is not drawn", {**MATH, README: readme_of({})}),
    ("one file more than drawn", {**MATH, "src/math/y.cpp": '#include "base/x.h"\n', README: readme_of({("math", "base"): 1})}),
    ("an arrow upwards", {"src/base/x.cpp": '#include "math/x.h"\n', README: readme_of({("base", "math"): 1})}),
]
GOOD = [("a diagram that is true", {**MATH, README: readme_of({("math", "base"): 1})})]
