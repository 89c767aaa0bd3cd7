"""The tables of replay/FORMAT.md are what `lockstone format` prints. Run by itself it writes them into the page."""
import pathlib
import re
import subprocess

PAGE = "replay/FORMAT.md"
PART = re.compile(r"<!-- (?P<name>\w+) -->\n.*?<!-- end of (?P=name) -->\n", re.DOTALL)


def parts_of(text):
    """By name: each table with its marks."""
    return {match["name"]: match.group(0) for match in PART.finditer(text)}


def printed(build):
    program = build / "bin/lockstone"
    if not program.exists():
        return {}
    return parts_of(subprocess.run([program, "format"], capture_output=True, text=True, check=True).stdout)


def check(tree):
    parts = printed(tree.build)
    if not parts:
        return [f"{tree.build}/bin/lockstone:1: is missing or prints no table; a release build makes it"]
    page = tree.root / PAGE
    there = parts_of(page.read_text()) if page.exists() else {}
    complaints = [f"{PAGE}:1: has no table <!-- {name} -->" for name in parts if name not in there]
    complaints += [f"{PAGE}:1: nothing prints the table <!-- {name} -->" for name in there if name not in parts]
    return complaints + [f"{PAGE}:1: the table <!-- {name} --> is not that of the descriptions; tests/tidy/tables.py writes it anew"
                         for name in parts if there.get(name, parts[name]) != parts[name]]


def table(name, row):
    return f"<!-- {name} -->\n| field |\n|---|\n| {row} |\n<!-- end of {name} -->\n"


PROGRAM = {"build/bin/lockstone": "#!/bin/sh\ncat <<'END'\n" + table("world", "seed") + table("commands", "wake_body") + "END\n"}
TRUE = "# The file\n\n" + table("world", "seed") + "\nText.\n\n" + table("commands", "wake_body")
PLANTED = [
    ("not that of the descriptions, a field that was renamed", {**PROGRAM, PAGE: TRUE.replace("seed", "seeds")}),
    ("not that of the descriptions, a row more", {**PROGRAM, PAGE: TRUE.replace("| wake_body |", "| wake_body |\n| rest_body |")}),
    ("no table, one that was left out", {**PROGRAM, PAGE: "# The file\n\n" + table("world", "seed")}),
    ("nothing prints, a table that is kept by hand", {**PROGRAM, PAGE: TRUE + table("ticks", "count")}),
    ("is missing, no program", {PAGE: TRUE}),
    ("prints no table, another program", {"build/bin/lockstone": "#!/bin/sh\n", PAGE: TRUE}),
]
SAYS_WHICH = True
GOOD = [("a page that is true", {**PROGRAM, PAGE: TRUE})]


def main():
    root = pathlib.Path(__file__).resolve().parents[2]
    parts = printed(root / "build/release")
    page = root / PAGE
    page.write_text(PART.sub(lambda match: parts.get(match["name"], match.group(0)), page.read_text()))


if __name__ == "__main__":
    main()
