"""The source tree that the checks read."""
import re

SOURCES = (".h", ".cpp")
CODE_FOLDERS = ("include", "src", "replay", "tools", "demo", "tests")
# A comment, a string or a character, whichever begins first. Raw strings have no escapes.
TOKEN = re.compile(r'R"(?P<mark>\w*)\((?:.|\n)*?\)(?P=mark)"|//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|(?<![0-9a-fA-F])\'(?:\\.|[^\'\\\n])+\'',
                   re.DOTALL)


class Tree:
    def __init__(self, root, build, cxx):
        self.root = root
        self.build = build
        self.cxx = cxx

    def files(self, folders=CODE_FOLDERS, endings=SOURCES):
        """Returns the paths of the files in these folders with these endings, in a fixed order."""
        found = []
        for folder in folders:
            found += [p for p in (self.root / folder).rglob("*") if p.is_file() and p.name.endswith(tuple(endings))]
        return sorted(found)

    def name(self, path):
        return path.relative_to(self.root).as_posix()


def without_comments(text, keep_strings=False):
    """Returns the text with blanks in place of comments and, unless keep_strings is set, of strings. Every line keeps its number."""
    def blank(match):
        token = match.group(0)
        if keep_strings and not token.startswith(("//", "/*")):
            return token
        return re.sub(r"[^\n]", " ", token)
    return TOKEN.sub(blank, text)


def numbered(text):
    return enumerate(text.split("\n"), start=1)
