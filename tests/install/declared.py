"""The functions that the public headers declare: declared.py FOLDER, a name on each line."""
import re
import sys
from pathlib import Path

names = set()
for header in Path(sys.argv[1]).glob("*.h"):
    text = re.sub(r"//[^\n]*", "", header.read_text())
    text = re.sub(r"^#(?:[^\n]*\\\n)*[^\n]*", "", text, flags=re.M)  # macros, with their further lines
    text = re.sub(r"static inline [^{]*\{[^}]*\}", "", text)
    text = re.sub(r"typedef void \w+\([^;]*;", "", text)  # types of callbacks
    names.update(re.findall(r"\b(rf_\w+)\(", text))
print("\n".join(sorted(names)))
