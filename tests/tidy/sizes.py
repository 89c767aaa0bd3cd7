"""A function of more than 60 lines has a comment above it with "Long:" and a reason. A file of more than 600 lines has such a comment in its
first 20 lines. A folder of sources has at most 25 files."""
import re

from tree import without_comments

FUNCTION_LINES_MAX = 60
FILE_LINES_MAX = 600
FOLDER_FILES_MAX = 25
REASON = re.compile(r"Long:\s+\w+")
NOT_A_FUNCTION = re.compile(r"^\s*(template\s*<.*>\s*)?(namespace|class|struct|union|enum|extern\s*\"|if|for|while|switch|else|do|catch)\b",
                            re.DOTALL)


def kind_of(head):
    """Returns "function" or "scope", the kind of block that the brace after `head` opens. `head` is the code since the last ; { or }."""
    head = re.sub(r"^\s*#[^\n]*$", "", head, flags=re.MULTILINE).strip()
    if re.search(r"\b(class|struct|enum|union)\s+\w+(\s*:[^()]*)?$", head):  # with or without template and requires clauses in front
        return "scope"
    if NOT_A_FUNCTION.match(head) and not re.match(r"(class|struct|enum|union)\b[^({]*\b\w+\s*\(", head):
        return "scope"
    return "function" if "(" in head and not re.search(r"=\s*$", head) else "scope"


def functions(code):
    """Yields (first line of the head, last line of the body) of each outermost function."""
    stack, head_start, line = [], 0, 1
    for at, letter in enumerate(code):
        if letter == "\n":
            line += 1
        elif letter == "{":
            inside = "function" in (entry[0] for entry in stack)
            head = code[head_start:at]
            first = line - head.lstrip().count("\n")
            stack.append(("inner" if inside else kind_of(head), first))
            head_start = at + 1
        elif letter == "}" and stack:
            kind, first = stack.pop()
            if kind == "function":
                yield first, line
            head_start = at + 1
        elif letter == ";":
            head_start = at + 1


def has_reason(lines, first):
    """Returns true if the comment right above line `first` gives a reason."""
    at = first - 2
    while at >= 0 and lines[at].strip().startswith(("//", "template", "*", "/*")):
        if REASON.search(lines[at]):
            return True
        at -= 1
    return False


def check(tree):
    complaints = []
    for path in tree.files():
        name, text = tree.name(path), path.read_text()
        lines = text.split("\n")
        if len(lines) - 1 > FILE_LINES_MAX and not REASON.search("\n".join(lines[:20])):
            complaints.append(f"{name}:1: {len(lines) - 1} lines without a reason above")
        for first, last in functions(without_comments(text)):
            if last - first + 1 > FUNCTION_LINES_MAX and not has_reason(lines, first):
                complaints.append(f"{name}:{first}: a function of {last - first + 1} lines without a reason above")
    for folder in sorted({path.parent for path in tree.files()}):
        count = sum(path.is_file() for path in folder.iterdir())
        if count > FOLDER_FILES_MAX:
            complaints.append(f"{tree.name(folder)}: {count} files, at most {FOLDER_FILES_MAX} are looked through at once")
    return complaints


LONG_BODY = "    work();\n" * 60
PLANTED = [
    ("a long function", {"src/sim/x.cpp": "namespace a {\nvoid f() {\n" + LONG_BODY + "}\n}\n"}),
    ("a long method", {"src/sim/x.h": "struct S {\n    int f(int x) const override {\n" + LONG_BODY + "    }\n};\n"}),
    ("a long constructor", {"src/sim/x.cpp": "S::S(int x) : y{x}, z(x) {\n" + LONG_BODY + "}\n"}),
    ("a long test", {"tests/law/x.cpp": 'TEST_CASE("claim") {\n' + LONG_BODY + "}\n"}),
    ("a long file", {"src/sim/x.cpp": "int x;\n" * 601}),
    ("a full folder", {f"src/sim/x{i}.cpp": "int x;\n" for i in range(26)}),
]
GOOD = [
    ("as many files as there may be", {f"src/sim/x{i}.cpp": "int x;\n" for i in range(25)}),
    ("a long function with a reason", {"src/sim/x.cpp": "// Long: one row per opcode.\nvoid f() {\n" + LONG_BODY + "}\n"}),
    ("a long namespace", {"src/sim/x.cpp": "namespace a {\n" + "int f() { return 1; }\n" * 100 + "}\n"}),
    ("a long template with a requires clause", {"src/sim/x.h": "template <class T>\n    requires(a<T> && b<T>)\nstruct S {\n" + "    int x;\n" * 70 + "};\n"}),
    ("a long struct and a long table", {"src/sim/x.h": "struct S {\n" + "    int x = f();\n" * 70 + "};\nint t[] = {\n" + "1,\n" * 70 + "};\n"}),
]
