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


def note(text):
    print("blender-export: " + text)


def list_names(names):
    more = " and %d more" % (len(names) - 5) if len(names) > 5 else ""
    return ", ".join("'%s'" % n for n in names[:5]) + more


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
