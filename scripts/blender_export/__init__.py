"""The parts of blender-export.py, which runs inside Blender."""
