#!/usr/bin/env python3
"""Makes the book's page of settings, docs/src/settings.md, from `fingerpost schema`.

    python3 tools/settings_page.py target/release/fingerpost            # writes the page
    python3 tools/settings_page.py target/release/fingerpost --check    # fails where the page is another
"""
import json
import re
import subprocess
import sys
from pathlib import Path

PAGE = Path(__file__).resolve().parent.parent / "docs/src/settings.md"
INTRODUCTION = """\
# Settings

<!-- Made by tools/settings_page.py from `fingerpost schema`. Do not edit: change the program and run it again. -->

Every key is optional; what is left out has its default. Give a file of settings with `--config`. Unknown keys and values out of range
are refused with the key's name. The settings that were in force are in `config.toml` of every run folder. `fingerpost schema` prints
this page's content as a JSON Schema, which editors use to complete and check TOML files.
"""


def cell(text):
    """Text as it can stand in a table's cell."""
    return " ".join(str(text).split()).replace("|", "\\|")


def literal(value):
    return "none" if value is None else f"`{cell(json.dumps(value, ensure_ascii=False))}`"


def bounds(schema):
    low, high = schema.get("minimum"), schema.get("maximum")
    return f"{low:g} to {high:g}" if low is not None and high is not None else ""


def allowed(schema):
    """What values a key takes."""
    if "oneOf" in schema:
        return ", ".join(literal(choice["const"]) for choice in schema["oneOf"])
    if "anyOf" in schema:
        return " or ".join(str(choice["type"]) for choice in schema["anyOf"])
    if schema.get("type") == "boolean":
        return "`true`, `false`"
    if schema.get("type") == "array":
        items = schema["items"]
        number = f'{schema["minItems"]} of ' if "minItems" in schema and schema["minItems"] == schema.get("maxItems") else "list of "
        return f"{number}{bounds(items)}"
    if "minimum" in schema:
        return bounds(schema)
    return "text" if "string" in schema.get("type", "") else ""


def meaning(schema):
    text = schema["description"]
    choices = [f'{literal(choice["const"])}: {choice["description"]}' for choice in schema.get("oneOf", []) if choice.get("description")]
    # Names of Rust items in brackets are for rustdoc alone.
    return cell(re.sub(r" \(\[`\w+`\](; [^)]*)?\)", lambda found: f" ({found[1][2:]})" if found[1] else "", " ".join([text, *choices])))


def sections(schema, path):
    """One Markdown section for each table of the configuration, with the tables within it after it."""
    properties = schema["properties"]
    keys = {name: inner for name, inner in properties.items() if "properties" not in inner}
    tables = {name: inner for name, inner in properties.items() if "properties" in inner}
    if path:
        yield f"\n{'#' * min(1 + len(path), 4)} `[{'.'.join(path)}]`\n\n{cell(schema.get('description', ''))}\n"
    if keys:
        yield "\n| key | default | values | unit | meaning |\n|---|---|---|---|---|\n"
        for name, inner in keys.items():
            columns = [f"`{name}`", literal(inner["default"]), allowed(inner), inner.get("x-unit", ""), meaning(inner)]
            yield f"| {' | '.join(columns)} |\n"
    for name, inner in tables.items():
        yield from sections(inner, [*path, name])


def main():
    arguments = [argument for argument in sys.argv[1:] if argument != "--check"]
    if len(arguments) != 1:
        sys.exit(__doc__)
    printed = subprocess.run([arguments[0], "schema"], check=True, capture_output=True, text=True).stdout
    page = INTRODUCTION + "".join(sections(json.loads(printed), []))
    if "--check" not in sys.argv:
        PAGE.write_text(page, encoding="utf-8")
    elif not PAGE.exists() or PAGE.read_text(encoding="utf-8") != page:
        sys.exit(f"{PAGE.name} is not what the schema says: run python3 tools/settings_page.py {arguments[0]}")


main()
