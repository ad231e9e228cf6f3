#!/usr/bin/env python3
"""Renders survive faults: a call that fails, a kill, a second program at the same sequence, a folder that goes away.

    test_faults.py PROGRAM SHIM SCENE

SHIM is fail_one_call.c as a library. Every open, read, write, fsync, rename, close and allocation of a small render fails
once, in a run of its own. Each run must end with the right frames, or with one line that says why, no half frame and no
temporary file; --resume then completes it to the same bytes. REFRAME_LONG=1 takes every call and 1,000 kills; without it,
of writes and allocations a few dozen are taken, the kills are 50.
"""
import concurrent.futures
import json
import os
import random
import resource
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

PROGRAM, SHIM, SCENE = sys.argv[1:4] if len(sys.argv) > 3 else (None, None, None)
LONG = os.environ.get("REFRAME_LONG") is not None
SHOT = ["--size", "16x9", "--group", "1", "--tile", "1", "--frames", "1-3", "--threads", "2", "--quiet"]
MOST = {"write": 8, "alloc": 24}  # runs of a kind, in short
KILLS = 1000 if LONG else 50
PATIENCE = 600.0  # seconds, after which a run hangs, on a busy machine too


def command(folder, *more, spp=2):
    return [PROGRAM, "render", SCENE, "-o", os.path.join(folder, "f.####.exr"), *SHOT, "--spp", str(spp), *more]


def run(words, environment=None):
    done = subprocess.run(words, env=dict(os.environ, **(environment or {})), stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          timeout=PATIENCE)
    return done.returncode, done.stderr.decode(errors="replace").strip()


def frames(folder):
    """Bytes by name of all files of a sequence's folder, hidden ones too."""
    found = {}
    for name in os.listdir(folder):
        with open(os.path.join(folder, name), "rb") as file:
            found[name] = file.read()
    return found


def cpu_seconds(pid):
    with open("/proc/%d/stat" % pid) as file:
        fields = file.read().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def mount(folder, *words):
    """As root; False where that is not allowed."""
    try:
        return subprocess.run(["mount", *words, folder], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode == 0
    except OSError:
        return False


class Renders(unittest.TestCase):
    """A small render, and what every run with a fault must leave."""

    @classmethod
    def setUpClass(cls):
        cls.top = tempfile.mkdtemp(prefix="reframe-faults-")
        folder = cls.make_folder()
        status, message = run(command(folder))
        assert status == 0, message
        cls.right = frames(folder)
        assert len(cls.right) == 3

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.top)

    @classmethod
    def make_folder(cls):
        return tempfile.mkdtemp(dir=cls.top)

    def check_no_half_frame(self, folder, what):
        for name, content in frames(folder).items():
            self.assertIn(name, self.right, "%s leaves %s" % (what, name))
            self.assertEqual(content, self.right[name], "%s leaves half of %s" % (what, name))

    def resume(self, folder, what):
        status, message = run(command(folder, "--resume"))
        self.assertEqual(status, 0, "%s: --resume says %s" % (what, message))
        self.assertEqual(frames(folder), self.right, "%s: --resume completes it otherwise" % what)

    def count_calls(self, kind):
        note = os.path.join(self.make_folder(), "count")
        status, message = run(command(self.make_folder()), {"LD_PRELOAD": SHIM, "FAIL_CALL": kind, "FAIL_REPORT": note})
        self.assertEqual(status, 0, message)
        with open(note) as file:
            return int(file.read().split()[0])

    def fail_call(self, kind, number):
        """Returns whether the program noticed."""
        folder, what = self.make_folder(), "%s %d" % (kind, number)
        try:
            status, message = run(command(folder), {"LD_PRELOAD": SHIM, "FAIL_CALL": kind, "FAIL_AT": str(number)})
        except subprocess.TimeoutExpired:
            self.fail("%s: the program hangs" % what)
        if status == 0:
            self.assertEqual(frames(folder), self.right, "%s: exit status 0 without the right frames" % what)
            return False
        self.assertGreater(status, 0, "%s: the program crashes" % what)
        self.assertEqual(message.count("\n"), 0, "%s: more than a line: %s" % (what, message))
        self.assertNotEqual(message, "", "%s: no message" % what)
        if kind == "alloc":
            self.assertRegex(message, "memory|MiB|Embree|libgomp|system limits allow", what)
        self.check_no_half_frame(folder, what)
        self.resume(folder, what)
        shutil.rmtree(folder)
        return True

    def try_call(self, kind, number):
        """The same, or what is wrong, so that a run finds all that is."""
        try:
            return self.fail_call(kind, number)
        except AssertionError as error:
            return str(error)

    def fail_calls(self, kind):
        count = self.count_calls(kind)
        self.assertGreater(count, 2, kind)
        step = 1 if LONG or kind not in MOST else max(count // MOST[kind], 1)
        numbers = range(1 + random.randrange(step), count + 1, step)
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            results = list(pool.map(lambda number: self.try_call(kind, number), numbers))
        noticed, faults = sum(result is True for result in results), [r for r in results if isinstance(r, str)]
        print("%s: %d calls, %d failed, %d noticed" % (kind, count, len(numbers), noticed), flush=True)
        self.assertEqual(faults, [], kind)
        # a close that fails after the bytes are on the disk, or of a file that was read, may go unnoticed
        self.assertGreater(noticed, 0, kind)
        if kind in ("write", "fsync", "rename"):
            self.assertEqual(noticed, len(numbers), "%s that fails unnoticed" % kind)


class Faults(Renders):
    def test_calls_that_fail(self):
        for kind in ("open", "read", "write", "fsync", "rename", "close", "alloc"):
            self.fail_calls(kind)

    def test_kills(self):
        folder, left = self.make_folder(), KILLS
        seconds = 0.05
        finished = 0
        while left > 0:
            program = subprocess.Popen(command(folder, "--resume"), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            try:
                program.wait(random.uniform(0.0, seconds))
            except subprocess.TimeoutExpired:
                program.kill()
                left -= 1
            is_finished = program.wait(PATIENCE) == 0
            kept = {name: content for name, content in frames(folder).items() if not name.startswith(".")}
            for name, content in kept.items():
                self.assertEqual(content, self.right[name], "a kill leaves half of %s" % name)
            if is_finished:
                self.assertEqual(len(kept), len(self.right))
                finished += 1
                folder = self.make_folder()
            seconds *= 0.9 if is_finished else 1.05
        time.sleep(2.5)  # temporary files of the last second may be another program's
        self.resume(folder, "a killed program")
        print("%d kills, %d sequences finished between them" % (KILLS, finished), flush=True)

    def test_two_programs_at_one_sequence(self):
        for more in ([], ["--resume"], ["--overwrite"]):
            folder = self.make_folder()
            both = [subprocess.Popen(command(folder, *more), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) for _ in range(2)]
            messages = [program.communicate(timeout=PATIENCE)[1].decode().strip() for program in both]
            self.assertIn(0, [program.returncode for program in both], messages)
            self.assertEqual(frames(folder), self.right, more)
            for program, message in zip(both, messages):
                self.assertTrue(program.returncode == 0 or (program.returncode > 0 and message and "\n" not in message),
                                message)

    def test_folder_that_goes_away(self):
        folder = self.make_folder()
        program = subprocess.Popen(command(folder, spp=4000), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        while program.poll() is None and cpu_seconds(program.pid) < 0.5:  # it renders by then, on a busy machine too
            time.sleep(0.01)
        shutil.rmtree(folder)
        message = program.communicate(timeout=PATIENCE)[1].decode().strip()
        self.assertGreater(program.returncode, 0, message)
        self.assertEqual(message.count("\n"), 0, message)
        self.assertIn("f.0001.exr", message)

    def check_full(self, folder, limit):
        """A render to a folder without room fails cleanly; returns its line."""
        done = subprocess.run(command(folder), stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=PATIENCE, preexec_fn=limit)
        message = done.stderr.decode().strip()
        self.assertGreater(done.returncode, 0, message)
        self.assertEqual(message.count("\n"), 0, message)
        self.assertIn("make room or write elsewhere", message)
        self.check_no_half_frame(folder, "a full disk")
        return message

    def test_full_disk_for_frames(self):
        folder = self.make_folder()
        most = min(map(len, self.right.values())) - 1  # bytes that a file may have: no frame has room
        message = self.check_full(folder, limit=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (most, most)))
        self.assertIn("f.0001.exr", message)
        self.assertEqual(frames(folder), {})
        self.resume(folder, "after a full disk")

    def test_full_file_system_for_frames(self):
        folder = self.make_folder()
        pages = 4096 * (1 + max(map(len, self.right.values())) // 4096)
        if not mount(folder, "-t", "tmpfs", "-o", "size=%d" % (2 * pages), "tmpfs"):
            self.skipTest("no tmpfs can be mounted here: only root can")
        try:
            for _ in range(2):  # the first frame has room, perhaps the second, not the third
                with open(os.path.join(folder, "f.0003.exr.other"), "wb") as file:
                    file.write(b"x" * pages)
                status, message = run(command(folder, "--resume", "--autosave", "0"))
                self.assertGreater(status, 0, message)
                self.assertRegex(message, "^[^\n]*No space left[^\n]*make room[^\n]*$")
                os.remove(os.path.join(folder, "f.0003.exr.other"))
                self.check_no_half_frame(folder, "a full file system")
            self.assertTrue(mount(folder, "-o", "remount,size=%d" % (8 * pages), "tmpfs"))
            self.resume(folder, "with room again")
        finally:
            subprocess.run(["umount", folder], check=True)

    def test_read_only_folder(self):
        folder = self.make_folder()
        if os.geteuid() != 0:
            os.chmod(folder, 0o500)
        elif not mount(folder, "-t", "tmpfs", "-o", "ro", "tmpfs"):
            self.skipTest("root writes everywhere, and no file system can be mounted here")
        try:
            for more in ([], ["--resume"], ["--overwrite"]):
                status, message = run(command(folder, *more, spp=65536))  # told before the work: that would take hours
                self.assertGreater(status, 0)
                self.assertRegex(message, "^[^\n]*cannot be written: (Read-only|Permission)[^\n]*$")
            self.assertEqual(frames(folder), {})
        finally:
            if os.geteuid() == 0:
                subprocess.run(["umount", folder], check=True)

    @unittest.skipUnless(os.path.exists("/dev/full"), "no /dev/full here")
    def test_full_disk_for_results(self):
        status, message = run(command(self.make_folder(), "--json", "/dev/full"))
        self.assertGreater(status, 0)
        self.assertRegex(message, "^reframe render: .*/dev/full.*No space left[^\n]*$")


class WhatMoves(Renders):
    """Allocations alone, in a scene of which a part is posed for every frame."""

    @classmethod
    def setUpClass(cls):
        global SCENE
        cls.still, cls.beside = SCENE, tempfile.mkdtemp(prefix="reframe-faults-")
        keys = [{"time": k, "translation": [k, 0.75, -1.3]} for k in (0, 0.5)]
        SCENE = os.path.join(cls.beside, "moves.json")
        os.symlink(os.path.abspath(cls.still), os.path.join(cls.beside, "s.glb"))
        with open(SCENE, "w") as out:  # jansson loses characters of long strings where it has no memory
            json.dump({"scene": "s.glb", "objects": [{"node": "vase", "keys": keys}]}, out)
        super().setUpClass()

    @classmethod
    def tearDownClass(cls):
        global SCENE
        super().tearDownClass()
        shutil.rmtree(cls.beside)
        SCENE = cls.still

    def test_allocations_that_fail(self):
        self.fail_calls("alloc")


if __name__ == "__main__":
    if PROGRAM is None:
        sys.exit(__doc__)
    unittest.main(argv=sys.argv[:1])
