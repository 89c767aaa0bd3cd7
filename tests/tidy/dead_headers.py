"""A header that no file includes is dead code. Public headers are exempt: the programs of users include them."""
import re

from tree import without_comments


def check(tree):
    included = set()
    for path in tree.files(endings=(".h", ".cpp", ".c")):
        text = without_comments(path.read_text(), keep_strings=True)
        included |= {i.split("/")[-1] for i in re.findall(r'#\s*include\s*[<"]([^>"]+)[>"]', text)}
    headers = tree.files(("src", "replay", "tools", "demo", "tests"), (".h",))
    return [f"{tree.name(h)}:1: nobody includes it" for h in headers if h.name not in included]


PLANTED = [("a header that nobody includes", {"src/sim/x.h": "#pragma once\n"})]
GOOD = [("a header that one file includes", {"src/sim/x.h": "#pragma once\n", "src/sim/x.cpp": '#include "sim/x.h"\n'})]
