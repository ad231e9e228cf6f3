"""The library says what is wrong, the program what to type: no string in src/ outside src/cli names an
option ("--name", "-o FILE")."""
import re
import sys
from pathlib import Path

root = Path(__file__).resolve().parents[2] / "src"
# comments, strings and characters, whichever begins first
token = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'', re.S)
option = re.compile(r"--[a-z]")


def literals(text):
    return [match for match in token.finditer(text) if match.group().startswith('"')]


assert [m.group() for m in literals('f( "a--b", \'"\' ); // "--no"\n/* "--no" */ "\\"--yes"')] == ['"a--b"', '"\\"--yes"']
found = 0
files = sorted(path for path in root.rglob("*.[ch]") if "cli" not in path.relative_to(root).parts)
for path in files:
    text = path.read_text(encoding="utf-8")
    for match in literals(text):
        if option.search(match.group()):
            line = text.count("\n", 0, match.start()) + 1
            print(f"{path}:{line}: names an option: {match.group()}", file=sys.stderr)
            found += 1
assert len(files) > 100
sys.exit(1 if found else 0)
