#!/usr/bin/env python3
"""Checks a Dockerfile: builds it and starts the image where docker can be used and has its base images, else lints it.

    python3 tools/check_dockerfile.py [DOCKERFILE]

Lints by hadolint, which must be in PATH, and by what hadolint does not know: the compiler is the one that Cargo.toml promises; what is copied
exists, here and not in .dockerignore, or in the stage that is named; cargo builds what Cargo.lock says and makes the file that is
copied; the last stage builds nothing, has no root and starts the program that was copied into it.
"""
import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BUILD_TOOLS = re.compile(r"\b(cargo|rustc|rustup|gcc|g\+\+|clang|cmake|make|build-essential|git|[\w.+-]+-dev)\b")
SYSTEM_PATH = ["/usr/local/bin", "/usr/bin", "/bin"]


def instructions(text):
    """The instructions as (word, rest), lines that go on joined, comments left out."""
    lines = "\n".join(line for line in text.splitlines() if not line.lstrip().startswith("#"))
    joined = re.sub(r"\\\n\s*", " ", lines)
    return [tuple(line.split(None, 1)) for line in joined.splitlines() if line.strip()]


def stages(text):
    """The stages as (name or None, image, instructions)."""
    found = []
    for word, rest in instructions(text):
        if word.upper() == "FROM":
            image, *named = re.split(r"\s+as\s+", rest.strip(), flags=re.IGNORECASE)
            found.append((named[0] if named else None, image, []))
        elif found:
            found[-1][2].append((word.upper(), rest.strip()))
    return found


def copies(stage):
    """What a stage copies, as (stage it is from or None, sources, target)."""
    for word, rest in stage[2]:
        if word in ("COPY", "ADD"):
            options = re.findall(r"--(\w+)=(\S+)", rest)
            *sources, target = [part for part in rest.split() if not part.startswith("--")]
            yield dict(options).get("from"), sources, target


def ignored():
    """What .dockerignore keeps out, as patterns of Path.match."""
    lines = (ROOT / ".dockerignore").read_text(encoding="utf-8").splitlines()
    return [line.strip().removeprefix("**/") for line in lines if line.strip() and not line.startswith("#")]


def copied_from_here(source):
    """What is wrong with a source of a copy from the repository."""
    if not (ROOT / source).exists():
        return f"{source} is copied and does not exist"
    if any(Path(source).match(pattern) for pattern in ignored()):
        return f"{source} is copied and .dockerignore keeps it out"
    return None


def problems(text):
    """What is wrong with a Dockerfile."""
    all_stages = stages(text)
    if len(all_stages) < 2:
        yield "there is one stage alone: what builds would be shipped"
        return
    named = {name: (image, steps) for name, image, steps in all_stages if name}
    last = all_stages[-1]
    rust = tomllib.loads((ROOT / "Cargo.toml").read_text(encoding="utf-8"))["workspace"]["package"]["rust-version"]
    builders = [image for _, image, _ in all_stages[:-1] if image.startswith("rust:")]
    if not builders or any(not image.startswith(f"rust:{rust}-") for image in builders):
        yield f"the compiler's image is {', '.join(builders) or 'none'}, and Cargo.toml promises Rust {rust}"
    for stage in all_stages:
        for origin, sources, target in copies(stage):
            if origin is None:
                yield from filter(None, map(copied_from_here, sources))
            elif origin not in named:
                yield f"a copy is from the stage {origin}, which does not exist"
            else:
                steps = named[origin][1]
                builds = [rest for word, rest in steps if word == "RUN" and "cargo build" in rest]
                folder = next((rest for word, rest in reversed(steps) if word == "WORKDIR"), "/")
                for source in sources:
                    if source == f"{folder}/target/release/fingerpost" and any("--release" in rest for rest in builds):
                        continue
                    yield f"{source} is copied and no step of the stage {origin} makes it"
                if any("--locked" not in rest for rest in builds):
                    yield "cargo does not build what Cargo.lock says: give --locked"
    for word, rest in last[2]:
        if word == "RUN" and (tool := BUILD_TOOLS.search(rest)):
            yield f"the last stage has {tool[0]}, which builds"
    if last[1].startswith("rust:") or any(last[1] == name for name in named):
        yield f"the last stage is made of {last[1]}, which builds"
    user = [rest for word, rest in last[2] if word == "USER"]
    if not user or user[-1].split(":")[0] in ("0", "root"):
        yield "the image runs as root: give USER in the last stage"
    entry = [rest for word, rest in last[2] if word == "ENTRYPOINT"]
    programs = [target for _, _, target in copies(last)]
    try:
        started = json.loads(entry[-1])[0] if entry else None
    except json.JSONDecodeError:
        started = None
    if not any(started == target or f"{folder}/{started}" == target for target in programs for folder in SYSTEM_PATH):
        yield f"ENTRYPOINT starts {started}, and no copied program is that"


def docker_builds(path, images):
    """Builds the image and starts it; false where docker cannot be used or lacks a base image."""
    def quiet(*arguments):
        try:
            return subprocess.run(["docker", *arguments], capture_output=True, check=False).returncode == 0
        except FileNotFoundError:
            return False

    if not quiet("info") or not all(quiet("image", "inspect", image) for image in images):
        return False
    subprocess.run(["docker", "build", "--tag", "fingerpost:check", "--file", path, ROOT], check=True)
    said = subprocess.run(["docker", "run", "--rm", "fingerpost:check", "--version"], check=True, capture_output=True, text=True)
    if not said.stdout.startswith("fingerpost "):
        sys.exit(f"the image says {said.stdout!r} to --version")
    return True


def main():
    path = Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "Dockerfile")
    text = path.read_text(encoding="utf-8")
    wrong = list(problems(text))
    for problem in wrong:
        print(f"{path}: {problem}", file=sys.stderr)
    if wrong:
        sys.exit(1)
    if docker_builds(path, [image for _, image, _ in stages(text)]):
        print("the Dockerfile builds, and its image starts")
        return
    linted = subprocess.run(["hadolint", path], check=False)
    if linted.returncode:
        sys.exit(1)
    print("the Dockerfile is linted; NOT BUILT: docker, or a base image, is not here")


main()
