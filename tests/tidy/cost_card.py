"""The cost card of README.md has the figures of the newest results file in tools/bench/results. tools/refresh rewrites it."""
import json
import pathlib
import re
import sys

PAGE, RESULTS = "README.md", "tools/bench/results"
CARD = re.compile(r"<!-- cost card -->\n(.*?)<!-- end of cost card -->\n", re.DOTALL)

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools/bench"))
from figures import cost_card  # noqa: E402


def expected(tree):
    """Returns the lines of the card; an empty text if there is no results file, or if the newest one lacks the figures of the card.
    File names begin with their date, so the last one is the newest."""
    files = sorted((tree.root / RESULTS).glob("*.json")) if (tree.root / RESULTS).is_dir() else []
    if not files:
        return ""
    lines = cost_card(json.loads(files[-1].read_text()))
    return "\n".join([*lines, f"Measured on {files[-1].stem[:10]}."]) + "\n" if lines else ""


def check(tree):
    page = tree.root / PAGE
    found = CARD.search(page.read_text()) if page.exists() else None
    if not found:
        return [f"{PAGE}:1: has no cost card"]
    wanted = expected(tree)
    if not wanted:
        return [f"{RESULTS}:1: no file has the figures of the cost card"]
    return [] if found.group(1) == wanted else [f"{PAGE}:1: the cost card is not that of the newest file in {RESULTS}; tools/refresh rewrites it"]


def refresh(tree):
    """Writes the card into the page. Returns true if the page changed."""
    page = tree.root / PAGE
    before, card = page.read_text(), expected(tree)
    after = CARD.sub(lambda _: f"<!-- cost card -->\n{card}<!-- end of cost card -->\n", before) if card else before
    page.write_text(after)
    return after != before


def results(save_us):
    return json.dumps({"settings": {"cpu": "a processor", "compiler": "12"}, "scenes": [{"scene": "S1", "engines": [{"engine": "Lockstone", "mean_ms": 1.0}]}],
                       "state": [{"scene": "S1", "bodies": 10, "save_us": save_us, "restore_us": 1, "hash_us": 1, "memcpy_us": 1, "bytes_per_body": 500,
                                  "rollbacks": [{"depth": 8, "rollback_us": 9, "ratio": 1.1}]}]})


class AtRoot:
    """A tree that has only a root: expected() reads nothing else of it."""

    def __init__(self, root):
        self.root = root


def page_of(files):
    import tempfile
    with tempfile.TemporaryDirectory() as folder:
        for path, text in files.items():
            target = pathlib.Path(folder) / path
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(text)
        return f"<!-- cost card -->\n{expected(AtRoot(pathlib.Path(folder)))}<!-- end of cost card -->\n"


OLD, NEW = f"{RESULTS}/2026-01-01.json", f"{RESULTS}/2026-01-02.json"
TRUE = page_of({NEW: results(5)})
PLANTED = [
    ("no cost card", {PAGE: "# Lockstone\n", NEW: results(5)}),
    ("no results", {PAGE: TRUE}),
    ("the card of older results", {PAGE: page_of({OLD: results(4)}), OLD: results(4), NEW: results(5)}),
    ("a figure written by hand", {PAGE: TRUE.replace("500", "400"), NEW: results(5)}),
]
GOOD = [("a card that is true", {PAGE: TRUE, OLD: results(4), NEW: results(5)})]
