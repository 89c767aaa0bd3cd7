"""Comments, documents and commit titles are plain English.

A riddle is a sentence that hides its subject ("What is near is skipped"), speaks of code as of people ("nobody tells"), or uses
a word that the field does not. Of 1,000 comment lines of Box3D and Jolt, 1 to 3 are riddles."""
import re
import subprocess

AREAS = ("include", "src", "replay", "tools", "demo", "tests")
PER_THOUSAND = 5
TITLES_PER_THOUSAND = 3
TITLES = 300  # the newest commits of a clone
# Titles up to this commit follow no rule. The check reads no titles in a clone without it, such as a shallow one.
FIRST_TITLE = "44fd999e84280f186d3d59b77e6c9cb2ba0d9bc2"

OPENINGS = (r"(?:What|Who|Whose|Whoever|Whom|Whether|Of|The same|Those|Nobody|Nothing|Neither|As \w+ as|To whom|Not where|Till|"
            r"Where nothing|Where nobody)\b")
PEOPLE = (r"nobody|anybody|somebody|whoever|whom|told|tells|asks|asked for|asleep among|by themselves|"
          r"who (?:is|has|does|waits|leaves|comes|watches|asks|knows|sleeps|plays|are|have)|goes? (?:on as|its own)")
WORDS = (r"anew|is there to|are there to|at hand|in vain|by chance|by itself|whose \w+ (?:is|are) not|"
         r"stands? (?:in|for|before|still|alone|apart|there|by)|has to be what|is what|are what|does what|no (?:more|fewer|less) than (?:one|it)|"
         r"the other ones?|one after (?:another|the other)|the one that|of which|serves? (?:again|for)|things? that|all else|all that|"
         r"much of what|and nothing else|nothing but|for good|ever after|till|hence|thereby|wherever|likewise|neither of")
RIDDLES = re.compile(rf"^{OPENINGS}|(?i:\b(?:{PEOPLE}|{WORDS})\b)")


def sentences_of_document(text):
    fenced = False
    for number, line in enumerate(text.split("\n"), 1):
        if line.lstrip().startswith("```"):
            fenced = not fenced
            continue
        sentence = line.strip().lstrip("*-#>| ")
        if not fenced and len(sentence) > 20:
            yield number, sentence


def sentences_of_code(text, comment):
    in_block = False
    for number, line in enumerate(text.split("\n"), 1):
        stripped = line.strip()
        if in_block or (comment == "//" and stripped.startswith("/*")):
            in_block = "*/" not in stripped
            yield number, stripped.lstrip("/*! ")
            continue
        pattern = r'(?<![:"\w])///?[!<]*\s*(.+)$' if comment == "//" else r"(?:^|\s)#\s+(.+)$"
        found = re.search(pattern, line)
        if found and len(found[1]) > 3 and not re.match(r"[-=]{4,}", found[1]):
            yield number, found[1]


def sentences_of(path):
    text = path.read_text(errors="replace")
    if path.suffix == ".md":
        return sentences_of_document(text)
    is_script = path.suffix in (".py", ".sh") or (path.suffix == "" and text.startswith("#!"))
    return sentences_of_code(text, "#" if is_script else "//")


def files_of(tree, area):
    if area != "documents":
        endings = (".h", ".hpp", ".cpp", ".c", ".py", ".sh")
        found = tree.files((area,), endings)
        return found + [p for p in tree.files((area,), ("",)) if p.suffix == "" and p.read_bytes().startswith(b"#!")]
    return sorted(tree.root.glob("*.md")) + tree.files(AREAS + ("docs", "bindings"), (".md",))


def complaints_of(place, sentences, limit):
    lines, riddles = 0, []
    for where, sentence in sentences:
        lines += 1
        if found := RIDDLES.search(sentence):
            riddles.append(f"{where}: '{found[0]}' in \"{sentence.strip()[:120]}\"")
    if len(riddles) * 1000 <= limit * lines:
        return []
    return [f"{place}: {len(riddles)} riddles in {lines} lines, and at most {limit} of 1,000 are allowed", *riddles]


def titles(tree):
    """The titles since FIRST_TITLE; none in a tree without history."""
    if not (tree.root / ".git").exists():
        return []
    log = subprocess.run(["git", "-C", str(tree.root), "log", f"-{TITLES}", "--format=%H %s"], capture_output=True, text=True, check=False)
    newer = []
    for line in log.stdout.splitlines():
        commit, _, title = line.partition(" ")
        if commit == FIRST_TITLE:
            return newer
        newer.append((commit[:8], title))
    return []


def check(tree):
    complaints = []
    for area in (*AREAS, "documents"):
        sentences = ((f"{tree.name(path)}:{number}", sentence) for path in files_of(tree, area) for number, sentence in sentences_of(path))
        complaints += complaints_of(area, sentences, PER_THOUSAND)
    return complaints + complaints_of("commit titles", titles(tree), TITLES_PER_THOUSAND)


SAYS_WHICH = True
PLANTED = [
    ("'What', a hidden subject", {"src/a.h": "// What is near is skipped.\n"}),
    ("'nobody', code as people", {"include/a.h": "/// The list that nobody reads.\n"}),
    ("'anew', a word that the field does not use", {"demo/a.cpp": "int x; // built anew in each tick\n"}),
    ("'Whether', in a block", {"src/a.cpp": "/* The first line.\n   Whether it is cached.\n*/\n"}),
    ("'Of', in a document", {"tests/README.md": "Of two bodies the second moves in each tick.\n"}),
    ("'likewise', in a script", {"tools/run": "#!/bin/sh\n# likewise for the second folder\n"}),
    ("6 riddles, more than five of a thousand", {"replay/a.h": "// Returns the tick.\n" * 994 + "// Returns the one that is older.\n" * 6}),
]
GOOD = [
    ("plain sentences", {"src/a.h": "/// Returns the tick of a body.\n// The solver skips contacts whose bodies sleep.\n",
                         "tests/README.md": "```\nWhat a program prints is no sentence of ours.\n```\n"}),
    ("text in strings", {"src/a.cpp": 'const char* x = "nobody"; // a name\n'}),
    ("five of a thousand", {"replay/a.h": "// Returns the tick.\n" * 995 + "// Returns the one that is older.\n" * 5}),
]
