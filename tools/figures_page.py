#!/usr/bin/env python3
"""Makes the book's page of figures, docs/src/figures.md, from docs/figures.toml, and keeps figures from standing twice.

    python3 tools/figures_page.py            # writes the page, and the figures that pages quote
    python3 tools/figures_page.py --check    # fails where a page is another, or a figure stands a second time

docs/figures.toml says what its keys mean. Numbers up to twenty are also looked for in words: "7 of 26" and "seven of 26".
"""
import re
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
DATA = ROOT / "docs/figures.toml"
PAGE = ROOT / "docs/src/figures.md"
# What may repeat a figure: the history, and pages that are made of measurements of their own.
APART = [PAGE, ROOT / "docs/papers.md", ROOT / "docs/src/settings.md"]
WORDS = ("zero one two three four five six seven eight nine ten eleven twelve thirteen fourteen fifteen sixteen seventeen eighteen nineteen "
         "twenty").split()
INTRODUCTION = """\
# How good it is

<!-- Made by tools/figures_page.py from docs/figures.toml. Do not edit: change the data and run it again. -->

How good the method is, as measured, stands here once, with how, on what and when it was measured; other pages link to it. What was tried and
given up is [beyond the papers](method/beyond.md). Where a date has a commit, that one brought the figure. Results do not depend on the
machine, times and rates do. How fast every part is stands in [Speed](speed.md), what the papers claim and what comes of it in
[The papers' claims](../papers.md).
"""


def printed(value, unit):
    return f"{value} {unit}" if unit and re.search(r"\d", value) else value


def cells(group, figure):
    """A figure's columns as they are printed."""
    if "columns" not in group:
        return [printed(figure["value"], figure.get("unit", ""))]
    return [printed(value, unit) for value, unit in zip(figure["values"], group["units"], strict=True)]


def section(group):
    """The lines of a group: its title, how it was measured, and its table."""
    yield f"\n## {group['title']}\n"
    yield ". ".join(f"*{name.capitalize()}*: {group[name]}" for name in ("how", "on", "machine", "when") if name in group) + ".\n"
    if "text" in group:
        yield f"{group['text']}\n"
    columns = group.get("columns", ["figure"])
    yield f"| what | {' | '.join(columns)} |"
    yield f"|---|{'---|' * len(columns)}"
    for figure in group["figures"]:
        yield f"| <a id=\"{figure['key']}\"></a>{figure['what']} | {' | '.join(cells(group, figure))} |"


def spellings(text):
    """A pattern for a printed figure: over the end of a line, and with small numbers in words."""
    def word(found):
        number = int(found[0])
        return f"(?:{number}|{WORDS[number]})" if number < len(WORDS) else found[0]

    inner = r"\s+".join(word(found) if (found := re.fullmatch(r"\d+", part)) else re.escape(part) for part in text.split())
    return re.compile(rf"(?<![\w.,-]){inner}(?![\w-]|[.,]\d)", re.IGNORECASE)


def quote(text, key, form):
    """A page with the text of each of its links to a figure as that is printed."""
    return re.sub(rf"\[[^\]]*\](\([^)\s]*figures\.md#{re.escape(key)}\))", lambda link: f"[{form}]{link[1]}", text)


def unmistakable(group, figure):
    """What of a figure may be looked for: all of one, and of a row what has three digits."""
    forms = cells(group, figure) if figure.get("once") else []
    return [form for form in forms if "columns" not in group or len(re.findall(r"\d", form)) >= 3]


def repeats(pages, form, home=None):
    """Where a printed figure stands beside the one time on its own page, if that is among them."""
    for path, text in pages.items():
        for again in list(spellings(form).finditer(text))[path == home:]:
            yield f"{path.relative_to(ROOT)}:{text.count(chr(10), 0, again.start()) + 1}: {form} stands a second time; link to it"


def anchor(title):
    return re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-")


def main():
    data = tomllib.loads(DATA.read_text(encoding="utf-8"))
    figures = [(group, figure) for group in data["group"] for figure in group["figures"]]
    keys = [figure["key"] for _, figure in figures]
    page = INTRODUCTION + "\n".join(line for group in data["group"] for line in section(group)) + "\n"
    places = [*(ROOT / name for name in ("README.md", "ARCHITECTURE.md", "CONTRIBUTING.md")), *sorted((ROOT / "docs").rglob("*.md"))]
    pages = {path: path.read_text(encoding="utf-8") for path in places if path not in APART}
    written = {PAGE: page}
    wrong = []
    for group, figure in figures:
        if "quoted" in figure:
            path = ROOT / figure["quoted"]
            written[path] = quote(written.get(path, pages[path]), figure["key"], cells(group, figure)[0])
            wrong += [] if f"figures.md#{figure['key']})" in written[path] else [f"{figure['quoted']} does not quote {figure['key']}"]
    if "--check" not in sys.argv:
        for path, text in written.items():
            path.write_text(text, encoding="utf-8")
            pages |= {path: text} if path in pages else {}
    wrong += [f"{path.relative_to(ROOT)} is not what {DATA.name} says: run python3 tools/figures_page.py"
             for path, text in written.items() if not path.exists() or path.read_text(encoding="utf-8") != text]
    wrong += [f"{DATA.name}: {key} is there twice" for key in sorted({key for key in keys if keys.count(key) > 1})]
    targets = {*keys, *(anchor(group["title"]) for group in data["group"])}
    for path, text in pages.items():
        wrong += [f"{path.relative_to(ROOT)}: {DATA.name} has no {key}" for key in re.findall(r"figures\.md#([\w-]+)", text) if key not in targets]
    wrong += [problem for group, figure in figures for form in unmistakable(group, figure) for problem in repeats(pages, form)]
    for table in data["stands"]:
        home = ROOT / table["page"]
        wrong += [f"{table['page']}: {DATA.name} says that {form} stands there" for form in table["once"] if not spellings(form).search(pages[home])]
        wrong += [problem for form in table["once"] for problem in repeats(pages, form, home)]
    for problem in wrong:
        print(problem, file=sys.stderr)
    sys.exit(1 if wrong else 0)


main()
