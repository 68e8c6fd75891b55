#!/usr/bin/env python3
"""A preprocessor of mdBook: links that lead out of docs/ lead to the repository, as nothing else of it is in the book.

Reads the book from standard input and writes it to standard output, as mdBook has it (docs/book.toml).
"""

import json
import posixpath
import re
import sys

LINK = re.compile(r"\]\(([^)\s:]+)\)")


def outside(link, folder):
    """The path in the repository that a link of a page in this folder of docs/ leads to; None where it stays in docs/."""
    path, hash_sign, anchor = link.partition("#")
    target = posixpath.normpath(posixpath.join("docs", folder, path))
    return None if not path or target.startswith("docs/") or target == "docs" else target + hash_sign + anchor


def rewrite(item, repository):
    chapter = item.get("Chapter") if isinstance(item, dict) else None
    if not chapter:
        return
    folder = posixpath.dirname(chapter["path"] or "")

    def replace(match):
        target = outside(match[1], folder)
        return match[0] if target is None else f"]({repository}/blob/main/{target})"

    chapter["content"] = LINK.sub(replace, chapter["content"])
    for below in chapter["sub_items"]:
        rewrite(below, repository)


def main():
    # `supports RENDERER` is asked first; any is.
    if sys.argv[1:2] == ["supports"]:
        return
    context, book = json.load(sys.stdin)
    repository = context["config"]["output"]["html"]["git-repository-url"]
    for item in book["items"]:
        rewrite(item, repository)
    json.dump(book, sys.stdout)


main()
