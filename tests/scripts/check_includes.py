#!/usr/bin/env python3
"""Checks the direction of dependencies in src/: folders depend downwards only (the order below, which
src/README.md explains), headers include no circle, public headers include only each other, and no
source files call each other in a circle except where listed.

    check_includes.py [SOURCE-FOLDER] [--circles]    --circles prints the circles of calls between files
"""
import os
import re
import sys

# What a folder may include besides itself and what stands before it. Each line is one level.
LEVELS = [["reframe"], ["base", "math"], ["bsdf"], ["image"], ["scene"], ["light"], ["trace"], ["path"], ["film"], ["render"], ["reuse"],
          ["estimators"], ["output"], ["measure", "page", "convert"], ["cli", "import"]]


def sources(top):
    for folder, _, files in os.walk(os.path.join(top, "src")):
        for file in sorted(files):
            if file.endswith((".c", ".h")):
                yield os.path.relpath(os.path.join(folder, file), os.path.join(top, "src"))


def includes(text):
    return re.findall(r'^\s*#\s*include\s+["<]((?:[a-z_]+/)+[a-z0-9_]+\.h)[">]', text, re.M)


def strip(text):
    text = re.sub(r"/\*.*?\*/", "", text, flags=re.S)
    return re.sub(r"//[^\n]*", "", text)


def circles(graph):
    """Strongly connected components of more than one node (Tarjan)."""
    index, low, stack, on, found = {}, {}, [], set(), []

    def visit(node):
        index[node] = low[node] = len(index)
        stack.append(node)
        on.add(node)
        for other in sorted(graph.get(node, ())):
            if other not in index:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in on:
                low[node] = min(low[node], index[other])
        if low[node] == index[node]:
            part = []
            while True:
                part.append(stack.pop())
                on.discard(part[-1])
                if part[-1] == node:
                    break
            if len(part) > 1:
                found.append(sorted(part))

    sys.setrecursionlimit(10000)
    for node in sorted(graph):
        if node not in index:
            visit(node)
    return sorted(found)


def call_graph(texts):
    defined = {}
    for name, text in texts.items():
        if name.endswith(".c"):
            for match in re.finditer(r"^(?!static|extern|#|typedef|return)[A-Za-z_][\w \*]*?\b(rf_\w+)\s*\([^;{]*\)\s*\{", text, re.M):
                defined[match.group(1)] = name
    graph = {}
    for name, text in texts.items():
        if name.endswith(".c"):
            graph[name] = {defined[word] for word in set(re.findall(r"\brf_\w+", text)) if word in defined} - {name}
    return graph


def main():
    arguments = [a for a in sys.argv[1:] if not a.startswith("--")]
    top = arguments[0] if arguments else os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
    texts = {}
    for name in sources(top):
        with open(os.path.join(top, "src", name)) as file:
            texts[name] = strip(file.read())
    level = {folder: i for i, folders in enumerate(LEVELS) for folder in folders}
    bad = []
    for name, text in texts.items():
        folder = name.split("/")[0]
        if folder not in level:
            bad.append("src/%s: folder src/%s is in no level of check_includes.py" % (name, folder))
            continue
        for other in includes(text):
            if other not in texts:
                continue
            to = other.split("/")[0]
            if to != folder and level.get(to, 99) >= level[folder]:
                bad.append("src/%s: includes %s, which is not below it" % (name, other))
            if folder == "reframe" and to != "reframe":
                bad.append("src/%s: a public header includes %s" % (name, other))
    headers = {name: {o for o in includes(text) if o in texts} for name, text in texts.items() if name.endswith(".h")}
    for part in circles(headers):
        bad.append("headers include each other: " + ", ".join(part))
    calls = circles(call_graph(texts))
    if "--circles" in sys.argv:
        for part in calls:
            print("%d files call each other: %s" % (len(part), ", ".join(part)))
    for part in calls:
        folders = {os.path.dirname(name) for name in part}
        if len(folders) > 1:
            bad.append("files of several folders call each other: " + ", ".join(part))
    for line in bad:
        print(line)
    print("check_includes: %d files, %d faults" % (len(texts), len(bad)))
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
