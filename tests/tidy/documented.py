"""Every public name of include/ has a comment, and doxygen understands each comment: with docs/Doxyfile it prints no warning."""
import pathlib
import re
import shutil
import subprocess
import tempfile

CONFIGURATION = "docs/Doxyfile"
# These lines override those of docs/Doxyfile: the check discards the output, and doxygen always reports undocumented names.
OVERRIDES = ["GENERATE_HTML = NO", "GENERATE_XML = YES", "QUIET = YES", "WARNINGS = YES", "WARN_IF_UNDOCUMENTED = YES",
             "WARN_IF_DOC_ERROR = YES", "EXTRACT_ALL = NO"]
NAMESPACE = re.compile(r"(?P<comment>///[^\n]*\n)?[ ]*(?:inline )?namespace (?:\w+::)*(?P<name>\w+) \{")
COMPLAINT = re.compile(r"^(?P<path>\S+):(?P<line>\d+): (?:warning: |error: )?(?P<text>.*)$")


def missing():
    return None if shutil.which("doxygen") else "doxygen is not installed (package doxygen)"


def silent_namespaces(tree):
    """Returns complaints about namespaces without a comment: doxygen does not report functions in them. One comment in any header is enough."""
    seen, documented = {}, {"detail"}
    for path in tree.files(("include",), (".h",)):
        text = path.read_text()
        for found in NAMESPACE.finditer(text):
            seen.setdefault(found["name"], f"{tree.name(path)}:{text.count(chr(10), 0, found.end()) + 1}")
            documented |= {found["name"]} if found["comment"] else set()
    return [f"{place}: namespace {name} is not documented" for name, place in seen.items() if name not in documented]


def check(tree):
    configuration = tree.root / CONFIGURATION
    if not configuration.exists():
        return [f"{CONFIGURATION}:1: the file does not exist"]
    if not tree.files(("include",), (".h",)):
        return ["include:1: there are no headers"]
    with tempfile.TemporaryDirectory(prefix="lockstone-doxygen-") as folder:
        text = "\n".join([configuration.read_text(), f"OUTPUT_DIRECTORY = {folder}", *OVERRIDES])
        run = subprocess.run(["doxygen", "-"], cwd=tree.root, input=text, capture_output=True, text=True)
    complaints = silent_namespaces(tree)
    for line in run.stderr.splitlines():
        if found := COMPLAINT.match(line):
            complaints.append(f"{found['path'].removeprefix(f'{tree.root}/')}:{found['line']}: {found['text']}")
        elif line.startswith(("warning:", "error:")):
            complaints.append(f"{CONFIGURATION}:1: {line}")
    if run.returncode != 0 and not complaints:
        complaints.append(f"{CONFIGURATION}:1: doxygen ends with exit status {run.returncode}")
    return sorted(set(complaints))


HEADER = "include/lockstone/x.h"
FILE = {CONFIGURATION: (pathlib.Path(__file__).parents[2] / CONFIGURATION).read_text()}
CLASS = "/// The library.\nnamespace lockstone {\n/// A body.\nstruct Body {\n    int a; ///< mass [kg]\n%s};\n%s}\n"
SAYS_WHICH = True
PLANTED = [
    ("weigh, a function without a comment", FILE | {HEADER: CLASS % ("", "int weigh(Body body);\n")}),
    ("tick, a member function without a comment", FILE | {HEADER: CLASS % ("    void tick();\n", "")}),
    ("speed, a field without a comment", FILE | {HEADER: CLASS % ("    int speed;\n", "")}),
    ("depth, the second field of one declaration", FILE | {HEADER: CLASS % ("    int width, depth;\n", "")}),
    ("Kind, an enumeration without a comment", FILE | {HEADER: CLASS % ("", "enum class Kind { box };\n")}),
    ("Shape, a class without a comment", FILE | {HEADER: CLASS % ("", "struct Shape {\n    int b;\n};\n")}),
    ("unknown, a command that doxygen does not have", FILE | {HEADER: CLASS % ("    int b; ///< \\unknown\n", "")}),
    ("empty, a namespace without a comment", FILE | {HEADER: CLASS % ("", "namespace empty {\nint weigh(Body body);\n}\n")}),
    ("headers, no header at all", dict(FILE)),
    ("exist, no configuration", {HEADER: CLASS % ("", "")}),
    ("weigh, a configuration that reports nothing",
     {CONFIGURATION: FILE[CONFIGURATION] + "WARN_IF_UNDOCUMENTED = NO\n", HEADER: CLASS % ("", "int weigh(Body body);\n")}),
]
GOOD = [
    ("documented names", FILE | {HEADER: CLASS % ("    int b, ///< width [m]\n        c; ///< depth [m]\n", "/// Its mass [kg].\nint weigh(Body body);\n")}),
    ("private members", FILE | {HEADER: CLASS % ("  private:\n    int hidden;\n", "")}),
    ("a group with one comment", FILE | {HEADER: CLASS % ("", "/// Field list.\n///@{\nvoid describe(int a);\nvoid describe(long a);\n///@}\n")}),
    ("details", FILE | {HEADER: CLASS % ("", "namespace detail {\nint weigh(int a);\nstruct Row { int b; };\n}\n")}),
]
