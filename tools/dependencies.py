#!/usr/bin/env python3
"""Checks that every direct dependency on somebody else's crate is used, and has its reason in DEPENDENCIES.md.

    python3 tools/dependencies.py

Fails where the workspace's manifest names a crate that no member asks for, where a member asks for a crate that its source does not name, and
where the table of DEPENDENCIES.md and the manifests of all workspaces here do not name the same crates.
"""
import re
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SHIPPED = ("src", "fuzz_targets")
TESTS = ("tests", "examples", "benches")


def read(manifest):
    return tomllib.loads(manifest.read_text(encoding="utf-8"))


def asked_for(manifest, kinds=("dependencies", "dev-dependencies")):
    """What a package asks for, as (name, what is said of it), on any platform."""
    for part in (manifest, *manifest.get("target", {}).values()):
        for kind in kinds:
            yield from part.get(kind, {}).items()


def source_of(path):
    """A file's text, with those of the files that it takes in from elsewhere."""
    text = path.read_text(encoding="utf-8")
    taken_in = re.findall(r'^#\[path = "([^"]+)"\]$', text, re.MULTILINE)
    return "\n".join([text, *(source_of(path.parent / other) for other in taken_in)])


def unnamed(folder, manifest):
    """What a package asks for and its source does not name."""
    for kind, places in (("dependencies", SHIPPED), ("dev-dependencies", SHIPPED + TESTS)):
        source = "\n".join(source_of(path) for place in places for path in (folder / place).rglob("*.rs"))
        for name, _ in asked_for(manifest, [kind]):
            word = name.replace("-", "_")
            if not re.search(rf"\b{word}(::|!)|\b(use|extern crate) {word}\b", source):
                yield f"{folder.relative_to(ROOT)} asks for {name}, and its source does not name it"


def is_ours(name, said):
    return name.startswith("fingerpost") or "path" in (said if isinstance(said, dict) else {})


def listed():
    """The crates in the table of DEPENDENCIES.md."""
    text = (ROOT / "DEPENDENCIES.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (`.*?) \|", text, re.MULTILINE)
    return [name for row in rows for name in re.findall(r"`([^`]+)`", row)]


def main():
    shared = read(ROOT / "Cargo.toml")["workspace"]["dependencies"]
    packages = {path.parent: read(path) for path in (*ROOT.glob("crates/*/Cargo.toml"), *ROOT.glob("*/Cargo.toml"))}
    needed = {name: said for manifest in packages.values() for name, said in asked_for(manifest)}
    table = listed()
    foreign = {name for name, said in needed.items() if not is_ours(name, said)}
    wrong = [f"Cargo.toml names {name}, and no crate asks for it" for name in shared if name not in needed]
    wrong += [problem for folder, manifest in packages.items() for problem in unnamed(folder, manifest)]
    wrong += [f"DEPENDENCIES.md has no reason for {name}" for name in sorted(foreign - set(table))]
    wrong += [f"DEPENDENCIES.md has a reason for {name}, and no crate asks for it" for name in sorted(set(table) - foreign)]
    wrong += [f"DEPENDENCIES.md has {name} twice" for name in sorted({name for name in table if table.count(name) > 1})]
    for problem in wrong:
        print(problem, file=sys.stderr)
    sys.exit(1 if wrong else 0)


main()
