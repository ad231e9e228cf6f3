"""Warnings and errors. Warnings are printed at once and repeated at the end, where they are read."""
import os
import sys

_warnings = []


def printable(text):
    """One line: the names of a .blend may hold anything, also what a terminal obeys."""
    return "".join(c if c.isprintable() else "?" for c in text)


def warn(text):
    text = printable(text)
    _warnings.append(text)
    print("blender-export: warning: " + text, file=sys.stderr)


def warnings():
    return list(_warnings)


def repeat_warnings():
    """Prints all warnings again; called last, after Blender's own pages of output."""
    sys.stdout.flush()
    for text in _warnings:
        print("blender-export: warning: " + text, file=sys.stderr)
    sys.stderr.flush()


def fail(text):
    print("blender-export: " + printable(text), file=sys.stderr)
    sys.stderr.flush()
    os._exit(1)  # after an exception Blender would exit with status 0
