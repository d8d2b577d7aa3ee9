#!/usr/bin/env python3
"""Licences of what is linked into the program and into the Python package, as a THIRD_PARTY_NOTICES.txt each; with --check, whether
these files are up to date.

    tools/notices.py [--check]

Takes the crates that `cargo metadata` resolves for them on Linux, with every feature that ships, and the licence files
in their packages. A text that several crates share stands once. A crate without a licence file has its repository's in
tools/licences/, or must offer Apache-2.0, whose text names nobody; any other ends the script with an error.
"""
import argparse
import json
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
# Workspaces, and what of them is passed on.
PASSED_ON = [(ROOT, "fingerpost-cli"), (ROOT / "python", "fingerpost-python")]
PLATFORM = "x86_64-unknown-linux-gnu"
LICENCE_FILE = re.compile(r"(?i)^(un)?licen[cs]e|^copying|^copyright|^notice")
HEAD = """Fingerpost is licensed under MIT OR Apache-2.0. The program holds the works below; each is under the licence that follows it.

Map data in the program's demonstration: (c) OpenStreetMap contributors, Open Database License (ODbL) 1.0,
https://www.openstreetmap.org/copyright. See crates/fingerpost-sim/assets/ATTRIBUTION.md.

The Rust standard library: (c) the Rust Project contributors, MIT OR Apache-2.0; the Apache License is below.

The static binary and the Debian package also hold musl's C library: (c) 2005-2020 Rich Felker, et al., MIT; the MIT License is below.
"""


def linked_packages(workspace, program):
    """Packages that a program links, without those of this repository, by name and version."""
    command = ["cargo", "metadata", "--format-version", "1", "--locked", "--all-features", "--filter-platform", PLATFORM]
    metadata = json.loads(subprocess.run(command, cwd=workspace, check=True, capture_output=True, text=True).stdout)
    packages = {package["id"]: package for package in metadata["packages"]}
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    waiting = [id for id, package in packages.items() if package["name"] == program]
    linked = set()
    while waiting:
        id = waiting.pop()
        if id in linked:
            continue
        linked.add(id)
        for dependency in nodes[id]["deps"]:
            is_normal = any(kind["kind"] is None for kind in dependency["dep_kinds"])
            is_macro = all("proc-macro" in target["kind"] for target in packages[dependency["pkg"]]["targets"]
                           if "custom-build" not in target["kind"] and set(target["kind"]) & {"lib", "proc-macro"})
            if is_normal and not is_macro:
                waiting.append(dependency["pkg"])
    foreign = (packages[id] for id in linked if packages[id]["source"] is not None)
    return sorted(foreign, key=lambda package: (package["name"], package["version"]))


def licence_texts(package):
    """The texts of the licence files in a package."""
    folder = pathlib.Path(package["manifest_path"]).parent
    files = sorted(path for path in folder.iterdir() if path.is_file() and LICENCE_FILE.match(path.name))
    texts = [path.read_text(encoding="utf-8", errors="replace").replace("\r\n", "\n").strip() for path in files]
    if texts:
        return [text for text in texts if text]
    by_hand = ROOT / "tools" / "licences" / f"{package['name']}.txt"
    if by_hand.exists():
        return [by_hand.read_text().strip()]
    expression = package["license"] or ""
    if "Apache-2.0" in expression:
        return [(ROOT / "LICENSE-APACHE").read_text().strip()]
    sys.exit(f"{package['name']} {package['version']} ({expression}) has no licence file; add its repository's as tools/licences/{package['name']}.txt")


def notices(workspace, program):
    first_of, users = {}, {}
    for package in linked_packages(workspace, program):
        for text in licence_texts(package):
            # The same licence is laid out in many ways.
            text = first_of.setdefault(" ".join(text.split()), text)
            users.setdefault(text, []).append(f"{package['name']} {package['version']} ({package['license']})")
    parts = [HEAD]
    for text, names in sorted(users.items(), key=lambda item: (-len(item[1]), item[1])):
        parts.append("=" * 100 + "\n" + "\n".join(dict.fromkeys(names)) + "\n" + "-" * 100 + "\n" + text + "\n")
    return "\n".join(parts)


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--check", action="store_true", help="change nothing; fail where the file is not up to date")
    check = arguments.parse_args().check
    for workspace, program in PASSED_ON:
        path = workspace / "THIRD_PARTY_NOTICES.txt"
        text = notices(workspace, program)
        if not check:
            path.write_text(text, encoding="utf-8")
        elif not path.exists() or path.read_text(encoding="utf-8") != text:
            sys.exit(f"{path.relative_to(ROOT)} is not that of its Cargo.lock; run tools/notices.py and commit it")


main()
