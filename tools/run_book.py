#!/usr/bin/env python3
"""Runs what README and book say, and checks their links.

    python3 tools/run_book.py target/release/fingerpost [PAGE ...]

Of every page (README, CONTRIBUTING and the book; or of the PAGEs named) the blocks run in their order, in one shell and one new folder a
page, which is removed afterwards. `fingerpost` is the program given; the folders examples, viewers and crates and papers.toml are those of the
repository. The first word after a fence says what a block is, the second one more:

    sh          run by bash; the first command that fails ends the page
    sh ci       too long to run here: every line must stand in .ci/run, which runs it
    toml        must parse; `toml NAME` is also written to the file NAME of the page's folder, for the blocks after it
    json        must parse
    python NAME stands in python/examples/NAME, which CI runs
    console     needs the reader's own data, a display, a device or hours; not run
    text        output, formats, equations; not run

Relative links of these pages, ARCHITECTURE, CONVENTIONS and docs/papers.md must lead to a file, and anchors to a heading or a named place there.
"""
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
import time
import tomllib
from pathlib import Path
from urllib.parse import unquote

ROOT = Path(__file__).resolve().parent.parent
BOOK = ROOT / "docs/src"
LENT = ["crates", "examples", "viewers", "papers.toml"]
TIMEOUT_S = 300
FENCE = re.compile(r"^(?P<indent> *)```(?P<info>.*)$")


def blocks_and_prose(text):
    """The fenced blocks of a page as (line, info, text), and its text without them, line numbers kept."""
    blocks, prose, fence = [], [], None
    for number, line in enumerate(text.splitlines(), 1):
        found = FENCE.match(line)
        if fence is None and found:
            fence = (number, found["info"].split(), len(found["indent"]), [])
            prose.append("")
        elif fence is not None and found:
            blocks.append((fence[0], fence[1], "\n".join(fence[3]) + "\n"))
            fence = None
            prose.append("")
        elif fence is not None:
            fence[3].append(line[fence[2]:])
            prose.append("")
        else:
            prose.append(line)
    if fence is not None:
        blocks.append((fence[0], ["(not closed)"], ""))
    return blocks, "\n".join(prose)


def anchors(text):
    """The anchors of a page's headings, as GitHub and mdBook make them, and those that it names itself."""
    found, seen = set(), {}
    for heading in re.findall(r"^#{1,6} +(.*?)#* *$", blocks_and_prose(text)[1], re.MULTILINE):
        plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading)
        anchor = re.sub(r"[^\w\- ]", "", plain.lower()).strip().replace(" ", "-")
        again = seen.get(anchor, 0)
        seen[anchor] = again + 1
        found.add(anchor if again == 0 else f"{anchor}-{again}")
    return found | set(re.findall(r'<a id="([^"]+)"', text))


def check_links(page):
    """What is wrong with the links of a page."""
    prose = re.sub(r"`[^`\n]*`", lambda code: " " * len(code[0]), blocks_and_prose(page.read_text(encoding="utf-8"))[1])
    for link in re.finditer(r"\]\(([^()\s]+)\)|^\[[^\]]+\]: +(\S+)", prose, re.MULTILINE):
        target = link[1] or link[2]
        if re.match(r"[a-z][a-z+.-]*:", target):
            continue
        line = prose.count("\n", 0, link.start()) + 1
        path, _, anchor = unquote(target).partition("#")
        file = (page.parent / path).resolve() if path else page
        if not file.exists():
            yield f"{page.relative_to(ROOT)}:{line}: {target} leads nowhere"
        elif anchor and (file.suffix != ".md" or anchor not in anchors(file.read_text(encoding="utf-8"))):
            yield f"{page.relative_to(ROOT)}:{line}: {target} names no place there"


def check_summary(pages):
    """What of the book SUMMARY.md lacks."""
    listed = {(BOOK / target).resolve() for target in re.findall(r"\]\(([^)]+\.md)\)", (BOOK / "SUMMARY.md").read_text(encoding="utf-8"))}
    for page in pages:
        if BOOK in page.parents and page.name != "SUMMARY.md" and page not in listed:
            yield f"{page.relative_to(ROOT)}: not in SUMMARY.md"


def check_block(info, text):
    """What is wrong with a block as it stands, or nothing."""
    match info:
        case ["sh"] | ["console"] | ["text"]:
            return None
        case ["sh", "ci"]:
            run = " ".join((ROOT / ".ci/run").read_text(encoding="utf-8").split())
            missing = [line for line in text.splitlines() if " ".join(line.split("#")[0].split()) not in run]
            return f".ci/run does not run: {missing[0]}" if missing else None
        case ["python", name]:
            example = ROOT / "python/examples" / name
            return None if example.is_file() and text in example.read_text(encoding="utf-8") else f"it does not stand in python/examples/{name}"
        case ["toml"] | ["toml", _]:
            try:
                tomllib.loads(text)
            except tomllib.TOMLDecodeError as wrong:
                return str(wrong)
            return None
        case ["json"]:
            try:
                json.loads(text)
            except json.JSONDecodeError as wrong:
                return str(wrong)
            return None
    return f"a block of this kind is neither run nor checked: {' '.join(info) or '(no kind)'}"


def run_page(page, environment):
    """Checks a page's blocks and runs them in one shell, in a new folder; says what is wrong and how many ran."""
    blocks = blocks_and_prose(page.read_text(encoding="utf-8"))[0]
    wrong = [f"{page.relative_to(ROOT)}:{line}: {problem}" for line, info, text in blocks if (problem := check_block(info, text))]
    with tempfile.TemporaryDirectory(prefix="fingerpost-book-") as name:
        folder, aside, script = Path(name) / "page", Path(name) / "blocks", []
        folder.mkdir()
        aside.mkdir()
        for entry in LENT:
            (folder / entry).symlink_to(ROOT / entry)
        for line, info, text in blocks:
            if info == ["sh"] or (info[:1] == ["toml"] and len(info) == 2):
                (aside / str(line)).write_text(text, encoding="utf-8")
                script.append(f"echo {line} >../reached")
                script.append(f"source ../blocks/{line}" if info == ["sh"] else f"cp ../blocks/{line} {shlex.quote(info[1])}")
        ran = sum(line.startswith("source") for line in script)
        if ran:
            try:
                done = subprocess.run(["bash", "-euo", "pipefail", "-c", "\n".join(script)], cwd=folder, env=environment,
                                      stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=TIMEOUT_S, check=False)
                failed = f"exit code {done.returncode}\n{done.stdout[-1500:]}{done.stderr[-1500:]}" if done.returncode else None
            except subprocess.TimeoutExpired:
                failed = f"the page is not done after {TIMEOUT_S} s"
            if failed:
                wrong.append(f"{page.relative_to(ROOT)}:{(Path(name) / 'reached').read_text().strip()}: {failed}")
    return wrong, ran


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    program = Path(sys.argv[1]).resolve()
    book = sorted(path.resolve() for path in BOOK.rglob("*.md"))
    pages = [Path(name).resolve() for name in sys.argv[2:]] or [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *book]
    linked = [*pages, *(ROOT / name for name in ("ARCHITECTURE.md", "CONVENTIONS.md", "docs/papers.md", "viewers/README.md"))]
    wrong = [*check_summary(book), *(problem for page in dict.fromkeys(linked) for problem in check_links(page))]
    with tempfile.TemporaryDirectory(prefix="fingerpost-book-") as name:
        (Path(name) / "fingerpost").symlink_to(program)
        environment = {**os.environ, "PATH": f"{name}:{os.environ['PATH']}"}
        for page in pages:
            began = time.monotonic()
            problems, ran = run_page(page, environment)
            wrong += problems
            if ran:
                print(f"{page.relative_to(ROOT)}: {ran} blocks, {time.monotonic() - began:.0f} s", flush=True)
    for problem in wrong:
        print(problem, file=sys.stderr)
    sys.exit(1 if wrong else 0)


main()
